#nullable enable
using System;
using System.Collections.Concurrent;
using System.Linq;
using System.Threading;

namespace Sweepstake
{
    /// <summary>
    /// Base of the classes that decide for a session on a thread of their own. Native calls are made under <see cref="Gate"/>, and never
    /// after this object is closed. The caller of Stop frees the native parts, because no frame may run then. All instances that have not
    /// been stopped are registered for <see cref="SweepstakeLibrary.Shutdown"/>. Thread-safe.
    /// </summary>
    public abstract class SessionWork : IDisposable
    {
        /// <summary>Maximum time that Dispose waits for the thread, in milliseconds.</summary>
        public const int DisposeTimeoutMs = 500;

        private static readonly ConcurrentDictionary<SessionWork, bool> Running = new ConcurrentDictionary<SessionWork, bool>();

        private readonly AutoResetEvent wake = new AutoResetEvent(false);
        private long wakeUpCount;
        private volatile bool isReleased;
        private volatile bool isAbandoned;
        private volatile Exception? failure;
        private Thread? thread;

        /// <param name="saved">They are given back if this fails.</param>
        private protected SessionWork(BroadPhaseSession session, SavedPriors? saved = null)
        {
            if (session?.Work != null)
                saved?.Close();
            Session = session ?? throw new ArgumentNullException(nameof(session));
            if (session.Work != null)
                throw new SweepstakeException(ResultCode.FailedPrecondition, "The session already has a decider; dispose of that one first.");
        }

        public BroadPhaseSession Session { get; }
        /// <summary>The exception that ended the thread; null while the thread runs or after it was stopped.</summary>
        public Exception? Failure => failure;
        /// <summary>Whether this object was stopped, also by <see cref="SweepstakeLibrary.Shutdown"/>.</summary>
        public bool HasEnded => isReleased;
        /// <summary>How often the thread has returned from <see cref="Sleep"/>.</summary>
        internal long WakeUpCount => Interlocked.Read(ref wakeUpCount);
        /// <summary>Lock that is held during native calls of this object, so that none runs after it is closed.</summary>
        private protected object Gate { get; } = new object();
        private protected bool HasThread => thread != null;
        private protected bool IsClosed { get; private set; }
        private protected bool IsStopping { get; private set; }
        /// <summary>Number of deciders and connections of this process that have not been stopped.</summary>
        public static int RunningCount => Running.Count;

        /// <summary>
        /// Ends this object, in an orderly way if the time allows. May be called more than once; later calls do not wait again for a thread
        /// that did not end during the first call. Do not call it during a frame.
        /// </summary>
        /// <returns>Whether its thread has ended. A thread that has not ended makes no more native calls.</returns>
        public bool Stop(int timeoutMs)
        {
            ulong endNs = SteadyClock.After(timeoutMs);
            BeginStop(endNs);
            bool hasEnded = EndStop(endNs);
            Release();
            return hasEnded;
        }

        public void Dispose() => Stop(DisposeTimeoutMs);

        /// <summary>Begins to end all instances, then waits for each until `endNs`. Returns them for <see cref="Release"/>.</summary>
        internal static SessionWork[] StopAll(ulong endNs)
        {
            SessionWork[] stopping = Running.Keys.ToArray();
            foreach (SessionWork work in stopping)
                work.BeginStop(endNs);
            foreach (SessionWork work in stopping)
                work.EndStop(endNs);
            return stopping;
        }

        /// <summary>Frees the native parts once; called after the thread has ended or the wait for it is over.</summary>
        internal void Release()
        {
            lock (Gate)
            {
                if (isReleased)
                    return;
                isReleased = true;
                CloseNative();
            }
            Session.Work = null;
            Running.TryRemove(this, out _);
        }

        /// <summary>
        /// Starts the thread; each derived constructor calls this last. If the name is null, no thread is started, and the game polls.
        /// </summary>
        private protected void Start(string? threadName)
        {
            Session.Work = this;
            Running.TryAdd(this, true);
            if (threadName == null)
                return;
            thread = new Thread(Run) { IsBackground = true, Name = threadName };
            thread.Start();
        }

        /// <summary>The body of the thread. If IsClosed is set, it returns soon after the thread is woken.</summary>
        private protected abstract void Serve();
        /// <summary>
        /// Called under the gate. Begins an orderly end that should be complete by `endNs`. After that time Stop no longer waits for it.
        /// </summary>
        private protected abstract void BeginNativeStop(ulong endNs);
        /// <summary>Called once under the gate, while no frame runs. Frees the native parts.</summary>
        private protected abstract void CloseNative();

        private protected void Wake() => wake.Set();

        /// <summary>Waits until Wake is called or the timeout has passed.</summary>
        private protected void Sleep(int timeoutMs)
        {
            wake.WaitOne(timeoutMs);
            Interlocked.Increment(ref wakeUpCount);
        }

        private void BeginStop(ulong endNs)
        {
            lock (Gate)
            {
                if (IsClosed)
                    return;
                IsStopping = true;
                BeginNativeStop(endNs);
            }
            Wake();
        }

        private bool EndStop(ulong endNs)
        {
            bool hasEnded = thread == null || thread.Join(isAbandoned ? 0 : SteadyClock.MsUntil(endNs));
            isAbandoned = !hasEnded;
            Close();
            Wake();
            return hasEnded;
        }

        private void Run()
        {
            try
            {
                Serve();
            }
            catch (Exception problem)
            {
                // An exception must not escape the thread. A native call also throws here if the session is shut down at the same time.
                failure = problem;
            }
            finally
            {
                Close();
            }
        }

        private void Close()
        {
            lock (Gate)
                IsClosed = true;
        }
    }
}
