#nullable enable
using System;
using System.Collections.Generic;
using Sweepstake.LowLevel;

namespace Sweepstake
{
    /// <summary>
    /// The frame path, which switches between backends. A frame is <see cref="BeginFrame"/>, <see cref="FindPairs(ReadOnlySpan{Aabb})"/> any
    /// number of times, <see cref="Pairs"/>, <see cref="EndFrame"/>, from any thread but one at a time. None of them waits, takes a lock or, in
    /// steady state, allocates. Decisions come from an <see cref="EmbeddedDecider"/> or a <see cref="DaemonConnection"/>; Dispose ends that
    /// object first.
    /// </summary>
    public sealed unsafe class BroadPhaseSession : NativeObject
    {
        private readonly byte[][] armNames;

        public BroadPhaseSession()
            : this(new SessionOptions())
        {
        }

        /// <exception cref="SweepstakeException">
        /// A value is out of range, a backend is unknown (the message lists them), or no thread is left.
        /// </exception>
        public BroadPhaseSession(SessionOptions options)
            : base(Create(options), NativeMethods.swp_session_destroy)
        {
            uint count;
            Check(NativeMethods.swp_session_arm_count(Pointer, &count));
            Arms = Native.Texts(count, NameOf);
            armNames = new byte[count][];
            for (int arm = 0; arm < armNames.Length; ++arm)
                armNames[arm] = System.Text.Encoding.UTF8.GetBytes(Arms[arm] + "\0");
        }

        /// <summary>The names of the backends in the order of arm indices.</summary>
        public IReadOnlyList<string> Arms { get; }

        /// <summary>The attached decider or connection; null if there is none.</summary>
        internal SessionWork? Work { get; set; }

        /// <summary>Begins a frame, and executes a switch that was commanded since the previous frame. A trial may also end in a search.</summary>
        public void BeginFrame()
        {
            Check(NativeMethods.swp_session_begin_frame(Pointer));
        }

        /// <summary>
        /// Passes these boxes to the active backend and searches for pairs. The number of boxes may change as in <see
        /// cref="BroadPhaseWorld.Update(ReadOnlySpan{Aabb})"/>. If a frame has several fixed updates, call this once for each of them. All
        /// searches of the frame give one sample.
        /// </summary>
        /// <exception cref="SweepstakeException">There are more pairs than <see cref="SessionOptions.MaxPairs"/>.</exception>
        public void FindPairs(ReadOnlySpan<Aabb> boxes)
        {
            fixed (Aabb* start = boxes)
                FindPairs(start, boxes.Length);
        }

        public void FindPairs(Aabb* boxes, int count)
        {
            Check(NativeMethods.swp_session_find_pairs(Pointer, boxes, checked((uint)count)));
        }

        /// <summary>The pairs of the latest search, in the library's memory: valid until the next search or frame.</summary>
        public ReadOnlySpan<OverlapPair> Pairs
        {
            get
            {
                OverlapPair* pairs;
                ulong count;
                Check(NativeMethods.swp_session_pairs(Pointer, &pairs, &count));
                return new ReadOnlySpan<OverlapPair>(pairs, checked((int)count));
            }
        }

        /// <param name="frameTimeNs">The unscaled time since the end of the previous frame, in nanoseconds.</param>
        /// <param name="flags"><see cref="FrameFlags.Paused"/> and <see cref="FrameFlags.Loading"/>; the library sets the others.</param>
        public void EndFrame(ulong frameTimeNs, FrameFlags flags = FrameFlags.None)
        {
            Check(NativeMethods.swp_session_end_frame(Pointer, frameTimeNs, (uint)flags));
        }

        /// <summary>
        /// Frees memory that the next frame does not need, for example at the end of a level. Do not call it during a frame.
        /// </summary>
        public void Trim()
        {
            Check(NativeMethods.swp_session_trim(Pointer));
        }

