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
        private volatile bool hasEnded;

        /// <param name="client">The client; the run owns it and disposes of it.</param>
        internal PosteriorRun(DaemonClient client, string project)
        {
            this.client = client;
            this.project = project;
            _ = Task.Run(Run);
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

        /// <summary>Watches the posteriors. If the daemon ends the stream or cannot be reached, tries again later.</summary>
        private async Task Run()
        {
            try
            {
                while (!hasEnded)
                {
                    await Watch().ConfigureAwait(false);
                    await Wait(RetryMs, end.Token).ConfigureAwait(false);
                }
            }
            catch (Exception problem)
            {
                Publish(float.NaN, problem.Message);
            }
            finally
            {
                Dispose();
                client.Dispose();
            }
        }

        private async Task Watch()
        {
            using var watching = CancellationTokenSource.CreateLinkedTokenSource(end.Token);
            Task roundTrips = Task.CompletedTask;
            try
            {
                using AsyncServerStreamingCall<WatchPosteriorsResponse> call =
                    client.Posteriors.WatchPosteriors(new WatchPosteriorsRequest { Project = project }, cancellationToken: end.Token);
                lock (gate)
                    scenes.Clear();
                roundTrips = MeasureRoundTrips(watching.Token);
                while (await call.ResponseStream.MoveNext(end.Token).ConfigureAwait(false))
                    Add(call.ResponseStream.Current.Posterior);
            }
            catch (RpcException problem) when (!hasEnded)
            {
                watching.Cancel();
                Publish(float.NaN, problem.Status.Detail.Length > 0 ? problem.Status.Detail : problem.StatusCode.ToString());
            }
            finally
            {
                watching.Cancel();
                await roundTrips.ConfigureAwait(false);
            }
        }

        /// <summary>Measures round trips with a small request, and clears the latest error after each. Watch publishes errors.</summary>
        private async Task MeasureRoundTrips(CancellationToken token)
        {
            var request = new ListPosteriorsRequest { Project = project, PageSize = 1 };
            while (!token.IsCancellationRequested)
            {
                try
                {
                    var watch = Stopwatch.StartNew();
                    await client.Posteriors.ListPosteriorsAsync(request, cancellationToken: token).ResponseAsync.ConfigureAwait(false);
                    if (!token.IsCancellationRequested)
                        Publish((float)watch.Elapsed.TotalMilliseconds, "");
                }
                catch (RpcException)
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
