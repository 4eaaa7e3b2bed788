#nullable enable

namespace Sweepstake.Unity
{
    /// <summary>The state of a <see cref="SweepstakeManager"/>.</summary>
    public enum SweepstakeState
    {
        /// <summary>Not enabled.</summary>
        Stopped,
        /// <summary>It could not start or had to end; <see cref="SweepstakeManager.Problem"/> says why and what to do.</summary>
        Failed,
        /// <summary>Works without a daemon: the game decides itself, and nothing leaves the machine.</summary>
        Embedded,
        /// <summary>A daemon is configured and has not answered yet.</summary>
        Connecting,
        Online,
        /// <summary>The daemon is not available. The game continues with its current backend and reconnects automatically.</summary>
        Offline,
        /// <summary>The daemon refuses this game for a reason that does not go away by waiting.</summary>
        Refused,
    }
}
