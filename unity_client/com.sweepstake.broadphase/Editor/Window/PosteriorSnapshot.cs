#nullable enable
using System;
using System.Collections.Generic;

namespace Sweepstake.Editor
{
    /// <summary>A daemon's posterior of one backend in one scene.</summary>
    internal sealed class PosteriorLine
    {
        internal PosteriorLine(string scene, string machineClass, string backend, double alpha, double beta, ulong windows)
        {
            Scene = scene;
            MachineClass = machineClass;
            Backend = backend;
            Alpha = alpha;
            Beta = beta;
            Windows = windows;
        }

        internal string Scene { get; }
        internal string MachineClass { get; }
        internal string Backend { get; }
        internal double Alpha { get; }
        internal double Beta { get; }
        /// <summary>Number of decision windows that the posterior was learnt from.</summary>
        internal ulong Windows { get; }
        /// <summary>The expected reward, 0 to 1.</summary>
        internal double Mean => Alpha / (Alpha + Beta);
        /// <summary>The standard deviation of the posterior.</summary>
        internal double Deviation => Math.Sqrt(Alpha * Beta / (Alpha + Beta + 1)) / (Alpha + Beta);
    }

    /// <summary>A daemon's posteriors at one moment; immutable.</summary>
    internal sealed class PosteriorSnapshot
    {
        internal static readonly PosteriorSnapshot Empty = new PosteriorSnapshot(Array.Empty<PosteriorLine>(), float.NaN, "");

        internal PosteriorSnapshot(IReadOnlyList<PosteriorLine> lines, float roundTripMs, string problem)
        {
            Lines = lines;
            RoundTripMs = roundTripMs;
            Problem = problem;
        }

        internal IReadOnlyList<PosteriorLine> Lines { get; }
        /// <summary>Time of a small request and its response; NaN if not known.</summary>
        internal float RoundTripMs { get; }
        /// <summary>Why no posteriors arrive; "" if they arrive.</summary>
        internal string Problem { get; }
    }
}
