#nullable enable
using System;
using System.Runtime.InteropServices;
using Sweepstake.LowLevel;

namespace Sweepstake
{
    /// <summary>Start from <see cref="Default"/>.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public unsafe struct WorldOptions
    {
        internal uint StructSize;
        /// <summary>0 or 1: the calling thread alone searches; up to 256: with a pool of so many threads. The pairs do not depend on it.</summary>
        public uint ThreadCount;
        internal IntPtr Executor;
        internal uint SortedPairs;
        internal uint Reserved;

        /// <summary>Pairs ascend by A and then B, whatever the backend.</summary>
        public bool IsSorted
        {
            readonly get => SortedPairs != 0;
            set => SortedPairs = value ? 1u : 0u;
        }

        public static WorldOptions Default
        {
            get
            {
                SweepstakeLibrary.EnsureLoaded();
                var options = new WorldOptions { StructSize = (uint)sizeof(WorldOptions) };
                Native.Check(NativeMethods.swp_world_options_init(&options));
                return options;
            }
        }
    }

    /// <summary>Start from <see cref="Default"/>.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public unsafe struct ProxySetOptions
    {
        internal uint StructSize;
        internal uint PairEvents;
        internal uint SortedPairs;
        /// <summary>As in <see cref="WorldOptions"/>.</summary>
        public uint ThreadCount;
        internal IntPtr Executor;
        /// <summary>In world units: a pair's end is told when the boxes are farther apart on an axis. The pairs themselves stay exact.</summary>
        public float EventMargin;
        internal uint Reserved;

        /// <summary>Fills <see cref="ProxySet.Added"/> and <see cref="ProxySet.Removed"/>.</summary>
        public bool HasPairEvents
        {
            readonly get => PairEvents != 0;
            set => PairEvents = value ? 1u : 0u;
        }

        /// <summary>Ascending pairs, whatever the backend; implied by events.</summary>
        public bool IsSorted
        {
            readonly get => SortedPairs != 0;
            set => SortedPairs = value ? 1u : 0u;
        }

        public static ProxySetOptions Default
        {
            get
            {
                SweepstakeLibrary.EnsureLoaded();
                var options = new ProxySetOptions { StructSize = (uint)sizeof(ProxySetOptions) };
                Native.Check(NativeMethods.swp_proxies_options_init(&options));
                return options;
            }
        }
    }

    /// <summary>
    /// Start from <see cref="Default"/>. Lengths in world units, times in seconds. Which scene uses which: the documentation of scenes.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public unsafe struct SceneOptions
    {
        internal uint StructSize;
        /// <summary>0 to 16,777,216.</summary>
        public uint ObjectCount;
        /// <summary>Of sizes and spawn positions.</summary>
        public ulong SpawnSeed;
        /// <summary>Of start velocities, directions and kicks.</summary>
        public ulong MotionSeed;
        /// <summary>The world is ± this on each axis.</summary>
        public float WorldHalfExtent;
        /// <summary>Of one step.</summary>
        public float FixedStepS;
        /// <summary>Half of a box's size on each axis is drawn from here to the next one.</summary>
        public float HalfExtentMin;
        public float HalfExtentMax;
        /// <summary>Characteristic speed, units/s.</summary>
        public float Speed;
        /// <summary>Units/s².</summary>
        public float Gravity;
        /// <summary>Of rotating-gravity: time per direction.</summary>
        public float DirectionIntervalS;
        internal uint Reserved;

        public static SceneOptions Default
        {
            get
            {
                SweepstakeLibrary.EnsureLoaded();
                var options = new SceneOptions { StructSize = (uint)sizeof(SceneOptions) };
                Native.Check(NativeMethods.swp_scene_options_init(&options));
                return options;
            }
        }
    }
}
