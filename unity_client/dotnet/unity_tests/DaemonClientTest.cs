using System.Linq;
using System.Threading;
using System.Threading.Tasks;
using Grpc.Core;
using NUnit.Framework;
using Sweepstake.Editor;
using Sweepstake.GrpcNet;
using Sweepstake.Protocol.V1;

namespace Sweepstake.Tests
{
    /// <summary>Tests the messages and stubs that the package ships for its editor with a real daemon.</summary>
    public sealed class DaemonClientTest
    {
        [Test]
        public async Task TheEditorWatchesPosteriorsAndSessionsAndCarriesPriors()
        {
            using var daemon = new DaemonProcess();
            using var other = new DaemonProcess();
            using Game game = Game.At(daemon.Address, null, Game.ExploresFast);
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
            SessionInfo session = client.Sessions.ListSessions(new ListSessionsRequest { Project = "unity" }).Sessions.Single();
            Assert.That((session.SessionId, session.State, session.Scene), Is.EqualTo((game.Status.SessionId, SessionState.Connected, "hurricane")));

            using var taker = new DaemonClient(new DaemonEndpoint { Address = other.Address });
            Assert.That(await CarryPriors(client, taker), Is.GreaterThan(0));
            var missing = Assert.Throws<RpcException>(
                () => client.Posteriors.GetPosterior(new GetPosteriorRequest { Project = "unity", Scene = "nowhere" }));
            Assert.That(missing.StatusCode, Is.EqualTo(StatusCode.NotFound));
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
    }
}
