#nullable enable
using System;

namespace Sweepstake
{
    /// <summary>Whether the game or the decider selects the backend.</summary>
    public enum SessionMode : uint
    {
        Manual = 1,
        /// <summary>AI Decides: the embedded decider or the daemon selects the backend.</summary>
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
        /// <summary>The game was paused or in the background; the frame is excluded from learning.</summary>
        Paused = 2,
        /// <summary>A scene was loading; the frame is excluded from learning.</summary>
        Loading = 4,
        /// <summary>The frame was longer than the bail-out limit.</summary>
        BailOut = 8,
        /// <summary>The system stopped the process during the frame, for example at a breakpoint; the frame is excluded from learning.</summary>
        Suspended = 16,
        /// <summary>A search ended early because of <see cref="SessionOptions.MaxPairs"/>; the frame is excluded from learning.</summary>
        PairsExceeded = 32,
    }

    /// <summary>
    /// The cost of one frame. If the frame has several searches, times and checks are sums over the searches. Bytes, pairs and objects are
    /// from the last search.
    /// </summary>
    public struct FrameSample
    {
        public ulong FrameIndex;
        /// <summary>The time that the game passed to <see cref="BroadPhaseSession.EndFrame"/>, in nanoseconds.</summary>
        public ulong FrameTimeNs;
        /// <summary>Time to update the boxes and search, in nanoseconds; 0 without a search.</summary>
        public ulong DetectionTimeNs;
        public ulong AabbCheckCount;
        /// <summary>Memory of the backend's own buffers.</summary>
        public ulong NativeBytes;
        public uint PairCount;
        public uint ObjectCount;
        /// <summary>Index in <see cref="BroadPhaseSession.Arms"/>.</summary>
        public uint Arm;
        /// <summary>Number of switches executed before this frame.</summary>
        public uint SwitchEpoch;
        public FrameFlags Flags;
        /// <summary>
        /// Number of objects that overlap nothing because their boxes are NaN, infinite or inverted. Boxes that were added count at once;
        /// a box that changes later counts within <see cref="ObjectCount"/> / 4 frames.
        /// </summary>
        public uint InvalidBoxCount;
    }

    public struct SwitchCommand
    {
        /// <summary>Id of the command with which a decider requested the switch; 0 if the game selected the arm itself.</summary>
        public ulong CommandId;
        public uint Arm;
        public SwitchReason Reason;
    }

    /// <summary>The result of a switch.</summary>
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

        /// <summary>Whether the switch was executed; false: it was refused.</summary>
        public readonly bool IsExecuted => Executed != 0;
    }

    /// <summary>The cost of the latest build or update and search of a <see cref="BroadPhaseWorld"/>.</summary>
    public struct WorldCounters
    {
        internal uint StructSize;
        public uint ObjectCount;
        public ulong AabbCheckCount;
        /// <summary>Memory of the backend's own buffers.</summary>
        public ulong NativeBytes;
        /// <summary>Time of the latest build or update plus the search, in nanoseconds.</summary>
        public ulong DetectionTimeNs;
        public ulong PairCount;
        /// <summary>Version of the backend's code; incremented by changes that may alter its cost.</summary>
        public uint BackendVersion;
        /// <summary>As <see cref="FrameSample.InvalidBoxCount"/>; here an update is a frame.</summary>
        public uint InvalidBoxCount;
    }
}
