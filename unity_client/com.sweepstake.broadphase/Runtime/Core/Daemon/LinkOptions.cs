#nullable enable
using Sweepstake.LowLevel;

namespace Sweepstake
{
    /// <summary>
    /// What a <see cref="DaemonConnection"/> tells its daemon and how it sends; a new one holds the library's defaults. The texts are names
    /// of at most 128 bytes of UTF-8, and all of them leave the machine, if the daemon is another one.
    /// </summary>
    public sealed unsafe class LinkOptions
    {
        private NativeLinkOptions native;

        /// <exception cref="NativeLibraryException">The library does not fit.</exception>
        public LinkOptions()
        {
            SweepstakeLibrary.EnsureLoaded();
            native.StructSize = (uint)sizeof(NativeLinkOptions);
            fixed (NativeLinkOptions* options = &native)
                Native.Check(NativeMethods.swp_link_options_init(options));
        }

        /// <summary>What messages call the daemon, as its address; null: nothing.</summary>
        public string? Daemon { get; set; }
        /// <summary>Null: "default".</summary>
        public string? Project { get; set; }
        /// <summary>Null: "default".</summary>
        public string? Scene { get; set; }
        /// <summary>Null: unknown.</summary>
        public string? Build { get; set; }
        /// <summary>Class of machine whose timings are comparable. Null: processor, threads, instruction set and memory.</summary>
        public string? MachineClass { get; set; }
        /// <summary>Null: the daemon's default.</summary>
        public string? Policy { get; set; }
        /// <summary>Of the daemon's draws; 0: the daemon chooses.</summary>
        public ulong Seed { get => native.Seed; set => native.Seed = value; }
        /// <summary>1 to 1000; above 1 a daemon refuses unless it is set to allow it.</summary>
        public double TimeScale { get => native.TimeScale; set => native.TimeScale = value; }
        /// <summary>Of the delays between attempts; 0: another one for each connection.</summary>
        public ulong JitterSeed { get => native.JitterSeed; set => native.JitterSeed = value; }
        /// <summary>Operators of the daemon may choose mode and arm. Not in a game that players get.</summary>
        public bool AllowsOperatorOrders { get => native.AllowOperatorOrders != 0; set => native.AllowOperatorOrders = value ? 1u : 0u; }
        /// <summary>Starts from Beta(1,1) whatever the store holds.</summary>
        public bool IgnoresPriors { get => native.IgnorePriors != 0; set => native.IgnorePriors = value ? 1u : 0u; }
        /// <summary>A batch is sent at the first of these three limits: 1 to 10,000.</summary>
        public uint BatchIntervalMs { get => native.BatchIntervalMs; set => native.BatchIntervalMs = value; }
        /// <summary>1 to 240.</summary>
        public uint BatchFrames { get => native.BatchFrames; set => native.BatchFrames = value; }
        /// <summary>512 to 262,144.</summary>
        public uint BatchBytes { get => native.BatchBytes; set => native.BatchBytes = value; }
        /// <summary>1 to 4,096; at the bound nothing more is sent, and the session's queue drops its oldest samples.</summary>
        public uint UnacknowledgedMessages { get => native.UnacknowledgedMessages; set => native.UnacknowledgedMessages = value; }
        /// <summary>Doubles with each stream that broke up to the maximum, with full jitter; 1 to 3,600,000.</summary>
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
    }
}
