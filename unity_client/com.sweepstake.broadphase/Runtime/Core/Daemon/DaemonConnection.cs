#nullable enable
using System;
using System.Threading;
using System.Threading.Tasks;
using Sweepstake.LowLevel;

namespace Sweepstake
{
    /// <summary>
    /// Connects a session to a daemon. A separate thread moves the bytes of the native link over a transport. The native link handles
    /// batches, resending, back-off, resuming and the commands for the frame path. The frame thread never waits for the connection. If the
    /// daemon is absent, slow or killed, the game continues, and the connection is made again automatically. Create this object and dispose
    /// of it while no frame runs.
    /// </summary>
    public sealed unsafe class DaemonConnection : SessionWork
    {
        private const int TickMs = 5;
        // Until the daemon answers, only the native link's time limit for the answer is checked.
        private const int UnansweredTickMs = 250;
        private const uint Never = uint.MaxValue;
        private const uint MinBufferBytes = 8 * 1024;

        private static readonly Func<ITelemetryStream, ArraySegment<byte>, Task<byte[]?>> Read = (stream, _) => stream.ReadAsync();
        private static readonly Func<ITelemetryStream, ArraySegment<byte>, Task> Write = (stream, message) => stream.WriteAsync(message);
        private static readonly Func<ITelemetryStream, ArraySegment<byte>, Task> Finish = (stream, _) => stream.FinishAsync();

        private readonly ITelemetryTransport transport;
        private readonly LinkMirror mirror = new LinkMirror();
        private readonly Action<Task> wakeAfter;
        private IntPtr link;
        private byte[] buffer;
        private volatile ConnectionStatus status = ConnectionStatus.Initial;

        /// <param name="transport">The connection owns the transport, and disposes of it when the connection has ended.</param>
        /// <param name="options">Null for the defaults.</param>
        /// <exception cref="SweepstakeException">The session already has a decider or a connection, or a value is out of range.</exception>
        public DaemonConnection(BroadPhaseSession session, ITelemetryTransport transport, LinkOptions? options = null)
            : base(session)
        {
            this.transport = transport ?? throw new ArgumentNullException(nameof(transport));
            wakeAfter = task =>
            {
                // Reading the exception marks the failed write as observed. The failure itself is reported by the read that ends the
                // stream.
                _ = task.Exception;
                Wake();
            };
            using (var memory = new CallMemory())
            {
                NativeLinkOptions native = (options ?? new LinkOptions()).With(memory);
                IntPtr made;
                Native.Check(NativeMethods.swp_link_create(session.Pointer, &native, &made));
                link = made;
                buffer = new byte[Math.Max(native.BatchBytes, MinBufferBytes)];
            }
            Start("sweepstake link");
        }

        /// <summary>
        /// The latest status. Each change creates a new object. Callable from any thread and cheap enough for each frame.
        /// </summary>
        public ConnectionStatus Status => status;

        private protected override void Serve()
        {
            try
            {
                uint delayMs = 0;
                while (WaitForStream(delayMs))
                    delayMs = ServeStream();
            }
            finally
            {
                status = LinkMirror.Closed(status);
                transport.Dispose();
            }
        }

        private protected override void BeginNativeStop(ulong endNs)
        {
            // Cancel the stream after 4/5 of the remaining time, so that the thread has 1/5 to end.
            ulong nowNs = SteadyClock.NowNs;
            NativeMethods.swp_link_goodbye(link, nowNs + (endNs > nowNs ? (endNs - nowNs) / 5 * 4 : 0));
        }

        private protected override void CloseNative()
        {
            NativeMethods.swp_link_destroy(link);
            link = IntPtr.Zero;
            status = LinkMirror.Closed(status);
        }

        /// <summary>
        /// Sleeps until the next stream is due; false if there will not be another stream. It allocates nothing, and only Stop wakes it
        /// early.
        /// </summary>
        private bool WaitForStream(uint delayMs)
        {
            ulong dueNs = delayMs == Never ? 0 : SteadyClock.NowNs + delayMs * 1_000_000UL;
            while (delayMs != Never && EmptyQueue())
            {
                ulong nowNs = SteadyClock.NowNs;
                if (nowNs >= dueNs)
                    return true;
                Sleep((int)Math.Min(int.MaxValue, (dueNs - nowNs) / 1_000_000 + 1));
            }
            return false;
        }

        /// <summary>
        /// Moves the session's samples into the native link, so that the session's queue has room during the next delay. Returns false if
        /// this object is being stopped.
        /// </summary>
        private bool EmptyQueue()
        {
            lock (Gate)
            {
                if (IsStopping || IsClosed)
                    return false;
                PeekAction();
                return true;
            }
        }

        /// <summary>Opens a stream and serves it until it ends; returns the delay before the next stream in milliseconds.</summary>
        private uint ServeStream()
        {
            ITelemetryStream stream;
            try
            {
                stream = transport.Open();
            }
            catch (Exception refused)
            {
                return Disconnected(new StreamEnd(StreamEnd.InvalidArgument, refused.Message));
            }
            using (stream)
            {
                Connected();
                return Disconnected(EndAfterMoving(stream));
            }
        }

