#nullable enable

namespace Sweepstake
{
    /// <summary>The state of the connection between a session and its daemon.</summary>
    public enum LinkState : uint
    {
        Offline = 0,
        /// <summary>The stream is open, but the daemon has not sent its welcome message.</summary>
        Connecting = 1,
        Online = 2,
        /// <summary>The link has ended and does not open another stream.</summary>
        Closed = 4,
    }

    /// <summary>What the caller has to do with the stream.</summary>
    public enum LinkAction : uint
    {
        None = 0,
        Send = 1,
        /// <summary>All messages are written: end the writing side of the stream, and read until the stream ends.</summary>
        Finish = 2,
        /// <summary>End the stream at once.</summary>
        Cancel = 3,
    }

    /// <summary>The texts that a link provides.</summary>
    public enum LinkText : uint
    {
        LastError = 0,
        Refusal = 1,
        SessionId = 2,
        DaemonVersion = 3,
        Policy = 4,
    }

    /// <summary>Counters of a link since it was created.</summary>
    public struct LinkStats
    {
        internal uint StructSize;
        public LinkState State;
        public ulong SentFrameCount;
        /// <summary>Frames that the daemon refused.</summary>
        public ulong DiscardedFrameCount;
        public ulong SentSequence;
        /// <summary>Messages up to this sequence number are on the daemon's disk.</summary>
        public ulong AcknowledgedSequence;
        /// <summary>Number of welcome messages received.</summary>
        public ulong ConnectionCount;
        public ulong ResumedCount;
        public ulong ResentMessageCount;
        /// <summary>Switches that the daemon commanded.</summary>
        public ulong CommandCount;
        /// <summary>Messages of a newer protocol, which were skipped.</summary>
        public ulong UnknownMessageCount;
        /// <summary>Number of sources (sessions or installations) whose evidence is in the loaded priors.</summary>
        public ulong PriorSourceCount;
        /// <summary>Seed of the daemon's random draws.</summary>
        public ulong Seed;
        internal uint PriorsUnavailable;
        internal uint AwaitsAcknowledgement;

        /// <summary>Whether the daemon failed to read some of its priors.</summary>
        public readonly bool ArePriorsUnavailable => PriorsUnavailable != 0;
        /// <summary>Whether sending is paused until the daemon acknowledges earlier messages.</summary>
        public readonly bool IsAwaitingAcknowledgement => AwaitsAcknowledgement != 0;
    }
}
