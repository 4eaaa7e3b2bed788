using System;
using System.IO;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;
using Google.Protobuf;
using Grpc.Core;
using NUnit.Framework;
using Sweepstake.GrpcNet;
using Sweepstake.Protocol.V1;

namespace Sweepstake.Tests
{
    /// <summary>Tests games with a real daemon over real gRPC.</summary>
    public sealed class ConnectionTest
    {
        [Test]
        public void AGameIsWelcomedLearnsAndIsAcknowledged()
        {
            using var daemon = new DaemonProcess();
            using Game game = Game.At(daemon.Address, endpoint => endpoint.Handler = Game.Sockets, ExploresFast);
            game.PlayUntilOnline();
            Assert.That(game.Status.SessionId, Is.Not.Empty);
            Assert.That(game.Status.DaemonVersion, Is.EqualTo(SweepstakeLibrary.Version.ToString(3)));
            Assert.That(game.Status.Policy, Is.EqualTo("paper"));
            game.PlayUntil(() => game.Session.SwitchEpoch > 0, "switched by the daemon");
            Assert.That(game.Status.Stats.CommandCount, Is.GreaterThan(0));
            game.PlayUntil(() => game.Status.Beliefs.Length == 3, "updated with the posteriors");
            game.WaitForAcknowledgement();
            Assert.That(game.Session.LastDecision.CommandId, Is.GreaterThan(0));
            Assert.That(game.Connection.Stop(60_000), Is.True);
            Assert.That(game.Status.State, Is.EqualTo(LinkState.Closed));
            Assert.That(game.Status.Stats.SentFrameCount, Is.EqualTo(game.FrameCount), "each frame was sent once, and none was lost");
        }

        [Test]
        public void ADaemonThatComesLaterIsFound()
        {
            string address;
            using (var probe = new DaemonProcess())
                address = probe.Address;
            using Game game = Game.At(address);
            game.PlayUntil(() => game.Status.LastError.Length > 0, "shown that the daemon is absent");
            Assert.That(game.Status.State, Is.Not.EqualTo(LinkState.Online));
            using var daemon = new DaemonProcess(null, Array.Empty<string>(), address);
            game.PlayUntilOnline();
            game.WaitForAcknowledgement();
        }

        [Test]
        public void ADaemonThatIsKilledComesBackAndNothingIsCountedTwice()
        {
            using var daemon = new DaemonProcess();
            using Game game = Game.At(daemon.Address);
            game.PlayUntilOnline();
            game.WaitForAcknowledgement();
            daemon.Kill();
            game.PlayUntil(() => game.Status.State != LinkState.Online, "offline");
            game.Play(500);
            daemon.Restart();
            game.PlayUntilOnline();
            Assert.That(game.Status.Stats.ConnectionCount, Is.EqualTo(2));
            game.WaitForAcknowledgement();
            Assert.That(game.Connection.Stop(60_000), Is.True);
            Assert.That(game.Session.DroppedSampleCount, Is.EqualTo(0));
        }

        [Test]
        public void ADaemonThatStandsStillNeverHoldsAFrame()
        {
            using var daemon = new DaemonProcess();
            using var game = new Game(
                new GrpcTelemetryTransport(new DaemonEndpoint { Address = daemon.Address }),
                options => options.UnacknowledgedMessages = 4,
                options => options.QueueFrames = 64);
            game.PlayUntilOnline();
            game.WaitForAcknowledgement();
            daemon.Pause();
            game.PlayUntil(() => game.Session.DroppedSampleCount > 1000, "dropping frames that the daemon does not read");
            Assert.That(game.Session.LastSample.FrameIndex, Is.EqualTo(game.FrameCount - 1), "each frame was played to its end");
            daemon.Continue();
            game.WaitForAcknowledgement();
        }

        [Test]
        public void AGameOfAnotherProtocolIsRefusedWithTheReason()
        {
            using var daemon = new DaemonProcess();
            using var game = new Game(new NewerGame(new GrpcTelemetryTransport(new DaemonEndpoint { Address = daemon.Address })));
            game.PlayUntil(() => game.Status.Refusal.Length > 0, "refused");
            Assert.That(game.Status.Refusal, Does.Contain("has version 1 of the protocol, the client has version 99").And.Contain("update the older side").And.Contain("PROTOCOL_VERSION"));
            Assert.That(game.Status.LastError, Does.Contain(game.Status.Refusal));
            Assert.That(game.Status.Stats.ConnectionCount, Is.EqualTo(0));
        }

        [Test]
        public void FiftyConnectionsLeaveNoThreadAndNoDescriptor()
        {
            using var daemon = new DaemonProcess();
            for (int cycle = 0; cycle < 5; ++cycle)
                ConnectOnce(daemon);
            int threads = Eventually.ThreadCount();
            int descriptors = Descriptors();
            for (int cycle = 0; cycle < 50; ++cycle)
                ConnectOnce(daemon);
            Assert.That(SessionWork.RunningCount, Is.EqualTo(0));
            Assert.That(SweepstakeLibrary.LiveCount(), Is.EqualTo(0));
            Eventually.HasAtMostThreads(threads);
            Eventually.Is(() => Descriptors() <= descriptors + 4, () => $"{descriptors} descriptors but {Descriptors()}", CollectGarbage);
        }

