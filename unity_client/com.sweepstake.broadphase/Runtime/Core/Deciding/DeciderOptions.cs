#nullable enable
using Sweepstake.LowLevel;

namespace Sweepstake
{
    /// <summary>How an <see cref="EmbeddedDecider"/> decides; a new one holds the library's defaults.</summary>
    public sealed unsafe class DeciderOptions
    {
        private NativeDeciderOptions native;

        /// <exception cref="NativeLibraryException">The library does not fit.</exception>
        public DeciderOptions()
        {
            SweepstakeLibrary.EnsureLoaded();
            native.StructSize = (uint)sizeof(NativeDeciderOptions);
            fixed (NativeDeciderOptions* options = &native)
                Native.Check(NativeMethods.swp_decider_options_init(options));
        }

        /// <summary>Null: the default.</summary>
        public string? Policy { get; set; }
        /// <summary>Null: "default".</summary>
        public string? Project { get; set; }
        /// <summary>Null: "default".</summary>
        public string? Scene { get; set; }
        /// <summary>Null: processor, threads, instruction set and memory.</summary>
        public string? MachineClass { get; set; }
        /// <summary>Of the game; priors of other builds count less. Null: unknown.</summary>
        public string? Build { get; set; }
        /// <summary>
        /// Under what name <see cref="EmbeddedDecider.ExportPriors"/> gives what is learnt. A game that keeps a name per installation has
        /// records that grow from run to run; one that loses its save needs a new name too. Null: a new one each time.
        /// </summary>
        public string? SourceId { get; set; }
        /// <summary>The path of priors to start from. With <see cref="PriorsData"/> both are united; without: Beta(1,1).</summary>
        public string? PriorsFile { get; set; }
        /// <summary>Priors as <see cref="EmbeddedDecider.ExportPriors"/> and `sweepstake priors export` write them.</summary>
        public byte[]? PriorsData { get; set; }
        /// <summary>Of all draws: the same seed and the same measurements give the same decisions.</summary>
        public ulong Seed { get => native.Seed; set => native.Seed = value; }
        /// <summary>1 to 1000: every interval but the bail-out limit is divided by it.</summary>
        public double TimeScale { get => native.TimeScale; set => native.TimeScale = value; }
        /// <summary>From one decision to the next, in nanoseconds.</summary>
        public ulong DecisionIntervalNs { get => native.DecisionIntervalNs; set => native.DecisionIntervalNs = value; }
        /// <summary>Between switches that the policy chooses, in nanoseconds.</summary>
        public ulong CooldownNs { get => native.CooldownNs; set => native.CooldownNs = value; }
        /// <summary><see cref="VerdictKind.Degraded"/> if the best arm has fewer frames/s, 0 to 1000.</summary>
        public double FpsFloor { get => native.FpsFloor; set => native.FpsFloor = value; }

        internal NativeDeciderOptions With(CallMemory memory)
        {
            NativeDeciderOptions options = native;
            options.Policy = memory.Text(Policy);
            options.Project = memory.Text(Project);
            options.Scene = memory.Text(Scene);
            options.MachineClass = memory.Text(MachineClass);
            options.Build = memory.Text(Build);
            options.SourceId = memory.Text(SourceId);
            options.PriorsFile = memory.Text(PriorsFile);
            options.PriorsData = memory.Pin(PriorsData);
            options.PriorsDataBytes = options.PriorsData == null ? 0 : (ulong)PriorsData!.Length;
            return options;
        }
    }
}
