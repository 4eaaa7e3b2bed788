#nullable enable
using Sweepstake.LowLevel;

namespace Sweepstake
{
    /// <summary>
    /// Options of a <see cref="DaemonConnection"/>: the names that it sends to the daemon, and limits of its batches and delays. A new object holds
    /// the library's defaults. Texts are names of at most 128 bytes of UTF-8. All of them leave the machine if the daemon runs on another one.
    /// </summary>
    public sealed unsafe class LinkOptions
    {
        private const ulong DaemonValue = ulong.MaxValue; // SWP_DAEMON_VALUE
        private NativeLinkOptions native = SweepstakeLibrary.Defaults(
            new NativeLinkOptions { StructSize = (uint)sizeof(NativeLinkOptions) }, options => NativeMethods.swp_link_options_init(options));

        /// <summary>The name of the daemon in messages, such as its address; null for no name.</summary>
        public string? Daemon { get; set; }
        /// <summary>Name of the project; null for "default".</summary>
        public string? Project { get; set; }
        /// <summary>Name of the scene; null for "default".</summary>
        public string? Scene { get; set; }
        /// <summary>Build of the game; null if unknown.</summary>
        public string? Build { get; set; }
        /// <summary>Class of machines whose timings are comparable. Null: derived from processor, threads, instruction set and memory.</summary>
        public string? MachineClass { get; set; }
        /// <summary>Name of the policy; null for the daemon's default.</summary>
        public string? Policy { get; set; }
        /// <summary>Seed of the daemon's exploration and random draws; 0: the daemon chooses.</summary>
        public ulong Seed { get => native.Seed; set => native.Seed = value; }
        /// <summary>
        /// Interval between decisions in nanoseconds, 250 ms or more; null: that of the daemon's configuration, and so for the next three.
        /// </summary>
        public ulong? DecisionIntervalNs { get => Chosen(native.DecisionIntervalNs); set => native.DecisionIntervalNs = value ?? DaemonValue; }
        /// <summary>Minimum interval between switches that the policy chooses, in nanoseconds.</summary>
        public ulong? CooldownNs { get => Chosen(native.CooldownNs); set => native.CooldownNs = value ?? DaemonValue; }
        /// <summary>Time after a switch that is excluded from learning, in nanoseconds.</summary>
        public ulong? SettlingNs { get => Chosen(native.SettlingNs); set => native.SettlingNs = value ?? DaemonValue; }
        /// <summary>Weights of the paper's reward.</summary>
        public RewardWeights? Weights
        {
            get => native.Weights.IsUnset ? (RewardWeights?)null : native.Weights;
            set => native.Weights = value ?? default;
        }
        /// <summary>
        /// Factor from 1 to 1000 by which the decider's intervals are divided. A daemon refuses values above 1 unless it is configured to allow them.
        /// </summary>
        public double TimeScale { get => native.TimeScale; set => native.TimeScale = value; }
        /// <summary>Seed of the random delays between attempts to connect; 0: a different seed for each connection.</summary>
        public ulong JitterSeed { get => native.JitterSeed; set => native.JitterSeed = value; }
        /// <summary>Lets operators of the daemon choose mode and arm. Leave it off in a game that is shipped to players.</summary>
        public bool AllowsOperatorOrders { get => native.AllowOperatorOrders != 0; set => native.AllowOperatorOrders = value ? 1u : 0u; }
        /// <summary>Starts from Beta(1,1) and ignores stored priors.</summary>
        public bool IgnoresPriors { get => native.IgnorePriors != 0; set => native.IgnorePriors = value ? 1u : 0u; }
        /// <summary>Maximum time in milliseconds that a frame waits for its batch to be sent, 1 to 10,000.</summary>
        public uint BatchIntervalMs { get => native.BatchIntervalMs; set => native.BatchIntervalMs = value; }
        /// <summary>Maximum number of frames in a batch, 1 to 240.</summary>
        public uint BatchFrames { get => native.BatchFrames; set => native.BatchFrames = value; }
        /// <summary>Maximum size of a batch in bytes, 512 to 262,144.</summary>
        public uint BatchBytes { get => native.BatchBytes; set => native.BatchBytes = value; }
        /// <summary>
        /// Maximum number of unacknowledged messages, 1 to 4,096. At this limit sending pauses, and the session's queue drops its oldest samples.
        /// </summary>
        public uint UnacknowledgedMessages { get => native.UnacknowledgedMessages; set => native.UnacknowledgedMessages = value; }
        /// <summary>
        /// Upper limit of the first delay before reconnecting, in milliseconds, 1 to 3,600,000. Each delay is random, up to a limit that
        /// doubles after each broken stream, at most to <see cref="BackoffMaxMs"/>.
        /// </summary>
        public uint BackoffMinMs { get => native.BackoffMinMs; set => native.BackoffMinMs = value; }
        public uint BackoffMaxMs { get => native.BackoffMaxMs; set => native.BackoffMaxMs = value; }

        internal NativeLinkOptions With(CallMemory memory)
        {
            NativeLinkOptions options = native;
            options.Daemon = memory.Text(Daemon);
            options.Project = memory.Text(Project);
            options.Scene = memory.Text(Scene);
            options.Build = memory.Text(Build);
            options.MachineClass = memory.Text(MachineClass);
            options.Policy = memory.Text(Policy);
            return options;
        }

        private static ulong? Chosen(ulong intervalNs) => intervalNs == DaemonValue ? (ulong?)null : intervalNs;
    }
}
