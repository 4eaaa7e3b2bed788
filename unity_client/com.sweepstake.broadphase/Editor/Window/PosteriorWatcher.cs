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
        private PosteriorSnapshot withoutRun = new PosteriorSnapshot("");

#if SWEEPSTAKE_GRPC
        private PosteriorRun? run;

        /// <summary>The latest posteriors. They stay after the watcher was stopped, but then have no round-trip time.</summary>
        internal PosteriorSnapshot Latest => run?.Latest ?? withoutRun;

        /// <summary>Whether the watcher is reading. Reading ends by itself only after an error that a retry cannot fix.</summary>
        internal bool IsRunning => run?.HasEnded == false;

        internal void Start(DaemonSettings settings, string project)
        {
            Dispose();
            run = null;
            try
            {
                run = new PosteriorRun(new DaemonClient(DaemonTransport.EndpointOf(settings)), project);
            }
            catch (Exception problem) when (problem is SweepstakeException || problem is InvalidOperationException || problem is System.IO.IOException)
            {
                withoutRun = new PosteriorSnapshot(problem.Message);
            }
        }

        public void Dispose() => run?.Dispose();
#else
        internal PosteriorSnapshot Latest => withoutRun;

        internal bool IsRunning => false;

        internal void Start(DaemonSettings settings, string project) => withoutRun = new PosteriorSnapshot(
            $"gRPC is missing, so the posteriors of {project} cannot be read from {settings.address}. Window > Sweepstake > Setup shows what is missing.");

        public void Dispose()
        {
        }
#endif
    }
}
