#nullable enable
using System;
using System.Collections.Generic;
using Sweepstake.LowLevel;

namespace Sweepstake
{
    /// <summary>
    /// The frame path, which switches between backends. A frame is <see cref="BeginFrame"/>, <see cref="FindPairs(ReadOnlySpan{Aabb})"/> any number
    /// of times, <see cref="Pairs"/>, <see cref="EndFrame"/>, from any thread but one at a time. None of them waits, takes a lock or, in steady
    /// state, allocates. Decisions come from an <see cref="EmbeddedDecider"/> or a <see cref="DaemonConnection"/>; Dispose ends that object first.
    /// </summary>
    public sealed unsafe class BroadPhaseSession : NativeObject
    {
        /// <param name="options">Null for the defaults.</param>
        /// <exception cref="SweepstakeException">A value or a backend is wrong (the message lists the backends), or no thread is left.</exception>
        public BroadPhaseSession(SessionOptions? options = null)
            : base(Create(options), NativeMethods.swp_session_destroy)
        {
            Arms = Native.Texts(Read<uint>((self, count) => NativeMethods.swp_session_arm_count(self, count)), arm => Native.Text(NameOf(arm)));
        }

        /// <summary>The names of the backends in the order of arm indices.</summary>
        public IReadOnlyList<string> Arms { get; }
        /// <summary>The attached decider or connection; null if there is none.</summary>
        internal SessionWork? Work { get; set; }

        /// <summary>Begins a frame, and executes a switch that was commanded since the previous frame. A trial may also end in a search.</summary>
        public void BeginFrame() => Check(NativeMethods.swp_session_begin_frame(Pointer));

        /// <summary>
        /// Passes these boxes to the active backend and searches for pairs. The number of boxes may change as in <see
        /// cref="BroadPhaseWorld.Update(ReadOnlySpan{Aabb})"/>. If a frame has several fixed updates, call this once for each of them. All
        /// searches of the frame give one sample.
        /// </summary>
        /// <exception cref="SweepstakeException">There are more pairs than <see cref="SessionOptions.MaxPairs"/>.</exception>
        public void FindPairs(ReadOnlySpan<Aabb> boxes)
        {
            fixed (Aabb* start = boxes)
                Check(NativeMethods.swp_session_find_pairs(Pointer, start, (uint)boxes.Length));
        }

        /// <summary>The pairs of the latest search, in the library's memory: valid until the next search or frame.</summary>
        public ReadOnlySpan<OverlapPair> Pairs => ReadArray<OverlapPair>((self, pairs, count) => NativeMethods.swp_session_pairs(self, pairs, count));

        /// <param name="frameTimeNs">The unscaled time since the end of the previous frame, in nanoseconds.</param>
        /// <param name="flags"><see cref="FrameFlags.Paused"/> and <see cref="FrameFlags.Loading"/>; the library sets the others.</param>
        public void EndFrame(ulong frameTimeNs, FrameFlags flags = FrameFlags.None) =>
            Check(NativeMethods.swp_session_end_frame(Pointer, frameTimeNs, (uint)flags));

        /// <summary>Frees memory that the next frame does not need, for example at the end of a level. Do not call it during a frame.</summary>
        public void Trim() => Check(NativeMethods.swp_session_trim(Pointer));

        /// <summary>Selects an arm from the next frame on; the mode does not change. Allocates nothing.</summary>
        /// <exception cref="ArgumentOutOfRangeException">The arm does not exist.</exception>
        public void SelectArm(int arm)
        {
            if (arm < 0 || arm >= Arms.Count)
                throw new ArgumentOutOfRangeException(nameof(arm));
            Check(NativeMethods.swp_session_select_arm(Pointer, NameOf((uint)arm)));
        }

        /// <summary>Selects an arm from the next frame on; the mode does not change.</summary>
        /// <exception cref="SweepstakeException">The arm does not exist; the message lists the arms.</exception>
        public void SelectArm(string arm)
        {
            using var memory = new CallMemory();
            Check(NativeMethods.swp_session_select_arm(Pointer, memory.Text(arm)));
        }

