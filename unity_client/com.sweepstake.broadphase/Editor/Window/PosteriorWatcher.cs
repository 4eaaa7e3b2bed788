#nullable enable
using System;
#if SWEEPSTAKE_GRPC
using System.Collections.Generic;
using System.Diagnostics;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;
using Grpc.Core;
using Sweepstake.GrpcNet;
using Sweepstake.Protocol.V1;
#endif
using Sweepstake.Unity;

namespace Sweepstake.Editor
{
    /// <summary>
    /// Watches the posteriors of a project through the daemon's own service, on threads of the pool; what is shown reads
    /// <see cref="Latest"/>. It asks, and sends nothing else.
    /// </summary>
    internal sealed class PosteriorWatcher : IDisposable
    {
        private volatile PosteriorSnapshot latest = PosteriorSnapshot.Empty;

        internal PosteriorSnapshot Latest => latest;

        internal bool IsRunning { get; private set; }

#if SWEEPSTAKE_GRPC
        private const int RoundTripIntervalMs = 1000;
        private const int RetryMs = 2000;

        private readonly SortedDictionary<string, ScenePosterior> scenes = new SortedDictionary<string, ScenePosterior>(StringComparer.Ordinal);
        private readonly object gate = new object();
        private CancellationTokenSource? end;

        internal void Start(DaemonSettings settings, string project)
        {
            Dispose();
            try
            {
                var client = new DaemonClient(DaemonTransport.EndpointOf(settings));
                end = new CancellationTokenSource();
                IsRunning = true;
                latest = PosteriorSnapshot.Empty;
                _ = Run(client, project, end.Token);
            }
            catch (Exception problem) when (problem is SweepstakeException || problem is InvalidOperationException || problem is System.IO.IOException)
            {
                latest = new PosteriorSnapshot(Array.Empty<PosteriorLine>(), float.NaN, problem.Message);
            }
        }

        public void Dispose()
        {
            end?.Cancel();
            end = null;
            IsRunning = false;
        }

        private async Task Run(DaemonClient client, string project, CancellationToken token)
        {
            using (client)
                await Task.WhenAll(Task.Run(() => Watch(client, project, token)), Task.Run(() => MeasureRoundTrips(client, project, token)));
        }

        private async Task Watch(DaemonClient client, string project, CancellationToken token)
        {
            while (!token.IsCancellationRequested)
            {
                try
                {
                    using AsyncServerStreamingCall<WatchPosteriorsResponse> call =
                        client.Posteriors.WatchPosteriors(new WatchPosteriorsRequest { Project = project }, cancellationToken: token);
                    while (await call.ResponseStream.MoveNext(token).ConfigureAwait(false))
                        Take(call.ResponseStream.Current.Posterior);
                }
                catch (RpcException problem)
                {
                    Publish(float.NaN, problem.Status.Detail);
                }
                await Wait(RetryMs, token).ConfigureAwait(false);
            }
        }

        private async Task MeasureRoundTrips(DaemonClient client, string project, CancellationToken token)
        {
            while (!token.IsCancellationRequested)
            {
                try
                {
                    var watch = Stopwatch.StartNew();
                    await client.Posteriors.ListPosteriorsAsync(
                        new ListPosteriorsRequest { Project = project, PageSize = 1 }, cancellationToken: token).ResponseAsync.ConfigureAwait(false);
                    Publish((float)watch.Elapsed.TotalMilliseconds, "");
                }
                catch (RpcException)
                {
                    // The other call says what is wrong.
                }
                await Wait(RoundTripIntervalMs, token).ConfigureAwait(false);
            }
        }

        private void Take(ScenePosterior? posterior)
        {
            if (posterior == null)
                return;
            lock (gate)
            {
                scenes[$"{posterior.Scene}\n{posterior.MachineClass}\n{posterior.RewardVersion}"] = posterior;
                latest = new PosteriorSnapshot(scenes.Values.SelectMany(LinesOf).ToArray(), latest.RoundTripMs, "");
            }
        }

        private void Publish(float roundTripMs, string problem)
        {
            lock (gate)
                latest = new PosteriorSnapshot(latest.Lines, roundTripMs, problem);
        }

        private static IEnumerable<PosteriorLine> LinesOf(ScenePosterior scene) => scene.Arms.Select(arm => new PosteriorLine(
            scene.Scene, scene.MachineClass, arm.Arm, arm.Posterior.Alpha, arm.Posterior.Beta, arm.WindowCount));

        private static Task Wait(int ms, CancellationToken token) => Task.Delay(ms, token).ContinueWith(_ => { }, TaskScheduler.Default);
#else
        internal void Start(DaemonSettings settings, string project)
        {
            latest = new PosteriorSnapshot(
                Array.Empty<PosteriorLine>(), float.NaN, $"There is no gRPC to ask {settings.address} about {project}. Window > Sweepstake > Setup says what is missing.");
        }

        public void Dispose() => IsRunning = false;
#endif
    }
}
