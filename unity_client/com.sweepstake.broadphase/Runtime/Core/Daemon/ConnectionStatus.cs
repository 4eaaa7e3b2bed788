#nullable enable
using System;

namespace Sweepstake
{
    /// <summary>How a connection stood at one moment; it never changes, so that any thread may keep it.</summary>
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
        /// <summary>What went wrong most recently and what to do; "": nothing.</summary>
        public string LastError => Texts.LastError;
        /// <summary>Why the daemon refused the token, the names or the protocol of the latest attempt; "": it did not.</summary>
        public string Refusal => Texts.Refusal;
        /// <summary>"" before the first welcome, as the next two.</summary>
        public string SessionId => Texts.SessionId;
        public string DaemonVersion => Texts.DaemonVersion;
        /// <summary>The policy that decides.</summary>
        public string Policy => Texts.Policy;
        /// <summary>The daemon's latest posteriors in the order of arms; empty before the first.</summary>
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
