#nullable enable

namespace Sweepstake.Unity
{
    /// <summary>How a <see cref="SweepstakeManager"/> stands.</summary>
    public enum SweepstakeState
    {
        /// <summary>Not enabled.</summary>
        Stopped,
        /// <summary>It could not begin or had to end; <see cref="SweepstakeManager.Problem"/> says why and what to do.</summary>
        Failed,
        /// <summary>Offline by choice: the game decides itself, and nothing leaves the machine.</summary>
        Embedded,
        /// <summary>A daemon was named and has not answered yet.</summary>
        Connecting,
        Online,
        /// <summary>The daemon is away; the game plays on with the backend it has, and connects again by itself.</summary>
        Offline,
        /// <summary>The daemon does not want this game, for a reason that waiting does not change.</summary>
        Refused,
    }
}
