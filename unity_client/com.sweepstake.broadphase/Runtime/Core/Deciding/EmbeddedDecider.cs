#nullable enable
using System;
using System.Threading;
using Sweepstake.LowLevel;

namespace Sweepstake
{
    /// <summary>The state of an <see cref="EmbeddedDecider"/> at one moment. It is immutable, so any thread may keep it.</summary>
    public sealed class DeciderStatus
    {
        internal DeciderStatus(ulong decisionCount, ulong priorSourceCount, ReadOnlyMemory<Belief> beliefs)
        {
            DecisionCount = decisionCount;
            PriorSourceCount = priorSourceCount;
            Beliefs = beliefs;
        }

        /// <summary>Number of decisions since the decider was created.</summary>
        public ulong DecisionCount { get; }
        /// <summary>Number of sources (sessions or installations) whose evidence is in the loaded priors; 0: the priors are Beta(1,1).</summary>
        public ulong PriorSourceCount { get; }
        /// <summary>The posteriors in the order of arms.</summary>
        public ReadOnlyMemory<Belief> Beliefs { get; }
    }

    /// <summary>
    /// "AI Decides" without a daemon: decides in this process, on its own thread that polls every 100 ms, or in the game's calls of
    /// <see cref="Poll"/>. Nothing leaves the machine. Create and dispose of it while no frame runs.
    /// </summary>
    public sealed unsafe class EmbeddedDecider : SessionWork
    {
        private const int PollIntervalMs = 100;
        private readonly SavedPriors? saved;
        private byte[] savedBytes;
        private volatile bool mustSave;
        private volatile bool isPaused;
        private volatile DeciderStatus status = new DeciderStatus(0, 0, default);

        /// <param name="options">Null for the defaults.</param>
        /// <param name="ownThread">False: the game calls <see cref="Poll"/> from any thread, every 250 ms or more often.</param>
        /// <exception cref="SweepstakeException">
        /// The session already has a decider or a connection, a value is out of range, or the priors are missing or broken. The message names a
        /// broken record.
        /// </exception>
        public EmbeddedDecider(BroadPhaseSession session, DeciderOptions? options = null, bool ownThread = true)
            : base(session, options?.Saved)
        {
            options ??= new DeciderOptions();
            saved = options.Saved;
            try
            {
                Attach(options);
            }
            catch
            {
                saved?.Close();
                throw;
            }
            try
            {
                savedBytes = saved == null ? Array.Empty<byte>() : ExportPriors();
                Publish();
            }
            catch
            {
                saved?.Close();
                _ = NativeMethods.swp_session_detach_decider(Session.Pointer);
                throw;
            }
            Start(ownThread ? "sweepstake decider" : null);
        }

        private void Attach(DeciderOptions options)
        {
            using var memory = new CallMemory();
            NativeDeciderOptions native = options.With(memory);
            try
            {
                Native.Check(NativeMethods.swp_session_attach_decider(Session.Pointer, &native, SteadyClock.NowNs));
            }
            catch (SweepstakeException unreadable) when (saved?.SetAside(unreadable) == true)
            {
                Attach(options);
            }
        }

        /// <summary>The state after the latest decision. Each decision creates a new object. Callable from any thread and in each frame.</summary>
        public DeciderStatus Status => status;

        /// <summary>While this is set, the decider's own thread sleeps, and keeps what it has learnt. Set it while no frames run for long.</summary>
        public bool IsPaused
        {
            get => isPaused;
            set
            {
                isPaused = value;
                Wake();
            }
        }

        /// <summary>Reads the frames since the last poll, and makes a due decision. It allocates, and waits for a poll of another thread.</summary>
        /// <param name="nowNs">The time of <see cref="SteadyClock"/>. Without the decider's own thread, any other steady clock works
        /// too.</param>
        /// <returns>Whether a switch was commanded.</returns>
        public bool Poll(ulong nowNs)
        {
            uint commanded = 0;
            lock (Gate)
            {
                if (IsClosed)
                    return false;
                Native.Check(NativeMethods.swp_session_poll_decider(Session.Pointer, nowNs, null, &commanded));
                Publish();
            }
            return commanded != 0;
        }

        /// <summary>
        /// Returns all records that the decider has loaded, and what it has learnt since. They are for the next run's <see
        /// cref="DeciderOptions.PriorsData"/> or for `sweepstake priors import`. Call this before Dispose, which discards the records.
        /// </summary>
        /// <exception cref="SweepstakeException">The decider has ended. If it failed, the message says why.</exception>
        public byte[] ExportPriors()
        {
            lock (Gate)
            {
                if (IsClosed)
                    throw new SweepstakeException(ResultCode.FailedPrecondition, EndReason(), Failure);
                ulong bytes;
                ResultCode result = NativeMethods.swp_session_export_priors(Session.Pointer, null, 0, &bytes);
                if (result != ResultCode.ResourceExhausted)
                    Native.Check(result);
                var priors = new byte[checked((int)bytes)];
                fixed (byte* start = priors)
                    Native.Check(NativeMethods.swp_session_export_priors(Session.Pointer, start, bytes, &bytes));
                return priors;
            }
        }

        /// <summary>
        /// Begins to write what the decider has learnt to <see cref="DeciderOptions.Saved"/> and does not wait, if the decider has a thread. Its
        /// end saves too, so call this only where the process may end without it, as when a mobile game is paused.
        /// </summary>
        public void BeginSave()
        {
            mustSave = true;
            if (HasThread)
                Wake();
            else
                SaveNow();
        }

        private void SaveNow()
        {
            mustSave = false;
            if (saved == null)
                return;
            lock (Gate)
            {
                if (IsClosed)
                    return;
                byte[] priors = ExportPriors();
                if (priors.AsSpan().SequenceEqual(savedBytes))
                    return;
                savedBytes = priors;
            }
            saved.Save(savedBytes);
        }

        private string EndReason() => Failure == null
            ? "The decider has ended; export its priors before you dispose of it."
            : "The decider has failed, and what it has learnt is lost; create another one. The failure: " + Failure.Message;

        private void Publish()
        {
            ulong decisions, sources;
            uint count;
            Native.Check(NativeMethods.swp_session_decision_count(Session.Pointer, &decisions));
            if (decisions == status.DecisionCount && status.Beliefs.Length > 0)
                return;
            var beliefs = new Belief[Session.Arms.Count];
            fixed (Belief* start = beliefs)
                Native.Check(NativeMethods.swp_session_beliefs(Session.Pointer, start, (uint)beliefs.Length, &count));
            Native.Check(NativeMethods.swp_session_prior_source_count(Session.Pointer, &sources));
            status = new DeciderStatus(decisions, sources, beliefs);
        }

        private protected override void Serve()
        {
            while (!IsStopping)
            {
                if (!isPaused)
                    Poll(SteadyClock.NowNs);
                if (mustSave)
                    SaveNow();
                Sleep(isPaused ? Timeout.Infinite : PollIntervalMs);
            }
            SaveNow();
        }

        private protected override void BeginNativeStop(ulong endNs)
        {
            if (!HasThread)
                SaveNow();
        }

        private protected override void CloseNative()
        {
            saved?.Close();
            if (Session.HasPointer)
                NativeMethods.swp_session_detach_decider(Session.Pointer);
        }
    }
}
