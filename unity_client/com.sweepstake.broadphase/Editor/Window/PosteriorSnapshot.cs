#nullable enable
using System;
using System.Collections.Generic;

namespace Sweepstake.Editor
{
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
        /// <summary>The standard deviation of the posterior.</summary>
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

        /// <summary>A snapshot without posteriors.</summary>
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
