#nullable enable
using System;
using System.Threading.Tasks;

namespace Sweepstake
{
    /// <summary>Carries the bytes of sessions to a daemon; knows nothing of what they mean. Used by one thread at a time.</summary>
    public interface ITelemetryTransport : IDisposable
    {
        /// <summary>
        /// Begins a call of sweepstake.v1.TelemetryService/StreamTelemetry without waiting for the network. What cannot even begin, such as
        /// a token file that is not there, throws with a message that says what to do; it is tried again once in a while.
        /// </summary>
        ITelemetryStream Open();
    }

    /// <summary>
    /// One stream. Its tasks may end on any thread. A call that throws ends it, and it is tried again. Dispose ends it at once, whatever is under
    /// way, and does not wait.
    /// </summary>
    public interface ITelemetryStream : IDisposable
    {
        /// <summary>Writes a message, whose bytes stay as they are until the task ends. One write at a time.</summary>
        Task WriteAsync(ArraySegment<byte> message);

        /// <summary>There are no more messages to write. After the last write.</summary>
        Task FinishAsync();

        /// <summary>The next message; null once the stream has ended, whyever, and <see cref="End"/> says how. One read at a time.</summary>
        Task<byte[]?> ReadAsync();

        /// <summary>How it ended.</summary>
        StreamEnd End { get; }
    }

    /// <summary>A status of gRPC.</summary>
    public readonly struct StreamEnd
    {
        public const uint Cancelled = 1;
        public const uint InvalidArgument = 3;
        public const uint Unavailable = 14;

        public StreamEnd(uint code, string message, byte[]? details = null)
        {
            Code = code;
            Message = message;
            Details = details;
        }

        public uint Code { get; }
        public string Message { get; }
        /// <summary>The trailer grpc-status-details-bin; null: there was none.</summary>
        public byte[]? Details { get; }
    }
}
