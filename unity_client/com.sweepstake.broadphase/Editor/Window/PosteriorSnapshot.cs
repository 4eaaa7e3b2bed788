#nullable enable
using System;
using System.Collections.Generic;

namespace Sweepstake.Editor
{
    /// <summary>What a daemon believes about one backend in one scene.</summary>
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
        /// <summary>Windows of frames that it has learnt from.</summary>
        internal ulong Windows { get; }
        /// <summary>The expected reward, 0 to 1.</summary>
        internal double Mean => Alpha / (Alpha + Beta);
        /// <summary>The standard deviation of the reward.</summary>
        internal double Deviation => Math.Sqrt(Alpha * Beta / (Alpha + Beta + 1)) / (Alpha + Beta);
    }

    /// <summary>What a daemon believed at one moment; it never changes.</summary>
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
        /// <summary>Of a small question and its answer; NaN: not known.</summary>
        internal float RoundTripMs { get; }
        /// <summary>Why nothing comes; "": all is well.</summary>
        internal string Problem { get; }
    }
}
