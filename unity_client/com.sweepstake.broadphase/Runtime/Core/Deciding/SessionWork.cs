#nullable enable
using System;
using System.Collections.Generic;
using System.Threading;

namespace Sweepstake
{
    /// <summary>
    /// What decides for a session from a thread of its own: its native calls are made under a gate, and none after it was closed. What is
    /// native is given back by whoever stops it, since no frame may run then. All that was not stopped is known, for
    /// <see cref="SweepstakeLibrary.Shutdown"/>. Thread-safe.
    /// </summary>
    public abstract class SessionWork : IDisposable
    {
        /// <summary>How long Dispose waits at most, in milliseconds.</summary>
        public const int DisposeTimeoutMs = 500;

        private static readonly object RunningGate = new object();
        private static readonly HashSet<SessionWork> Running = new HashSet<SessionWork>();

        private readonly object wakeGate = new object();
        private bool isWoken;
        private bool isReleased;
        private volatile bool isAbandoned;
        private volatile Exception? failure;
        private Thread? thread;

        private protected SessionWork(BroadPhaseSession session)
        {
            Session = session ?? throw new ArgumentNullException(nameof(session));
            if (session.Work != null)
                throw new SweepstakeException(ResultCode.FailedPrecondition, "The session has a decider already; dispose of that one first.");
        }

        public BroadPhaseSession Session { get; }

        /// <summary>Why its thread has ended by itself; null: it runs, or was stopped.</summary>
        public Exception? Failure => failure;

        /// <summary>Held during native calls of this work, which must not be closed then.</summary>
        private protected object Gate { get; } = new object();
        private protected bool IsClosed { get; private set; }
        private protected bool IsStopping { get; private set; }

        /// <summary>The deciders and connections of this process that were not stopped.</summary>
        public static int RunningCount
        {
            get
            {
                lock (RunningGate)
                    return Running.Count;
            }
        }

        /// <summary>
        /// Ends it as orderly as the time allows. May be called more than once: a thread that has outlived one stop is not waited for again.
        /// Not in the midst of a frame.
        /// </summary>
        /// <returns>Whether its thread has ended; one that has not makes no more native calls.</returns>
        public bool Stop(int timeoutMs)
        {
            ulong endNs = SteadyClock.NowNs + (ulong)Math.Max(0, timeoutMs) * 1_000_000;
            BeginStop(endNs);
            bool hasEnded = EndStop(endNs);
            Release();
            return hasEnded;
        }

        public void Dispose()
        {
            Stop(DisposeTimeoutMs);
        }

        /// <summary>Asks all to end at once, then waits for each until then. Returns them, for <see cref="Release"/>.</summary>
        internal static SessionWork[] StopAll(ulong endNs)
        {
            SessionWork[] stopping;
            lock (RunningGate)
            {
                stopping = new SessionWork[Running.Count];
                Running.CopyTo(stopping);
            }
            foreach (SessionWork work in stopping)
                work.BeginStop(endNs);
            foreach (SessionWork work in stopping)
                work.EndStop(endNs);
            return stopping;
        }

        /// <summary>Gives back what is native, once, after its end.</summary>
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
            lock (RunningGate)
                Running.Remove(this);
        }

        /// <summary>To be called last by the constructor. Without a thread the game polls.</summary>
        private protected void Start(string? threadName)
        {
            Session.Work = this;
            lock (RunningGate)
                Running.Add(this);
            if (threadName == null)
                return;
            thread = new Thread(Run) { IsBackground = true, Name = threadName };
            thread.Start();
        }

        /// <summary>The thread's whole work; returns soon after it was woken, once IsClosed.</summary>
        private protected abstract void Serve();
        /// <summary>Under the gate: begins an orderly end that is over by then.</summary>
        private protected abstract void BeginNativeStop(ulong endNs);
        /// <summary>Under the gate, once, while no frame runs: gives back what is native.</summary>
        private protected abstract void CloseNative();

        private protected void Wake()
        {
            lock (wakeGate)
            {
                isWoken = true;
                Monitor.Pulse(wakeGate);
            }
        }

        /// <summary>Waits until it is woken, at most so long.</summary>
        private protected void Sleep(int timeoutMs)
        {
            lock (wakeGate)
            {
                if (!isWoken)
                    Monitor.Wait(wakeGate, timeoutMs);
                isWoken = false;
            }
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
            bool hasEnded = thread == null || thread.Join(isAbandoned ? 0 : MsUntil(endNs));
            isAbandoned = !hasEnded;
            Close();
            Wake();
            return hasEnded;
        }

        private static int MsUntil(ulong endNs)
        {
            ulong nowNs = SteadyClock.NowNs;
            return nowNs < endNs ? (int)((endNs - nowNs) / 1_000_000) + 1 : 0;
        }

        private void Run()
        {
            try
            {
                Serve();
            }
            catch (Exception problem)
            {
                // Nothing may leave a thread. A session that was shut down beside it ends it so too.
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
