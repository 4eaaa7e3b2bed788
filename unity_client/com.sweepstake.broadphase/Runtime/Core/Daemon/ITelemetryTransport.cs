#nullable enable
using System;
using System.Threading.Tasks;

namespace Sweepstake
{
    /// <summary>Transports the bytes of sessions to a daemon without interpreting them. Used by one thread at a time.</summary>
    public interface ITelemetryTransport : IDisposable
    {
        /// <summary>
        /// Starts a call of sweepstake.v1.TelemetryService/StreamTelemetry without waiting for the network. If the call cannot be started, for
        /// example because a token file is missing, it throws an exception whose message says what to do. The connection tries again later.
        /// </summary>
        ITelemetryStream Open();
    }

    /// <summary>
    /// One stream. Its tasks may complete on any thread. A call that throws ends the stream, and the connection tries again. Dispose ends
    /// the stream at once, even during a call, and does not wait.
    /// </summary>
    public interface ITelemetryStream : IDisposable
    {
        /// <summary>Writes a message. The caller does not change its bytes until the task ends. One write at a time.</summary>
        Task WriteAsync(ArraySegment<byte> message);

        /// <summary>Ends the writing side. Called after the last write.</summary>
        Task FinishAsync();

        /// <summary>Reads the next message; null after the stream has ended for any reason, see <see cref="End"/>. One read at a time.</summary>
        Task<byte[]?> ReadAsync();

        /// <summary>The status with which the stream ended.</summary>
        StreamEnd End { get; }
    }

    /// <summary>The gRPC status of a stream that has ended.</summary>
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
        /// <summary>The trailer grpc-status-details-bin; null if there was none.</summary>
        public byte[]? Details { get; }
    }
}
