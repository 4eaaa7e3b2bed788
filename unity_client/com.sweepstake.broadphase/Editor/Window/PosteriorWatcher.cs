#nullable enable
using System;
#if SWEEPSTAKE_GRPC
using Sweepstake.GrpcNet;
#endif
using Sweepstake.Unity;

namespace Sweepstake.Editor
{
    /// <summary>
    /// Reads the posteriors of a project through the daemon's service, on threads of the pool; views read <see cref="Latest"/>. The only
    /// data that leaves the machine is its requests. Use it on the main thread.
    /// </summary>
    internal sealed class PosteriorWatcher : IDisposable
    {
        private PosteriorSnapshot kept = PosteriorSnapshot.Empty;

#if SWEEPSTAKE_GRPC
        private PosteriorRun? run;

        /// <summary>The latest posteriors. They stay after the watcher was stopped, but then have no round-trip time.</summary>
        internal PosteriorSnapshot Latest => run?.Latest ?? kept;

        /// <summary>Whether the watcher is reading. Reading ends by itself only after an error that a retry cannot fix.</summary>
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
                Array.Empty<PosteriorLine>(), float.NaN, $"gRPC is missing, so the posteriors of {project} cannot be read from {settings.address}. Window > Sweepstake > Setup shows what is missing.");
        }

        public void Dispose()
        {
        }
#endif
    }
}
