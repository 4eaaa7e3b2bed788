#nullable enable
using Sweepstake.LowLevel;

namespace Sweepstake
{
    /// <summary>How a <see cref="BroadPhaseSession"/> runs; a new one holds the library's defaults.</summary>
    public sealed unsafe class SessionOptions
    {
        private NativeSessionOptions native;

        /// <exception cref="NativeLibraryException">The library does not fit.</exception>
        public SessionOptions()
        {
            SweepstakeLibrary.EnsureLoaded();
            native.StructSize = (uint)sizeof(NativeSessionOptions);
            fixed (NativeSessionOptions* options = &native)
                Native.Check(NativeMethods.swp_session_options_init(options));
        }

        /// <summary>Names of backends, each once, separated by commas; null or empty: all.</summary>
        public string? Arms { get; set; }
        /// <summary>Null or empty: the first of <see cref="Arms"/>, or KDTree if those are all.</summary>
        public string? InitialArm { get; set; }
        public SessionMode Mode { get => native.Mode; set => native.Mode = value; }
        /// <summary>In nanoseconds, above 0: a longer frame is flagged, and a bail-out where its arm is to blame. A welcome replaces it.</summary>
        public ulong BailOutNs { get => native.BailOutNs; set => native.BailOutNs = value; }
        /// <summary>How long, in nanoseconds, after a switch nothing is learnt; a trial lasts for twice that. A daemon's welcome replaces it.</summary>
        public ulong SettlingNs { get => native.SettlingNs; set => native.SettlingNs = value; }
        /// <summary>As in <see cref="WorldOptions"/>.</summary>
        public uint ThreadCount { get => native.ThreadCount; set => native.ThreadCount = value; }
        /// <summary>Samples kept for a decider or a link, a power of two, 2 to 2^20; full: the oldest is dropped and counted.</summary>
        public uint QueueFrames { get => native.QueueFrames; set => native.QueueFrames = value; }
        public ShadowMode Shadow { get => native.Shadow; set => native.Shadow = value; }
        /// <summary>Pairs ascend whatever the arm, so that a lockstep game sees no switch.</summary>
        public bool IsSorted { get => native.SortedPairs != 0; set => native.SortedPairs = value ? 1u : 0u; }
        /// <summary>The lane's share of one core at most, over 0 to 1.</summary>
        public double ShadowDutyRatio { get => native.ShadowDutyRatio; set => native.ShadowDutyRatio = value; }
        /// <summary>The lane's maximum, half of it for copied boxes.</summary>
        public ulong ShadowMemoryBytes { get => native.ShadowMemoryBytes; set => native.ShadowMemoryBytes = value; }
        /// <summary>Of all arms, the pairs and the lane; 0: no limit.</summary>
        public ulong MemoryBudgetBytes { get => native.MemoryBudgetBytes; set => native.MemoryBudgetBytes = value; }

        internal NativeSessionOptions With(CallMemory memory)
        {
            NativeSessionOptions options = native;
            options.Arms = memory.Text(Arms);
            options.InitialArm = memory.Text(InitialArm);
            return options;
        }
    }
}
