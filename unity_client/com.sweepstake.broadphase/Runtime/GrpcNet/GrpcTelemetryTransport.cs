#nullable enable
using System;
using System.Buffers;
using System.Threading;
using System.Threading.Tasks;
using Grpc.Core;
using Grpc.Net.Client;

namespace Sweepstake.GrpcNet
{
    /// <summary>
    /// Transports telemetry over gRPC. The messages are the bytes of the native link, so this class needs no generated code and no
    /// Google.Protobuf. Each stream has its own connection.
    /// </summary>
    public sealed class GrpcTelemetryTransport : ITelemetryTransport
    {
        private static readonly Method<OutgoingBytes, byte[]> StreamTelemetry = new Method<OutgoingBytes, byte[]>(
            MethodType.DuplexStreaming,
            "sweepstake.v1.TelemetryService",
            "StreamTelemetry",
            new Marshaller<OutgoingBytes>(OutgoingBytes.Write, _ => throw new NotSupportedException()),
            new Marshaller<byte[]>((_, __) => throw new NotSupportedException(), context => context.PayloadAsNewBuffer()));

        private readonly DaemonEndpoint endpoint;

        public GrpcTelemetryTransport(DaemonEndpoint endpoint) => this.endpoint = endpoint ?? throw new ArgumentNullException(nameof(endpoint));

        /// <inheritdoc/>
        public ITelemetryStream Open()
        {
            GrpcChannel channel = endpoint.OpenChannel(out CallInvoker calls);
            return new GrpcStream(channel, calls.AsyncDuplexStreamingCall(StreamTelemetry, null, default));
        }

        public void Dispose()
        {
        }

        private sealed class OutgoingBytes
        {
            internal ArraySegment<byte> Bytes;

            internal static void Write(OutgoingBytes message, SerializationContext context)
            {
                context.SetPayloadLength(message.Bytes.Count);
                context.GetBufferWriter().Write(message.Bytes.AsSpan());
                context.Complete();
            }
        }

        private sealed class GrpcStream : ITelemetryStream
        {
            private const string DetailsTrailer = "grpc-status-details-bin";

            private readonly GrpcChannel channel;
            private readonly AsyncDuplexStreamingCall<OutgoingBytes, byte[]> call;
            private readonly OutgoingBytes outgoing = new OutgoingBytes();

            internal GrpcStream(GrpcChannel channel, AsyncDuplexStreamingCall<OutgoingBytes, byte[]> call)
            {
                this.channel = channel;
                this.call = call;
            }

            public StreamEnd End { get; private set; }

            public Task WriteAsync(ArraySegment<byte> message)
            {
                outgoing.Bytes = message;
                return call.RequestStream.WriteAsync(outgoing);
            }

            public Task FinishAsync() => call.RequestStream.CompleteAsync();

            public async Task<byte[]?> ReadAsync()
            {
                try
                {
                    if (await call.ResponseStream.MoveNext(CancellationToken.None).ConfigureAwait(false))
                        return call.ResponseStream.Current;
                    End = EndOf(call.GetStatus(), call.GetTrailers());
                }
                catch (RpcException failed)
                {
                    End = EndOf(failed.Status, failed.Trailers);
                }
                catch (Exception failed) when (failed is InvalidOperationException || failed is System.IO.IOException || failed is OperationCanceledException)
                {
                    End = new StreamEnd(StreamEnd.Unavailable, failed.Message);
                }
                return null;
            }

            public void Dispose()
            {
                call.Dispose();
                channel.Dispose();
            }

            private static StreamEnd EndOf(Status status, Metadata trailers) =>
                new StreamEnd((uint)status.StatusCode, status.Detail, trailers.GetValueBytes(DetailsTrailer));
        }
    }
}
