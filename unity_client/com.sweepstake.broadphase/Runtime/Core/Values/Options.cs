#nullable enable
using System;
using Sweepstake.LowLevel;

namespace Sweepstake
{
    /// <summary>Options of a <see cref="BroadPhaseWorld"/>. Start from <see cref="Default"/>.</summary>
    public unsafe struct WorldOptions
    {
        internal uint StructSize;
        /// <summary>
        /// Threads that search: 0 or 1 for the calling thread only, up to 256 for a pool of threads. The pairs do not depend on this number.
        /// </summary>
        public uint ThreadCount;
        internal IntPtr Executor;
        internal uint SortedPairs;
        internal uint Reserved;
        /// <summary>
        /// The maximum number of pairs of a search; 0: no limit. A search with more ends early with
        /// <see cref="ResultCode.ResourceExhausted"/>, so that boxes that collapse to one place do not take all memory. The world must then
        /// be built again.
        /// </summary>
        public ulong MaxPairs;

        /// <summary>Sorts pairs by A and then B with every backend.</summary>
        public bool IsSorted
        {
            readonly get => SortedPairs != 0;
            set => SortedPairs = value ? 1u : 0u;
        }

        public static WorldOptions Default => SweepstakeLibrary.Defaults(
            new WorldOptions { StructSize = (uint)sizeof(WorldOptions) }, options => NativeMethods.swp_world_options_init(options));
    }

    /// <summary>Options of a <see cref="ProxySet"/>. Start from <see cref="Default"/>.</summary>
    public unsafe struct ProxySetOptions
    {
        internal uint StructSize;
        internal uint PairEvents;
        internal uint SortedPairs;
        /// <summary>Number of threads that search, as in <see cref="WorldOptions.ThreadCount"/>.</summary>
        public uint ThreadCount;
        internal IntPtr Executor;
        /// <summary>
        /// Distance in world units. The end event of a pair waits until the boxes are farther apart than this distance on one axis. The
        /// list of pairs stays exact.
        /// </summary>
        public float EventMargin;
        internal uint Reserved;
        /// <summary>
        /// The maximum number of pairs, before the filters; 0: no limit. With more pairs, FindPairs ends early and throws a
        /// <see cref="SweepstakeException"/>, and there are no pairs and no events. The next search reports all events since then.
        /// </summary>
        public ulong MaxPairs;

        /// <summary>Whether <see cref="ProxySet.Added"/> and <see cref="ProxySet.Removed"/> are filled.</summary>
        public bool HasPairEvents
        {
            readonly get => PairEvents != 0;
            set => PairEvents = value ? 1u : 0u;
        }

        /// <summary>Sorts pairs by A and then B with every backend. Pairs are always sorted if <see cref="HasPairEvents"/> is set.</summary>
        public bool IsSorted
        {
            readonly get => SortedPairs != 0;
            set => SortedPairs = value ? 1u : 0u;
        }

        public static ProxySetOptions Default => SweepstakeLibrary.Defaults(
            new ProxySetOptions { StructSize = (uint)sizeof(ProxySetOptions) }, options => NativeMethods.swp_proxies_options_init(options));
    }

    /// <summary>
    /// Options of a <see cref="MotionScene"/>. Start from <see cref="Default"/>. Lengths are in world units, times in seconds. The
    /// documentation of the scenes lists which scene uses which option.
    /// </summary>
    public unsafe struct SceneOptions
    {
        internal uint StructSize;
        /// <summary>Number of objects, 0 to 16,777,216.</summary>
        public uint ObjectCount;
        /// <summary>Seed of sizes and spawn positions.</summary>
        public ulong SpawnSeed;
        /// <summary>Seed of start velocities, directions, kicks and random parts of wall hits.</summary>
        public ulong MotionSeed;
        /// <summary>The world extends from minus this value to this value on each axis.</summary>
        public float WorldHalfExtent;
        /// <summary>Duration of one step.</summary>
        public float FixedStepS;
        /// <summary>Lower limit of the random half extent of a box on each axis; HalfExtentMax is the upper limit.</summary>
        public float HalfExtentMin;
        public float HalfExtentMax;
        /// <summary>Characteristic speed in units/s.</summary>
        public float Speed;
        /// <summary>Gravitational acceleration in units/s².</summary>
        public float Gravity;
        /// <summary>Time per direction of gravity in the scene rotating-gravity.</summary>
        public float DirectionIntervalS;
        internal uint Reserved;

        public static SceneOptions Default => SweepstakeLibrary.Defaults(
            new SceneOptions { StructSize = (uint)sizeof(SceneOptions) }, options => NativeMethods.swp_scene_options_init(options));
    }

    /// <summary>
    /// Weights of the four scores in the paper's reward, each at least 0, with the sum 1. Only the policy `paper` uses them. Evidence of
    /// other weights than the default is never merged with that of the default.
    /// </summary>
    public struct RewardWeights
    {
        /// <summary>Weight of the frame rate.</summary>
        public double Fps;
        /// <summary>Weight of the detection time.</summary>
        public double Detection;
        /// <summary>Weight of the memory.</summary>
        public double Memory;
        /// <summary>Weight of the AABB checks.</summary>
        public double Checks;

        public RewardWeights(double fps, double detection, double memory, double checks) =>
            (Fps, Detection, Memory, Checks) = (fps, detection, memory, checks);

        internal readonly bool IsUnset => Fps == 0 && Detection == 0 && Memory == 0 && Checks == 0;
    }
}
