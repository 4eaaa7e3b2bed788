#if SWEEPSTAKE_GRPC
#nullable enable
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;
using Grpc.Core;
using Sweepstake.GrpcNet;
using Sweepstake.Protocol.V1;

namespace Sweepstake.Editor
{
    /// <summary>Reads one daemon's posteriors of one project until it is disposed of. Each run has its own results.</summary>
    internal sealed class PosteriorRun : IDisposable
    {
        private const int RoundTripIntervalMs = 1000;
        private const int RetryMs = 2000;

        private readonly DaemonClient client;
        private readonly string project;
        private readonly CancellationTokenSource end = new CancellationTokenSource();
        private readonly SortedDictionary<string, ScenePosterior> scenes = new SortedDictionary<string, ScenePosterior>(StringComparer.Ordinal);
        private readonly object gate = new object();
        private volatile PosteriorSnapshot latest = new PosteriorSnapshot("");
        private volatile bool isWatching;
        private volatile bool hasEnded;

        /// <param name="client">The client; the run owns it and disposes of it.</param>
        internal PosteriorRun(DaemonClient client, string project)
        {
            this.client = client;
            this.project = project;
            _ = Run();
        }

        internal PosteriorSnapshot Latest => latest;

        internal bool HasEnded => hasEnded;

        /// <summary>Ends the run. The posteriors stay, without a round-trip time.</summary>
        public void Dispose()
        {
            lock (gate)
            {
                latest = new PosteriorSnapshot(latest.Lines, float.NaN, latest.Problem);
                hasEnded = true;
            }
            end.Cancel();
        }

        private async Task Run()
        {
            using (client)
                await Task.WhenAll(Task.Run(() => Guarded(Watch)), Task.Run(() => Guarded(MeasureRoundTrips))).ConfigureAwait(false);
        }

        /// <summary>Publishes an unexpected exception and ends both calls.</summary>
        private async Task Guarded(Func<CancellationToken, Task> work)
        {
            try
            {
                await work(end.Token).ConfigureAwait(false);
            }
            catch (Exception problem)
            {
                Publish(float.NaN, problem.Message);
            }
            finally
            {
                Dispose();
            }
        }

        private async Task Watch(CancellationToken token)
        {
            while (!token.IsCancellationRequested)
            {
                try
                {
                    using AsyncServerStreamingCall<WatchPosteriorsResponse> call =
                        client.Posteriors.WatchPosteriors(new WatchPosteriorsRequest { Project = project }, cancellationToken: token);
                    lock (gate)
                        scenes.Clear();
                    isWatching = true;
                    while (await call.ResponseStream.MoveNext(token).ConfigureAwait(false))
                        Add(call.ResponseStream.Current.Posterior);
                }
                catch (RpcException problem) when (!token.IsCancellationRequested)
                {
                    isWatching = false;
                    Publish(float.NaN, problem.Status.Detail.Length > 0 ? problem.Status.Detail : problem.StatusCode.ToString());
                }
                isWatching = false;
                await Wait(RetryMs, token).ConfigureAwait(false);
            }
        }

        /// <summary>
        /// Measures round trips with a small request. It publishes no errors, because Watch publishes them. It clears the latest error if
        /// Watch was connected both before and after a round trip.
        /// </summary>
        private async Task MeasureRoundTrips(CancellationToken token)
        {
            while (!token.IsCancellationRequested)
            {
                try
                {
                    bool wasWatching = isWatching;
                    var watch = Stopwatch.StartNew();
                    await client.Posteriors.ListPosteriorsAsync(
                        new ListPosteriorsRequest { Project = project, PageSize = 1 }, cancellationToken: token).ResponseAsync.ConfigureAwait(false);
                    Publish((float)watch.Elapsed.TotalMilliseconds, wasWatching && isWatching ? "" : null);
                }
                catch (RpcException) when (!token.IsCancellationRequested)
                {
                    Publish(float.NaN, null);
                }
                await Wait(RoundTripIntervalMs, token).ConfigureAwait(false);
            }
        }

        private void Add(ScenePosterior? posterior)
        {
            lock (gate)
            {
                if (posterior == null || hasEnded)
                    return;
                scenes[$"{posterior.Scene}\n{posterior.MachineClass}\n{posterior.RewardVersion}"] = posterior;
                latest = new PosteriorSnapshot(scenes.Values.SelectMany(LinesOf).ToArray(), latest.RoundTripMs, "");
            }
        }

        /// <param name="problem">The new problem; null keeps the present problem.</param>
        private void Publish(float roundTripMs, string? problem)
        {
            lock (gate)
            {
                if (!hasEnded)
                    latest = new PosteriorSnapshot(latest.Lines, roundTripMs, problem ?? latest.Problem);
            }
        }

        private static IEnumerable<PosteriorLine> LinesOf(ScenePosterior scene) => scene.Arms.Select(arm => new PosteriorLine
        {
            Scene = scene.Scene, MachineClass = scene.MachineClass, Backend = arm.Arm,
            Alpha = arm.Posterior.Alpha, Beta = arm.Posterior.Beta, Windows = arm.WindowCount,
        });

        private static Task Wait(int ms, CancellationToken token) => Task.Delay(ms, token).ContinueWith(_ => { }, TaskScheduler.Default);
    }
}
#endif
