#nullable enable
using System;
using System.Text;
using Sweepstake.LowLevel;

namespace Sweepstake
{
    /// <summary>The state of a connection at one moment. It is immutable, so any thread may keep it.</summary>
    public sealed unsafe class ConnectionStatus
    {
        private const int MaxTextBytes = 4096;
        private const int MaxArms = 32;
        private static readonly LinkText[] AllTexts = (LinkText[])Enum.GetValues(typeof(LinkText));
        internal static readonly ConnectionStatus Initial = new ConnectionStatus(default, Array.ConvertAll(AllTexts, _ => ""), default);

        private readonly string[] texts; // by LinkText

        private ConnectionStatus(in LinkStats stats, string[] texts, ReadOnlyMemory<Belief> beliefs)
        {
            Stats = stats;
            this.texts = texts;
            Beliefs = beliefs;
        }

        public LinkState State => Stats.State;
        public LinkStats Stats { get; }
        /// <summary>What went wrong most recently and what to do; "" if nothing went wrong.</summary>
        public string LastError => texts[(int)LinkText.LastError];
        /// <summary>Why the daemon refused the latest attempt, for example because of the token or the names; "" if it did not refuse.</summary>
        public string Refusal => texts[(int)LinkText.Refusal];
        /// <summary>Id of the session; "" before the daemon's first welcome message.</summary>
        public string SessionId => texts[(int)LinkText.SessionId];
        /// <summary>The daemon's version; "" before the daemon's first welcome message.</summary>
        public string DaemonVersion => texts[(int)LinkText.DaemonVersion];
        /// <summary>The name of the policy that decides; "" before the daemon's first welcome message.</summary>
        public string Policy => texts[(int)LinkText.Policy];
        /// <summary>The daemon's latest posteriors in the order of arms; empty until the first arrive.</summary>
        public ReadOnlyMemory<Belief> Beliefs { get; }

        /// <summary>Returns the present state of a link; this object if nothing has changed.</summary>
        /// <param name="hasNews">True if texts and beliefs may have changed too: a stream began or ended, or a message arrived.</param>
        internal ConnectionStatus Updated(IntPtr link, bool hasNews)
        {
            var stats = new LinkStats { StructSize = (uint)sizeof(LinkStats) };
            Native.Check(NativeMethods.swp_link_status(link, &stats));
            if (hasNews)
                return new ConnectionStatus(stats, Array.ConvertAll(AllTexts, which => TextOf(link, which)), BeliefsOf(link));
            LinkStats former = Stats;
            bool isSame = new ReadOnlySpan<byte>(&stats, sizeof(LinkStats)).SequenceEqual(new ReadOnlySpan<byte>(&former, sizeof(LinkStats)));
            return isSame ? this : new ConnectionStatus(stats, texts, Beliefs);
        }

        internal ConnectionStatus Closed()
        {
            LinkStats stats = Stats;
            stats.State = LinkState.Closed;
            return new ConnectionStatus(stats, texts, Beliefs);
        }

        private static string TextOf(IntPtr link, LinkText which)
        {
            byte* text = stackalloc byte[MaxTextBytes];
            ulong size;
            ResultCode result = NativeMethods.swp_link_copy_text(link, which, text, MaxTextBytes, &size);
            if (result == ResultCode.ResourceExhausted)
                return $"(a text of {size} bytes)";
            Native.Check(result);
            return Encoding.UTF8.GetString(text, (int)size);
        }

        private static Belief[] BeliefsOf(IntPtr link)
        {
            Belief* beliefs = stackalloc Belief[MaxArms];
            uint count;
            Native.Check(NativeMethods.swp_link_beliefs(link, beliefs, MaxArms, &count));
            return new ReadOnlySpan<Belief>(beliefs, (int)count).ToArray();
        }
    }
}
