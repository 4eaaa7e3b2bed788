#nullable enable
using System;
using System.Diagnostics;

namespace Sweepstake
{
    /// <summary>The clock of all times passed to a session, a decider or a link: monotonic, with an arbitrary origin. It allocates nothing.</summary>
    public static class SteadyClock
    {
        private const ulong NsPerSecond = 1_000_000_000;
        private const ulong NsPerMs = 1_000_000;

        public static ulong NowNs
        {
            get
            {
                ulong ticks = (ulong)Stopwatch.GetTimestamp();
                ulong frequency = (ulong)Stopwatch.Frequency;
                return ticks / frequency * NsPerSecond + ticks % frequency * NsPerSecond / frequency;
            }
        }

        /// <summary>The time in this many milliseconds; now if the number is negative.</summary>
        public static ulong After(int ms) => NowNs + (ulong)Math.Max(0, ms) * NsPerMs;

        /// <summary>The full milliseconds until a time; 0 if it has passed.</summary>
        public static int MsUntil(ulong timeNs)
        {
            ulong nowNs = NowNs;
            return nowNs < timeNs ? (int)Math.Min(int.MaxValue, (timeNs - nowNs) / NsPerMs) : 0;
        }
    }
}
