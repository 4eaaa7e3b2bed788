using System;
using System.IO;
using System.Threading.Tasks;
using Google.Protobuf;
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
            using Game game = Game.At(daemon.Address, endpoint => endpoint.Handler = Game.Sockets, Game.ExploresFast);
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