        [Test]
        public void AFrameAllocatesNothingWhileTheConnectionSends()
        {
            using var daemon = new DaemonProcess();
            using Game game = Game.At(daemon.Address);
            game.PlayUntilOnline();
            ulong awaited = 0;
            Func<bool> isSent = () => game.Status.Stats.SentSequence >= awaited;
            Action play = () => game.Play(10);
            long allocated = Eventually.AllocatedBy(() =>
            {
                awaited = game.Status.Stats.SentSequence + 3;
                Eventually.Is(isSent, () => "sent thrice", play);
            });
            Assert.That(allocated, Is.EqualTo(0));
        }

        private static void CollectGarbage()
        {
            GC.Collect();
            GC.WaitForPendingFinalizers();
        }

        [Test]
        public async Task TheEditorWatchesPosteriorsLiveAndCarriesPriors()
        {
            using var daemon = new DaemonProcess();
            using var other = new DaemonProcess();
            using Game game = Game.At(daemon.Address, null, ExploresFast);
            using var client = new DaemonClient(new DaemonEndpoint { Address = daemon.Address });
            ListPosteriorsResponse listed = null;
            game.PlayUntil(() => HasScenes(client, out listed), "learnt");
            Assert.That(listed.Scenes.Single().Scene, Is.EqualTo("hurricane"));
            Assert.That(listed.Scenes.Single().Arms.Select(arm => arm.Arm), Is.Not.Empty.And.SubsetOf(game.Session.Arms));

            using (var end = new CancellationTokenSource())
            using (AsyncServerStreamingCall<WatchPosteriorsResponse> watch = client.Posteriors.WatchPosteriors(new WatchPosteriorsRequest { Project = "unity" }))
            {
                Task<DecisionEvent> decided = FirstDecision(watch.ResponseStream, end.Token);
                game.PlayUntil(() => decided.IsCompleted, "decided while the watcher reads");
                Assert.That((await decided).SessionId, Is.EqualTo(game.Status.SessionId));
            }

            using var taker = new DaemonClient(new DaemonEndpoint { Address = other.Address });
            Assert.That(await CarryPriors(client, taker), Is.GreaterThan(0));
            var missing = Assert.Throws<RpcException>(
                () => client.Posteriors.GetPosterior(new GetPosteriorRequest { Project = "unity", Scene = "nowhere" }));
            Assert.That(missing.StatusCode, Is.EqualTo(StatusCode.NotFound));
        }

        /// <summary>
        /// Selects the policy "paper". At first it samples from posteriors without evidence, so it tries other arms whatever their costs
        /// are.
        /// </summary>
        private static void ExploresFast(LinkOptions options)
        {
            options.Policy = "paper";
            options.TimeScale = 100;
        }

        private static bool HasScenes(DaemonClient client, out ListPosteriorsResponse listed)
        {
            listed = client.Posteriors.ListPosteriors(new ListPosteriorsRequest { Project = "unity" });
            return listed.Scenes.Count > 0;
        }

        private static async Task<DecisionEvent> FirstDecision(IAsyncStreamReader<WatchPosteriorsResponse> stream, CancellationToken token)
        {
            while (await stream.MoveNext(token))
            {
                if (stream.Current.Decisions.Count > 0)
                    return stream.Current.Decisions[0];
            }
            return null;
        }

        private static async Task<ulong> CarryPriors(DaemonClient from, DaemonClient to)
        {
            using AsyncServerStreamingCall<ExportPriorsResponse> exported = from.Priors.ExportPriors(new ExportPriorsRequest { Project = "unity" });
            using AsyncClientStreamingCall<ImportPriorsRequest, ImportPriorsResponse> imported = to.Priors.ImportPriors();
            while (await exported.ResponseStream.MoveNext(CancellationToken.None))
            {
                var part = new ImportPriorsRequest { Promote = true };
                part.Records.AddRange(exported.ResponseStream.Current.Records);
                await imported.RequestStream.WriteAsync(part);
            }
            await imported.RequestStream.CompleteAsync();
            return (await imported.ResponseAsync).AppliedCount;
        }

        private static void ConnectOnce(DaemonProcess daemon)
        {
            using Game game = Game.At(daemon.Address);
            game.PlayUntilOnline();
        }

        private static int Descriptors() => Directory.GetFileSystemEntries("/proc/self/fd").Length;

        /// <summary>A game that offers protocol version 99 only.</summary>
        private sealed class NewerGame : ITelemetryTransport, ITelemetryStream
        {
            private readonly ITelemetryTransport transport;
            private ITelemetryStream stream;

            internal NewerGame(ITelemetryTransport transport)
            {
                this.transport = transport;
            }

            public StreamEnd End => stream.End;

            public ITelemetryStream Open()
            {
                stream = transport.Open();
                return this;
            }

            public Task WriteAsync(ArraySegment<byte> message)
            {
                StreamTelemetryRequest request = StreamTelemetryRequest.Parser.ParseFrom(message.Array, message.Offset, message.Count);
                request.Hello.ProtocolVersion = 99;
                return stream.WriteAsync(request.ToByteArray());
            }

            public Task FinishAsync() => stream.FinishAsync();

            public Task<byte[]> ReadAsync() => stream.ReadAsync();

            void IDisposable.Dispose() => stream.Dispose();
        }
    }
}
