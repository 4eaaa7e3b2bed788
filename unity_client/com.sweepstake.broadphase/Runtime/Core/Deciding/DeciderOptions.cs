#nullable enable
using Sweepstake.LowLevel;

namespace Sweepstake
{
    /// <summary>How an <see cref="EmbeddedDecider"/> decides; a new object holds the library's defaults.</summary>
    public sealed unsafe class DeciderOptions
    {
        private NativeDeciderOptions native = SweepstakeLibrary.Defaults(
            new NativeDeciderOptions { StructSize = (uint)sizeof(NativeDeciderOptions) }, options => NativeMethods.swp_decider_options_init(options));

        /// <summary>Name of the policy; null for the default.</summary>
        public string? Policy { get; set; }
        /// <summary>Name of the project; null for "default".</summary>
        public string? Project { get; set; }
        /// <summary>Name of the scene; null for "default".</summary>
        public string? Scene { get; set; }
        /// <summary>Class of machines whose timings are comparable. Null: derived from processor, threads, instruction set and memory.</summary>
        public string? MachineClass { get; set; }
        /// <summary>Build of the game; priors of other builds have less weight. Null if unknown.</summary>
        public string? Build { get; set; }
        /// <summary>
        /// The source name under which <see cref="EmbeddedDecider.ExportPriors"/> exports what was learnt. With one name per installation, records
        /// grow from run to run. A game that loses its save data needs a new name too. Null: a new name each time.
        /// </summary>
        public string? SourceId { get; set; }
        /// <summary>Path of the priors to start from; merged with <see cref="PriorsData"/> if both are set. With neither: Beta(1,1).</summary>
        public string? PriorsFile { get; set; }
        /// <summary>Priors in the format that <see cref="EmbeddedDecider.ExportPriors"/> and `sweepstake priors export` write.</summary>
        public byte[]? PriorsData { get; set; }
        /// <summary>
        /// The file that the decider continues, and that it writes when it ends. It replaces <see cref="SourceId"/> and
        /// <see cref="PriorsFile"/>. Null: nothing is saved.
        /// </summary>
        public SavedPriors? Saved { get; set; }
        /// <summary>Seed of the exploration and of the random draws, which only `paper` makes: the same seed and the same measurements give the same decisions.</summary>
        public ulong Seed { get => native.Seed; set => native.Seed = value; }
        /// <summary>Factor from 1 to 1000 by which all intervals except the bail-out limit are divided.</summary>
        public double TimeScale { get => native.TimeScale; set => native.TimeScale = value; }
        /// <summary>Interval between decisions in nanoseconds.</summary>
        public ulong DecisionIntervalNs { get => native.DecisionIntervalNs; set => native.DecisionIntervalNs = value; }
        /// <summary>Minimum interval between switches that the policy chooses, in nanoseconds.</summary>
        public ulong CooldownNs { get => native.CooldownNs; set => native.CooldownNs = value; }
        /// <summary>
        /// Frames per second, 0 to 1000. If the broad phase keeps the game below this rate even with the best arm, the verdict is
        /// <see cref="VerdictKind.Degraded"/>.
        /// </summary>
        public double FpsFloor { get => native.FpsFloor; set => native.FpsFloor = value; }
        /// <summary>Weights of the paper's reward.</summary>
        public RewardWeights Weights { get => native.Weights; set => native.Weights = value; }

        internal NativeDeciderOptions With(CallMemory memory)
        {
            NativeDeciderOptions options = native;
            options.Policy = memory.Text(Policy);
            options.Project = memory.Text(Project);
            options.Scene = memory.Text(Scene);
            options.MachineClass = memory.Text(MachineClass);
            options.Build = memory.Text(Build);
            // The unwritten priors also contain those that their decider began with.
            byte[]? data = Saved?.Unwritten ?? PriorsData;
            bool hasFile = Saved != null && Saved.Unwritten == null && System.IO.File.Exists(Saved.Path);
            options.SourceId = memory.Text(Saved == null ? SourceId : Saved.SourceId);
            options.PriorsFile = memory.Text(Saved == null ? PriorsFile : hasFile ? Saved.Path : null);
            options.PriorsData = memory.Pin(data);
            options.PriorsDataBytes = options.PriorsData == null ? 0 : (ulong)data!.Length;
            return options;
        }
    }
}
