#nullable enable
using System;
using System.Runtime.InteropServices;

namespace Sweepstake
{
    /// <summary>Who chooses the backend.</summary>
    public enum SessionMode : uint
    {
        Manual = 1,
        /// <summary>AI Decides: the embedded decider or the daemon.</summary>
        Ai = 2,
    }

    public enum SwitchReason : uint
    {
        None = 0,
        Policy = 1,
        Exploration = 2,
        BailOut = 3,
        Manual = 4,
    }

    [Flags]
    public enum FrameFlags : uint
    {
        None = 0,
        /// <summary>The backend's structure was rebuilt.</summary>
        Rebuild = 1,
        /// <summary>The game was paused or in the background; nothing is learnt from the frame.</summary>
        Paused = 2,
        /// <summary>A scene was loading; nothing is learnt from the frame.</summary>
        Loading = 4,
        /// <summary>Over the bail-out limit.</summary>
        BailOut = 8,
    }

    /// <summary>
    /// The cost of one frame. Of several searches, times and checks are summed; the counts of bytes, pairs and objects are the latest one's.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct FrameSample
    {
        public ulong FrameIndex;
        /// <summary>What the game passed to <see cref="BroadPhaseSession.EndFrame"/>, in nanoseconds.</summary>
        public ulong FrameTimeNs;
        /// <summary>To take the boxes and search, in nanoseconds; 0 without a search.</summary>
        public ulong DetectionTimeNs;
        public ulong AabbCheckCount;
        /// <summary>Held by the backend's own buffers.</summary>
        public ulong NativeBytes;
        public uint PairCount;
        public uint ObjectCount;
        /// <summary>Index in <see cref="BroadPhaseSession.Arms"/>.</summary>
        public uint Arm;
        /// <summary>Executed switches before this frame.</summary>
        public uint SwitchEpoch;
        public FrameFlags Flags;
        internal uint Reserved;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct SwitchCommand
    {
        /// <summary>0: a switch of the game's own.</summary>
        public ulong CommandId;
        public uint Arm;
        public SwitchReason Reason;
    }

    /// <summary>How a switch went.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct SwitchOutcome
    {
        public ulong CommandId;
        public uint Arm;
        public uint SwitchEpoch;
        /// <summary>Time to build the new backend's structure, in nanoseconds.</summary>
        public ulong RebuildTimeNs;
        /// <summary>Frame time above the settled mean, summed over the settling frames, in nanoseconds.</summary>
        public ulong SettlingCostNs;
        public SwitchReason Reason;
        internal uint Executed;

        /// <summary>False: the switch was refused.</summary>
        public readonly bool IsExecuted => Executed != 0;
    }

    /// <summary>What the latest build or update and search of a <see cref="BroadPhaseWorld"/> took.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct WorldCounters
    {
        internal uint StructSize;
        public uint ObjectCount;
        public ulong AabbCheckCount;
        /// <summary>Held by the backend's own buffers.</summary>
        public ulong NativeBytes;
        /// <summary>In nanoseconds.</summary>
        public ulong DetectionTimeNs;
        public ulong PairCount;
        /// <summary>Raised by each change of the backend that could alter its cost.</summary>
        public uint BackendVersion;
        internal uint Reserved;
    }
}
