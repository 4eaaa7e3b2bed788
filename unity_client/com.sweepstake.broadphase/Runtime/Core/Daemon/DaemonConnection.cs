#nullable enable
using System;
using System.IO;
using System.Threading;
using System.Threading.Tasks;
using Sweepstake.LowLevel;

namespace Sweepstake
{
    /// <summary>
    /// Connects a session to a daemon. A separate thread moves the bytes of the native link over a transport. The native link handles batches,
    /// resending, back-off, resuming and the commands for the frame path. The frame thread never waits for the connection. If the daemon is absent,
    /// slow or killed, the game continues, and the connection is made again automatically. Create this object and dispose of it while no frame runs.
    /// </summary>
    public sealed unsafe class DaemonConnection : SessionWork
    {
        private const int TickMs = 5;
        // Until the daemon answers, only the native link's time limit for the answer is checked.
        private const int UnansweredTickMs = 250;
        private const uint Never = uint.MaxValue; // SWP_LINK_NEVER
        private const uint MinBufferBytes = 8 * 1024;

        private readonly ITelemetryTransport transport;
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
                // Reading the exception marks the failed write as observed. The read that ends the stream reports the failure itself.
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

        /// <summary>The latest status. Each change creates a new object. Callable from any thread and cheap enough for each frame.</summary>
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
                status = status.Closed();
                transport.Dispose();
            }
        }

        private protected override void BeginNativeStop(ulong endNs)
        {
            // Cancel the stream after 4/5 of the remaining time, so that the thread has 1/5 to end.
            NativeMethods.swp_link_goodbye(link, SteadyClock.After(SteadyClock.MsUntil(endNs) / 5 * 4));
        }

        private protected override void CloseNative()
        {
            NativeMethods.swp_link_destroy(link);
            link = IntPtr.Zero;
            status = status.Closed();
        }

        /// <summary>Sleeps until the next stream is due; false if there will not be another. Allocates nothing; only Stop wakes it early.</summary>
        private bool WaitForStream(uint delayMs)
        {
            ulong dueNs = SteadyClock.After((int)delayMs);
            while (delayMs != Never && EmptyQueue())
            {
                int leftMs = SteadyClock.MsUntil(dueNs);
                if (leftMs == 0)
                    return true;
                Sleep(leftMs);
            }
            return false;
        }

        /// <summary>Reads the session's samples, so that its queue has room during the next delay. False if this object is being stopped.</summary>
        private bool EmptyQueue()
        {
            lock (Gate)
            {
                if (IsStopping || IsClosed)
                    return false;
                CallNextMessage(false, out _);
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
                Call(() => NativeMethods.swp_link_connected(link, SteadyClock.NowNs));
                try
                {
                    return Disconnected(MoveBytes(stream));
                }
                catch (IOException broken)
                {
                    return Disconnected(new StreamEnd(StreamEnd.Unavailable, broken.Message));
                }
            }
        }

        private StreamEnd MoveBytes(ITelemetryStream stream)
        {
            Task<byte[]?> read = Begun(stream.ReadAsync);
            Task write = Task.CompletedTask;
            bool isFinishing = false;
            while (true)
            {
                for (; read.IsCompleted; read = Begun(stream.ReadAsync))
                {
                    if (!read.IsCompletedSuccessfully || read.Result == null)
                        return stream.End;
                    OnMessage(read.Result);
                }
                LinkAction action = NextAction(write.IsCompletedSuccessfully, out int size);
                if (action == LinkAction.Cancel)
                    return new StreamEnd(StreamEnd.Cancelled, "");
                if (action == LinkAction.Send)
                    write = BegunWrite(stream, size);
                isFinishing |= action == LinkAction.Finish;
                if (isFinishing && write.IsCompletedSuccessfully)
                {
                    write = Begun(stream.FinishAsync);
                    isFinishing = false;
                }
                if (action != LinkAction.Send)
                    Sleep(IsStopping || status.State == LinkState.Online ? TickMs : UnansweredTickMs);
            }
        }

        private Task BegunWrite(ITelemetryStream stream, int size) => Begun(() => stream.WriteAsync(new ArraySegment<byte>(buffer, 0, size)));

        /// <exception cref="IOException">The stream threw an exception instead of returning a failed task.</exception>
        private TTask Begun<TTask>(Func<TTask> call)
            where TTask : Task
        {
            TTask task;
            try
            {
                task = call();
            }
            catch (Exception problem)
            {
                throw new IOException(problem.Message, problem);
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
                LinkAction action = CallNextMessage(canWrite, out size);
                status = status.Updated(link, false);
                return action;
            }
        }

        private LinkAction CallNextMessage(bool canWrite, out int size)
        {
            ulong bytes = 0;
            LinkAction action = LinkAction.None;
            ResultCode result;
            fixed (byte* start = buffer)
                result = NativeMethods.swp_link_next_message(link, SteadyClock.NowNs, start, canWrite ? (ulong)buffer.Length : 0, &bytes, &action);
            size = checked((int)bytes);
            if (result == ResultCode.ResourceExhausted && canWrite)
            {
                buffer = new byte[size];
                return CallNextMessage(true, out size);
            }
            if (result != ResultCode.ResourceExhausted)
                Native.Check(result);
            return action == LinkAction.Send && !canWrite ? LinkAction.None : action;
        }

        private void OnMessage(byte[] message) => Call(() =>
        {
            fixed (byte* start = message)
                return NativeMethods.swp_link_on_message(link, start, (ulong)message.Length, SteadyClock.NowNs);
        });

        /// <summary>Calls a function of the link and updates the status. Does nothing once this object is closed.</summary>
        private void Call(Func<ResultCode> function)
        {
            lock (Gate)
            {
                if (IsClosed)
                    return;
                ResultCode result = function();
                // After a message that cannot be parsed, the link's next action ends the stream.
                if (result != ResultCode.DataLoss)
                    Native.Check(result);
                status = status.Updated(link, true);
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
                status = status.Updated(link, true);
                return delayMs;
            }
        }
    }
}
