#nullable enable
using System;
#if SWEEPSTAKE_GRPC
using Sweepstake.GrpcNet;
#endif
using Sweepstake.Unity;

namespace Sweepstake.Editor
{
    /// <summary>
    /// Watches the posteriors of a project through the daemon's own service, on threads of the pool; what is shown reads
    /// <see cref="Latest"/>. It asks, and sends nothing else. Main thread.
    /// </summary>
    internal sealed class PosteriorWatcher : IDisposable
    {
        private PosteriorSnapshot kept = PosteriorSnapshot.Empty;

#if SWEEPSTAKE_GRPC
        private PosteriorRun? run;

        /// <summary>While it is stopped, what was known last, without a round trip.</summary>
        internal PosteriorSnapshot Latest => run?.Latest ?? kept;

        /// <summary>Whether it asks; it ends by itself only by an error that trying again would not mend.</summary>
        internal bool IsRunning => run != null && !run.HasEnded;

        internal void Start(DaemonSettings settings, string project)
        {
            Dispose();
            kept = PosteriorSnapshot.Empty;
            try
            {
                run = new PosteriorRun(new DaemonClient(DaemonTransport.EndpointOf(settings)), project);
            }
            catch (Exception problem) when (problem is SweepstakeException || problem is InvalidOperationException || problem is System.IO.IOException)
            {
                kept = new PosteriorSnapshot(Array.Empty<PosteriorLine>(), float.NaN, problem.Message);
            }
        }

        public void Dispose()
        {
            if (run == null)
                return;
            PosteriorSnapshot last = run.Latest;
            kept = new PosteriorSnapshot(last.Lines, float.NaN, last.Problem);
            run.Dispose();
            run = null;
        }
#else
        internal PosteriorSnapshot Latest => kept;

        internal bool IsRunning => false;

        internal void Start(DaemonSettings settings, string project)
        {
            kept = new PosteriorSnapshot(
                Array.Empty<PosteriorLine>(), float.NaN, $"There is no gRPC to ask {settings.address} about {project}. Window > Sweepstake > Setup says what is missing.");
        }

        public void Dispose()
        {
        }
#endif
    }
}
