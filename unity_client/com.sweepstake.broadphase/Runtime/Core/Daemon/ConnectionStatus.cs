#nullable enable
using System;

namespace Sweepstake
{
    /// <summary>The state of a connection at one moment. It is immutable, so any thread may keep it.</summary>
    public sealed class ConnectionStatus
    {
        internal static readonly ConnectionStatus Initial = new ConnectionStatus(default, new ConnectionTexts(), default);

        internal ConnectionStatus(in LinkStats stats, ConnectionTexts texts, ReadOnlyMemory<Belief> beliefs)
        {
            Stats = stats;
            Texts = texts;
            Beliefs = beliefs;
        }

        public LinkState State => Stats.State;
        public LinkStats Stats { get; }
        /// <summary>What went wrong most recently and what to do; "" if nothing went wrong.</summary>
        public string LastError => Texts.LastError;
        /// <summary>Why the daemon refused the latest attempt, for example because of the token or the names; "" if it did not refuse.</summary>
        public string Refusal => Texts.Refusal;
        /// <summary>Id of the session; "" before the daemon's first welcome message.</summary>
        public string SessionId => Texts.SessionId;
        /// <summary>The daemon's version; "" before the daemon's first welcome message.</summary>
        public string DaemonVersion => Texts.DaemonVersion;
        /// <summary>The name of the policy that decides; "" before the daemon's first welcome message.</summary>
        public string Policy => Texts.Policy;
        /// <summary>The daemon's latest posteriors in the order of arms; empty until the first arrive.</summary>
        public ReadOnlyMemory<Belief> Beliefs { get; }

        internal ConnectionTexts Texts { get; }
    }

    internal sealed class ConnectionTexts
    {
        internal string LastError = "";
        internal string Refusal = "";
        internal string SessionId = "";
        internal string DaemonVersion = "";
        internal string Policy = "";
    }
}
