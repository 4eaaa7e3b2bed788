#nullable enable
using System;
using System.Collections.Generic;
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

    /// <summary>A daemon's posterior Beta(Alpha, Beta) of one backend in one scene.</summary>
    internal sealed class PosteriorLine
    {
        internal string Scene { get; set; } = "";
        internal string MachineClass { get; set; } = "";
        internal string Backend { get; set; } = "";
        internal double Alpha { get; set; }
        internal double Beta { get; set; }
        /// <summary>Number of decision windows that the posterior was learnt from.</summary>
        internal ulong Windows { get; set; }
        /// <summary>The expected reward, 0 to 1.</summary>
        internal double Mean => Alpha / (Alpha + Beta);
        internal double Deviation => Math.Sqrt(Alpha * Beta / (Alpha + Beta + 1)) / (Alpha + Beta);
    }

    /// <summary>A daemon's posteriors at one moment; immutable.</summary>
    internal sealed class PosteriorSnapshot
    {
        internal PosteriorSnapshot(IReadOnlyList<PosteriorLine> lines, float roundTripMs, string problem)
        {
            Lines = lines;
            RoundTripMs = roundTripMs;
            Problem = problem;
        }

        internal PosteriorSnapshot(string problem)
            : this(Array.Empty<PosteriorLine>(), float.NaN, problem)
        {
        }

        internal IReadOnlyList<PosteriorLine> Lines { get; }
        /// <summary>Time of a small request and its response; NaN if not known.</summary>
        internal float RoundTripMs { get; }
        /// <summary>Why no posteriors arrive; "" if they arrive.</summary>
        internal string Problem { get; }
    }
}
