#nullable enable
using System.Diagnostics;

namespace Sweepstake
{
    /// <summary>
    /// The clock of all times passed to a session, a decider or a link: monotonic, with an arbitrary origin. It allocates nothing.
    /// </summary>
    public static class SteadyClock
    {
        private const ulong NsPerSecond = 1_000_000_000;

        public static ulong NowNs
        {
            get
            {
                ulong ticks = (ulong)Stopwatch.GetTimestamp();
                ulong frequency = (ulong)Stopwatch.Frequency;
                return ticks / frequency * NsPerSecond + ticks % frequency * NsPerSecond / frequency;
            }
        }
    }
}
