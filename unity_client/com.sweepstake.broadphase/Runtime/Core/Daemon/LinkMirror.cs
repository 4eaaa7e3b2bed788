#nullable enable
using System;
using System.Text;
using Sweepstake.LowLevel;

namespace Sweepstake
{
    /// <summary>Copies the state of a native link into a status. Returns the previous status object if nothing has changed.</summary>
    internal sealed unsafe class LinkMirror
    {
        private readonly byte[] text = new byte[4096];
        private readonly Belief[] beliefs = new Belief[32];

        /// <param name="hasNews">True if texts and beliefs may have changed too: a stream began or ended, or a message arrived.</param>
        internal ConnectionStatus Read(IntPtr link, ConnectionStatus before, bool hasNews)
        {
            var stats = new LinkStats { StructSize = (uint)sizeof(LinkStats) };
            Native.Check(NativeMethods.swp_link_status(link, &stats));
            LinkStats former = before.Stats;
            bool isSame = new ReadOnlySpan<byte>(&stats, sizeof(LinkStats)).SequenceEqual(new ReadOnlySpan<byte>(&former, sizeof(LinkStats)));
            if (isSame && !hasNews)
                return before;
            return new ConnectionStatus(stats, hasNews ? Texts(link) : before.Texts, hasNews ? Beliefs(link) : before.Beliefs);
        }

        internal static ConnectionStatus Closed(ConnectionStatus before)
        {
            LinkStats stats = before.Stats;
            stats.State = LinkState.Closed;
            return new ConnectionStatus(stats, before.Texts, before.Beliefs);
        }

        private ConnectionTexts Texts(IntPtr link) => new ConnectionTexts
        {
            LastError = Text(link, LinkText.LastError),
            Refusal = Text(link, LinkText.Refusal),
            SessionId = Text(link, LinkText.SessionId),
            DaemonVersion = Text(link, LinkText.DaemonVersion),
            Policy = Text(link, LinkText.Policy),
        };

        private string Text(IntPtr link, LinkText which)
        {
            ulong size;
            fixed (byte* start = text)
            {
                ResultCode result = NativeMethods.swp_link_copy_text(link, which, start, (ulong)text.Length, &size);
                if (result == ResultCode.ResourceExhausted)
                    return $"(a text of {size} bytes)";
                Native.Check(result);
            }
            return Encoding.UTF8.GetString(text, 0, (int)size);
        }

        private ReadOnlyMemory<Belief> Beliefs(IntPtr link)
        {
            uint count;
            fixed (Belief* start = beliefs)
                Native.Check(NativeMethods.swp_link_beliefs(link, start, (uint)beliefs.Length, &count));
            return beliefs.AsSpan(0, (int)count).ToArray();
        }
    }
}