        private StreamEnd EndAfterMoving(ITelemetryStream stream)
        {
            try
            {
                return MoveBytes(stream);
            }
            catch (BrokenStreamException broken)
            {
                return new StreamEnd(StreamEnd.Unavailable, broken.Message);
            }
        }

        private StreamEnd MoveBytes(ITelemetryStream stream)
        {
            Task<byte[]?> read = Begun(stream, Read);
            Task write = Task.CompletedTask;
            bool isFinishing = false;
            while (true)
            {
                for (; read.IsCompleted; read = Begun(stream, Read))
                {
                    byte[]? message = ResultOf(read);
                    if (message == null)
                        return stream.End;
                    OnMessage(message);
                }
                LinkAction action = NextAction(write.IsCompletedSuccessfully, out int size);
                if (action == LinkAction.Cancel)
                    return new StreamEnd(StreamEnd.Cancelled, "");
                if (action == LinkAction.Send)
                    write = Begun(stream, Write, new ArraySegment<byte>(buffer, 0, size));
                isFinishing |= action == LinkAction.Finish;
                if (isFinishing && write.IsCompletedSuccessfully)
                {
                    write = Begun(stream, Finish);
                    isFinishing = false;
                }
                if (action != LinkAction.Send)
                    Sleep(IsStopping || status.State == LinkState.Online ? TickMs : UnansweredTickMs);
            }
        }

        private static byte[]? ResultOf(Task<byte[]?> read) => read.IsCompletedSuccessfully ? read.Result : null;

        /// <exception cref="BrokenStreamException">The stream threw an exception instead of returning a failed task.</exception>
        private TTask Begun<TTask>(ITelemetryStream stream, Func<ITelemetryStream, ArraySegment<byte>, TTask> call, ArraySegment<byte> message = default)
            where TTask : Task
        {
            TTask task;
            try
            {
                task = call(stream, message);
            }
            catch (Exception problem)
            {
                throw new BrokenStreamException(problem);
            }
            if (!task.IsCompleted)
                task.ContinueWith(wakeAfter, CancellationToken.None, TaskContinuationOptions.ExecuteSynchronously, TaskScheduler.Default);
            return task;
        }

        /// <summary>Returns the link's next action; for Send, the message is in the buffer. Once this object is closed, returns Cancel.</summary>
        private LinkAction NextAction(bool canWrite, out int size)
        {
            lock (Gate)
            {
                size = 0;
                if (IsClosed)
                    return LinkAction.Cancel;
                LinkAction action = canWrite ? NextMessage(out size) : PeekAction();
                Publish(false);
                return action;
            }
        }

        private LinkAction PeekAction()
        {
            ulong bytes;
            LinkAction action = LinkAction.None;
            ResultCode result = NativeMethods.swp_link_next_message(link, SteadyClock.NowNs, null, 0, &bytes, &action);
            if (result != ResultCode.ResourceExhausted)
                Native.Check(result);
            return action == LinkAction.Send ? LinkAction.None : action;
        }

        private LinkAction NextMessage(out int size)
        {
            ulong bytes;
            LinkAction action = LinkAction.None;
            ulong nowNs = SteadyClock.NowNs;
            ResultCode result;
            fixed (byte* start = buffer)
                result = NativeMethods.swp_link_next_message(link, nowNs, start, (ulong)buffer.Length, &bytes, &action);
            if (result == ResultCode.ResourceExhausted)
            {
                buffer = new byte[checked((int)bytes)];
                return NextMessage(out size);
            }
            Native.Check(result);
            size = (int)bytes;
            return action;
        }

        private void Connected()
        {
            lock (Gate)
            {
                if (IsClosed)
                    return;
                Native.Check(NativeMethods.swp_link_connected(link, SteadyClock.NowNs));
                Publish(true);
            }
        }

        private void OnMessage(byte[] message)
        {
            lock (Gate)
            {
                if (IsClosed)
                    return;
                ResultCode result;
                fixed (byte* start = message)
                    result = NativeMethods.swp_link_on_message(link, start, (ulong)message.Length, SteadyClock.NowNs);
                // After a message that cannot be parsed, the link's next action ends the stream.
                if (result != ResultCode.DataLoss)
                    Native.Check(result);
                Publish(true);
            }
        }

        private uint Disconnected(StreamEnd end)
        {
            lock (Gate)
            {
                if (IsClosed)
                    return Never;
                uint delayMs;
                using var memory = new CallMemory();
                Native.Check(NativeMethods.swp_link_disconnected(
                    link, end.Code, memory.Text(end.Message), memory.Pin(end.Details), (ulong)(end.Details?.Length ?? 0), SteadyClock.NowNs, &delayMs));
                Publish(true);
                return delayMs;
            }
        }

        private void Publish(bool hasNews)
        {
            status = mirror.Read(link, status, hasNews);
        }

        private sealed class BrokenStreamException : Exception
        {
            internal BrokenStreamException(Exception problem)
                : base(problem.Message, problem)
            {
            }
        }
    }
}