        /// <summary>Selects an arm from the next frame on; the mode does not change. Allocates nothing.</summary>
        /// <exception cref="ArgumentOutOfRangeException">The arm does not exist.</exception>
        public void SelectArm(int arm)
        {
            if (arm < 0 || arm >= armNames.Length)
                throw new ArgumentOutOfRangeException(nameof(arm));
            fixed (byte* name = armNames[arm])
                Check(NativeMethods.swp_session_select_arm(Pointer, name));
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
        /// <exception cref="SweepstakeException">
        /// The priors contain nothing for the project and these arms; the session is unchanged.
        /// </exception>
        public void Freeze(DeciderOptions? options = null)
        {
            if (options == null)
            {
                Check(NativeMethods.swp_session_freeze(Pointer, null));
                return;
            }
            using var memory = new CallMemory();
            NativeDeciderOptions native = options.With(memory);
            Check(NativeMethods.swp_session_freeze(Pointer, &native));
        }

        /// <summary>In <see cref="SessionMode.Manual"/> only the game selects arms. Call it on the frame thread.</summary>
        public SessionMode Mode
        {
            get
            {
                SessionMode mode;
                Check(NativeMethods.swp_session_mode(Pointer, &mode));
                return mode;
            }
            set => Check(NativeMethods.swp_session_set_mode(Pointer, value));
        }

        /// <summary>Index of the active arm in <see cref="Arms"/>. Read it on the frame thread.</summary>
        public int ActiveArm
        {
            get
            {
                uint arm;
                Check(NativeMethods.swp_session_active_arm(Pointer, &arm));
                return (int)arm;
            }
        }

        /// <summary>The number of switches executed. Read it on the frame thread.</summary>
        public uint SwitchEpoch
        {
            get
            {
                uint epoch;
                Check(NativeMethods.swp_session_switch_epoch(Pointer, &epoch));
                return epoch;
            }
        }

        /// <summary>The sample of the latest <see cref="EndFrame"/>; zeros before the first one. Read it on the frame thread.</summary>
        public FrameSample LastSample
        {
            get
            {
                FrameSample sample;
                Check(NativeMethods.swp_session_last_sample(Pointer, &sample));
                return sample;
            }
        }

        /// <summary>
        /// The decider's conclusion about the scene. Callable from any thread and cheap enough for each frame.
        /// </summary>
        public Verdict Verdict
        {
            get
            {
                Verdict verdict;
                Check(NativeMethods.swp_session_verdict(Pointer, &verdict));
                return verdict;
            }
        }

        /// <summary>
        /// The latest decision with its reasons. It stays available after the decider has ended. Callable from any thread.
        /// </summary>
        public Decision LastDecision
        {
            get
            {
                var decision = new Decision { StructSize = (uint)sizeof(Decision) };
                Check(NativeMethods.swp_session_last_decision(Pointer, &decision));
                return decision;
            }
        }

        /// <summary>
        /// The latest switch that has settled or was refused, whether the game or a decider requested it; zeros before the first. Callable
        /// from any thread.
        /// </summary>
        public SwitchOutcome LastOutcome
        {
            get
            {
                SwitchOutcome outcome;
                Check(NativeMethods.swp_session_last_outcome(Pointer, &outcome));
                return outcome;
            }
        }

        /// <summary>Samples dropped since the session began because the queue was full. Callable from any thread.</summary>
        public ulong DroppedSampleCount
        {
            get
            {
                ulong samples;
                Check(NativeMethods.swp_session_dropped(Pointer, &samples, null));
                return samples;
            }
        }

        /// <summary>
        /// Counters of the shadow lane, and its state. If the lane does not run, the state is the reason. Callable from any thread.
        /// </summary>
        public ShadowStats ShadowStats
        {
            get
            {
                var stats = new ShadowStats { StructSize = (uint)sizeof(ShadowStats) };
                Check(NativeMethods.swp_session_shadow_stats(Pointer, &stats));
                return stats;
            }
        }

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

        private string NameOf(uint arm)
        {
            byte* name;
            Check(NativeMethods.swp_session_arm_name(Pointer, arm, &name));
            return Native.Text(name);
        }

        private static IntPtr Create(SessionOptions options)
        {
            if (options == null)
                throw new ArgumentNullException(nameof(options));
            using var memory = new CallMemory();
            NativeSessionOptions native = options.With(memory);
            IntPtr session;
            Native.Check(NativeMethods.swp_session_create(&native, &session));
            return session;
        }
    }
}
