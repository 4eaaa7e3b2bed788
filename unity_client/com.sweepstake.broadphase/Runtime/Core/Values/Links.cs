#nullable enable
using System.Runtime.InteropServices;

namespace Sweepstake
{
    /// <summary>How a session stands with its daemon.</summary>
    public enum LinkState : uint
    {
        Offline = 0,
        /// <summary>From the stream's opening to the daemon's welcome.</summary>
        Connecting = 1,
        Online = 2,
        /// <summary>It has ended: there is no further stream.</summary>
        Closed = 4,
    }

    /// <summary>What the link wants done with its stream.</summary>
    public enum LinkAction : uint
    {
        None = 0,
        Send = 1,
        /// <summary>There are no more messages: end writing, and read until the end.</summary>
        Finish = 2,
        /// <summary>End the stream at once.</summary>
        Cancel = 3,
    }

    /// <summary>A text that a link has.</summary>
    public enum LinkText : uint
    {
        LastError = 0,
        Refusal = 1,
        SessionId = 2,
        DaemonVersion = 3,
        Policy = 4,
    }

    /// <summary>What a link has done since it was made.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct LinkStats
    {
        internal uint StructSize;
        public LinkState State;
        public ulong SentFrameCount;
        /// <summary>Refused by the daemon.</summary>
        public ulong DiscardedFrameCount;
        public ulong SentSequence;
        /// <summary>Messages up to this one are on the daemon's disk.</summary>
        public ulong AcknowledgedSequence;
        /// <summary>Welcomes.</summary>
        public ulong ConnectionCount;
        public ulong ResumedCount;
        public ulong ResentMessageCount;
        /// <summary>Switches that the daemon commanded.</summary>
        public ulong CommandCount;
        /// <summary>Of a newer protocol, passed over.</summary>
        public ulong UnknownMessageCount;
        /// <summary>Sources in the priors it started from.</summary>
        public ulong PriorSourceCount;
        /// <summary>Of the daemon's draws.</summary>
        public ulong Seed;
        internal uint PriorsUnavailable;
        internal uint AwaitsAcknowledgement;

        /// <summary>The daemon could not read all of its priors.</summary>
        public readonly bool ArePriorsUnavailable => PriorsUnavailable != 0;
        /// <summary>Nothing is sent before the daemon acknowledges.</summary>
        public readonly bool IsAwaitingAcknowledgement => AwaitsAcknowledgement != 0;
    }
}
