// Written by unity_client/tools/make_bindings.py from the headers of the C ABI.
#nullable enable
using System;
using System.Runtime.InteropServices;

namespace Sweepstake.LowLevel
{
    /// <summary>The native form of <see cref="SessionOptions"/>, which documents the fields. Texts are UTF-8 with a terminating 0.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public unsafe struct NativeSessionOptions
    {
        public uint StructSize;
        public SessionMode Mode;
        public byte* Arms;
        public byte* InitialArm;
        public ulong BailOutNs;
        public ulong SettlingNs;
        public IntPtr Executor;
        public uint ThreadCount;
        public uint QueueFrames;
        public ShadowMode Shadow;
        public uint SortedPairs;
        public double ShadowDutyRatio;
        public ulong ShadowMemoryBytes;
        public ulong MemoryBudgetBytes;
        public ulong MaxPairs;
    }

    /// <summary>The native form of <see cref="DeciderOptions"/>, which documents the fields. Texts are UTF-8 with a terminating 0.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public unsafe struct NativeDeciderOptions
    {
        public uint StructSize;
        internal uint Reserved;
        public byte* Policy;
        public byte* Project;
        public byte* Scene;
        public byte* MachineClass;
        public byte* Build;
        public byte* SourceId;
        public byte* PriorsFile;
        public byte* PriorsData;
        public ulong PriorsDataBytes;
        public ulong Seed;
        public double TimeScale;
        public ulong DecisionIntervalNs;
        public ulong CooldownNs;
        public double FpsFloor;
        public RewardWeights Weights;
    }

    /// <summary>The native form of <see cref="LinkOptions"/>, which documents the fields. Texts are UTF-8 with a terminating 0.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public unsafe struct NativeLinkOptions
    {
        public uint StructSize;
        public uint AllowOperatorOrders;
        public byte* Daemon;
        public byte* Project;
        public byte* Scene;
        public byte* Build;
        public byte* MachineClass;
        public byte* Policy;
        public ulong Seed;
        public double TimeScale;
        public ulong JitterSeed;
        public uint IgnorePriors;
        public uint BatchIntervalMs;
        public uint BatchFrames;
        public uint BatchBytes;
        public uint UnacknowledgedMessages;
        public uint BackoffMinMs;
        public uint BackoffMaxMs;
        internal uint Reserved;
        public ulong DecisionIntervalNs;
        public ulong CooldownNs;
        public ulong SettlingNs;
        public RewardWeights Weights;
    }
}