        /// <summary>
        /// Selects the arm with the lowest expected cost in the priors of these options, from the next frame on. Use it for runs that must
        /// repeat bit for bit (builds, replays, tournaments). The session is then in <see cref="SessionMode.Manual"/>, where nothing depends on time: no clock
        /// is read, samples have no detection time, and commands and orders are refused. <see cref="SelectArm(int)"/> still works; setting
        /// <see cref="Mode"/> ends the freeze. Call it on the frame thread.
        /// </summary>
        /// <param name="options">Null: the session keeps its arm.</param>
        /// <exception cref="SweepstakeException">The priors contain nothing for the project and these arms; the session is unchanged.</exception>
        public void Freeze(DeciderOptions? options = null)
        {
            using var memory = new CallMemory();
            NativeDeciderOptions native = options?.With(memory) ?? default;
            Check(NativeMethods.swp_session_freeze(Pointer, options == null ? null : &native));
        }

        /// <summary>In <see cref="SessionMode.Manual"/> only the game selects arms. Call it on the frame thread.</summary>
        public SessionMode Mode
        {
            get => Read<SessionMode>((self, mode) => NativeMethods.swp_session_mode(self, mode));
            set => Check(NativeMethods.swp_session_set_mode(Pointer, value));
        }

        /// <summary>Index of the active arm in <see cref="Arms"/>. Read it on the frame thread.</summary>
        public int ActiveArm => (int)Read<uint>((self, arm) => NativeMethods.swp_session_active_arm(self, arm));
        /// <summary>The number of switches executed. Read it on the frame thread.</summary>
        public uint SwitchEpoch => Read<uint>((self, epoch) => NativeMethods.swp_session_switch_epoch(self, epoch));
        /// <summary>The sample of the latest <see cref="EndFrame"/>; zeros before the first one. Read it on the frame thread.</summary>
        public FrameSample LastSample => Read<FrameSample>((self, sample) => NativeMethods.swp_session_last_sample(self, sample));
        /// <summary>The decider's conclusion about the scene. Callable from any thread and cheap enough for each frame.</summary>
        public Verdict Verdict => Read<Verdict>((self, verdict) => NativeMethods.swp_session_verdict(self, verdict));

        /// <summary>The latest decision with its reasons. It stays available after the decider has ended. Callable from any thread.</summary>
        public Decision LastDecision =>
            Read((self, decision) => NativeMethods.swp_session_last_decision(self, decision), new Decision { StructSize = (uint)sizeof(Decision) });

        /// <summary>The latest switch that has settled or was refused, also of the game; zeros before the first. Callable from any thread.</summary>
        public SwitchOutcome LastOutcome => Read<SwitchOutcome>((self, outcome) => NativeMethods.swp_session_last_outcome(self, outcome));
        /// <summary>Samples dropped since the session began because the queue was full. Callable from any thread.</summary>
        public ulong DroppedSampleCount => Read<ulong>((self, samples) => NativeMethods.swp_session_dropped(self, samples, null));

        /// <summary>
        /// Counters of the shadow lane, and its state. If the lane does not run, the state is the reason. Callable from any thread.
        /// </summary>
        public ShadowStats ShadowStats =>
            Read((self, stats) => NativeMethods.swp_session_shadow_stats(self, stats), new ShadowStats { StructSize = (uint)sizeof(ShadowStats) });

        /// <summary>The version of an arm's code; evidence of different versions is not combined. Callable from any thread.</summary>
        public uint VersionOf(int arm)
        {
            uint version;
            Check(NativeMethods.swp_session_arm_version(Pointer, checked((uint)arm), &version));
            return version;
        }

        public override void Dispose()
        {
            Work?.Dispose();
            base.Dispose();
        }

        private byte* NameOf(uint arm)
        {
            byte* name;
            Check(NativeMethods.swp_session_arm_name(Pointer, arm, &name));
            return name;
        }

        private static IntPtr Create(SessionOptions? options)
        {
            using var memory = new CallMemory();
            NativeSessionOptions native = (options ?? new SessionOptions()).With(memory);
            IntPtr session;
            Native.Check(NativeMethods.swp_session_create(&native, &session));
            return session;
        }
    }
}
