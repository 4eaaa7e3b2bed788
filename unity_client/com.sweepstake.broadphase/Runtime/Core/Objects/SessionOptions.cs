#nullable enable
using Sweepstake.LowLevel;

namespace Sweepstake
{
    /// <summary>How a <see cref="BroadPhaseSession"/> runs; a new object holds the library's defaults.</summary>
    public sealed unsafe class SessionOptions
    {
        private NativeSessionOptions native = SweepstakeLibrary.Defaults(
            new NativeSessionOptions { StructSize = (uint)sizeof(NativeSessionOptions) }, options => NativeMethods.swp_session_options_init(options));

        /// <summary>Names of backends, each once, separated by commas; null or empty for all.</summary>
        public string? Arms { get; set; }
        /// <summary>Name of the first active backend. Null or empty: the first of <see cref="Arms"/>, or KDTree if Arms is empty.</summary>
        public string? InitialArm { get; set; }
        public SessionMode Mode { get => native.Mode; set => native.Mode = value; }
        /// <summary>
        /// Bail-out limit in nanoseconds, above 0. A frame above the limit is flagged. If the active arm caused it, another arm replaces
        /// that arm at once. When the session connects to a daemon, the daemon's value replaces this one.
        /// </summary>
        public ulong BailOutNs { get => native.BailOutNs; set => native.BailOutNs = value; }
        /// <summary>
        /// Time in nanoseconds after a switch that is excluded from learning. A trial (the first live frames of an arm) lasts twice as
        /// long. When the session connects to a daemon, the daemon's value replaces this one.
        /// </summary>
        public ulong SettlingNs { get => native.SettlingNs; set => native.SettlingNs = value; }
        /// <summary>Number of threads that search, as in <see cref="WorldOptions.ThreadCount"/>.</summary>
        public uint ThreadCount { get => native.ThreadCount; set => native.ThreadCount = value; }
        /// <summary>
        /// Capacity of the queue of samples for a decider or a link: a power of two, 2 to 2^20. If the queue is full, the oldest sample is
        /// dropped and counted.
        /// </summary>
        public uint QueueFrames { get => native.QueueFrames; set => native.QueueFrames = value; }
        public ShadowMode Shadow { get => native.Shadow; set => native.Shadow = value; }
        /// <summary>Sorts the pairs with every arm, so that switches do not change the results of a lockstep game.</summary>
        public bool IsSorted { get => native.SortedPairs != 0; set => native.SortedPairs = value ? 1u : 0u; }
        /// <summary>Largest share of one core that the shadow lane uses, above 0 and up to 1.</summary>
        public double ShadowDutyRatio { get => native.ShadowDutyRatio; set => native.ShadowDutyRatio = value; }
        /// <summary>Largest memory of the shadow lane in bytes; half of it is for copied boxes.</summary>
        public ulong ShadowMemoryBytes { get => native.ShadowMemoryBytes; set => native.ShadowMemoryBytes = value; }
        /// <summary>Limit in bytes for all arms, the pairs and the lane together; 0: no limit.</summary>
        public ulong MemoryBudgetBytes { get => native.MemoryBudgetBytes; set => native.MemoryBudgetBytes = value; }
        /// <summary>
        /// The maximum number of pairs of a search, as in <see cref="WorldOptions.MaxPairs"/>. After a search with more pairs, end the frame as
        /// usual; the next search works again.
        /// </summary>
        public ulong MaxPairs { get => native.MaxPairs; set => native.MaxPairs = value; }

        internal NativeSessionOptions With(CallMemory memory)
        {
            NativeSessionOptions options = native;
            options.Arms = memory.Text(Arms);
            options.InitialArm = memory.Text(InitialArm);
            return options;
        }
    }
}
