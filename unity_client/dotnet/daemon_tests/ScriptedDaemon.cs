using System;
using System.Collections.Concurrent;
using System.Collections.Generic;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;
using Google.Protobuf;
using Sweepstake.Protocol.V1;

namespace Sweepstake.Tests
{
    /// <summary>A transport with a simulated daemon, which sends the messages that a test chooses, in the generated protocol.</summary>
    internal sealed class ScriptedDaemon : ITelemetryTransport
    {
        private readonly Func<ITelemetryStream> open;

        internal ScriptedDaemon(Func<ITelemetryStream> open)
        {
            this.open = open;
        }

        internal int OpenCount { get; private set; }
        internal bool IsDisposed { get; private set; }

        public ITelemetryStream Open()
        {
            ++OpenCount;
            return open();
        }

        public void Dispose()
        {
            IsDisposed = true;
        }

        internal static Welcome Welcome() =>
            new Welcome { SessionId = "scripted", DaemonVersion = "9.9.9", Policy = "scripted" };
    }

    /// <summary>A daemon that cannot be reached. It counts what the link's thread allocates between two attempts.</summary>
    internal sealed class AbsentDaemon : ITelemetryTransport, ITelemetryStream
    {
        private static readonly Task<byte[]> NoMessage = Task.FromResult<byte[]>(null);
        private long allocatedBefore = -1;
        private int openCount;

        internal int OpenCount => Volatile.Read(ref openCount);
        internal long AllocatedBetween { get; private set; }

        public StreamEnd End => new StreamEnd(StreamEnd.Unavailable, "nobody is there");

        public ITelemetryStream Open()
        {
            if (allocatedBefore >= 0)
                AllocatedBetween += GC.GetAllocatedBytesForCurrentThread() - allocatedBefore;
            Interlocked.Increment(ref openCount);
            return this;
        }

        public Task WriteAsync(ArraySegment<byte> message) => Task.CompletedTask;

        public Task FinishAsync() => Task.CompletedTask;

        public Task<byte[]> ReadAsync() => NoMessage;

        public void Dispose()
        {
            allocatedBefore = GC.GetAllocatedBytesForCurrentThread();
        }
    }

    /// <summary>One stream of the scripted daemon. Like a real daemon, it sends nothing before the game's first message.</summary>
    internal sealed class ScriptedStream : ITelemetryStream
    {
        private readonly ConcurrentQueue<StreamTelemetryRequest> requests = new ConcurrentQueue<StreamTelemetryRequest>();
        private readonly object gate = new object();
        private readonly Queue<byte[]> answers = new Queue<byte[]>();
        private TaskCompletionSource<byte[]> waiting;
        private bool hasEnded;

        /// <summary>The task that WriteAsync returns.</summary>
        internal Task Writing { get; set; } = Task.CompletedTask;
        /// <summary>The name of the call that throws; "" for none.</summary>
        internal string Broken { get; set; } = "";
        internal bool IsDisposed { get; private set; }
        internal bool IsFinished { get; private set; }
        internal IReadOnlyList<StreamTelemetryRequest> Requests => requests.ToArray();

        public StreamEnd End { get; private set; }

        public Task WriteAsync(ArraySegment<byte> message)
        {
            ThrowIfBroken("write");
            requests.Enqueue(StreamTelemetryRequest.Parser.ParseFrom(message.Array, message.Offset, message.Count));
            Answer();
            return Writing;
        }

        public Task FinishAsync()
        {
            IsFinished = true;
            return Task.CompletedTask;
        }

        public Task<byte[]> ReadAsync()
        {
            ThrowIfBroken("read");
            lock (gate)
            {
                waiting = new TaskCompletionSource<byte[]>(TaskCreationOptions.RunContinuationsAsynchronously);
                Task<byte[]> read = waiting.Task;
                Answer();
                return read;
            }
        }

        public void Dispose()
        {
            IsDisposed = true;
            EndWith(new StreamEnd(StreamEnd.Cancelled, ""));
        }

        internal ScriptedStream Saying(params StreamTelemetryResponse[] responses)
        {
            foreach (StreamTelemetryResponse response in responses)
                Say(response.ToByteArray());
            return this;
        }

        internal void Say(byte[] answer)
        {
            lock (gate)
                answers.Enqueue(answer);
            Answer();
        }

        internal void EndWith(StreamEnd end)
        {
            lock (gate)
            {
                if (!hasEnded)
                    End = end;
                hasEnded = true;
            }
            Answer();
        }

        private void ThrowIfBroken(string call)
        {
            if (Broken == call)
                throw new InvalidOperationException("a bug of " + call);
        }

        private void Answer()
        {
            lock (gate)
            {
                if (waiting == null || (requests.IsEmpty && !hasEnded) || (answers.Count == 0 && !hasEnded))
                    return;
                waiting.TrySetResult(answers.Count > 0 ? answers.Dequeue() : null);
                waiting = null;
            }
        }

        internal IEnumerable<T> Sent<T>(Func<StreamTelemetryRequest, T> part)
            where T : class => Requests.Select(part).Where(found => found != null);
    }
}
