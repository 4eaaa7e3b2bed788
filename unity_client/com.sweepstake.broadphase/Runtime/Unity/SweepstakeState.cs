#nullable enable

namespace Sweepstake.Unity
{
    /// <summary>The state of a <see cref="SweepstakeManager"/>.</summary>
    public enum SweepstakeState
    {
        /// <summary>The manager is not enabled.</summary>
        Stopped,
        /// <summary>The manager could not start or had to end; <see cref="SweepstakeManager.Problem"/> says why and what to do.</summary>
        Failed,
        /// <summary>The manager works without a daemon: decisions are made in the game's process, and nothing leaves the machine.</summary>
        Embedded,
        /// <summary>A daemon is configured and has not answered yet.</summary>
        Connecting,
        Online,
        /// <summary>The daemon is not available. The game continues with its current backend and reconnects automatically.</summary>
        Offline,
        /// <summary>The daemon refuses this game and will do so again; <see cref="SweepstakeManager.Problem"/> says what to do.</summary>
        Refused,
    }
}
