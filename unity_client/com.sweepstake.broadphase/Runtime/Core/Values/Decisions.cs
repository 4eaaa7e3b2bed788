#nullable enable
using System;
using System.Runtime.InteropServices;

namespace Sweepstake
{
    /// <summary>What the beliefs say about the scene. A later library may have more kinds: treat those as unknown.</summary>
    public enum VerdictKind : uint
    {
        /// <summary>Nothing learnt yet.</summary>
        Unknown = 0,
        /// <summary>The leader is the best arm with a probability of 0.8 or more.</summary>
        Stable = 1,
        /// <summary>Below 0.8, but choosing the leader loses 0.5 % or less.</summary>
        Tie = 2,
        /// <summary>Below 0.8, and it may lose more: expect switches.</summary>
        Ambiguous = 3,
        /// <summary>Even the leader misses the frame-rate floor: no broad phase will help, spawn fewer or smaller objects.</summary>
        Degraded = 4,
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Verdict
    {
        public VerdictKind Kind;
        /// <summary>The arm most probable to be the best; 0 while nothing is known.</summary>
        public uint LeaderArm;
        /// <summary>The probability that it is the best, 0 to 1.</summary>
        public double LeaderProbability;
    }

    /// <summary>What came of a decision's candidate. A later library may have more.</summary>
    public enum DecisionOutcome : uint
    {
        /// <summary>There was no decision yet.</summary>
        None = 0,
        /// <summary>The candidate is active.</summary>
        Kept = 1,
        /// <summary>A switch was commanded.</summary>
        Switched = 2,
        /// <summary>The cooldown after the latest switch has not passed.</summary>
        HeldCooldown = 3,
        /// <summary>All frames were settling, or a switch is under way.</summary>
        HeldSettling = 4,
        /// <summary>There was nothing to learn from since the decision before.</summary>
        NoFrames = 5,
        /// <summary>The session is in <see cref="SessionMode.Manual"/>.</summary>
        Manual = 6,
        /// <summary>No candidate; the command goes to the next arm to try.</summary>
        Exploring = 7,
        /// <summary>A metric is not finite.</summary>
        Rejected = 8,
        /// <summary>The expected gain is not worth the cost of the switch.</summary>
        HeldGate = 9,
        /// <summary>The candidate is not better by as much as matters.</summary>
        HeldTie = 12,
    }

    /// <summary>A decision and its reasons, for logs and debug views.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public unsafe struct Decision
    {
        /// <summary>In the place of an arm: none.</summary>
        public const uint NoArm = uint.MaxValue;
        private const int MaxArms = 32;

        internal uint StructSize;
        public DecisionOutcome Outcome;
        /// <summary>From 1; 0: a daemon's, which tells its commands alone.</summary>
        public ulong DecisionId;
        /// <summary>In nanoseconds on the clock of <see cref="SteadyClock"/>, so that its age is the time since then.</summary>
        public ulong TimeNs;
        public uint ActiveArm;
        /// <summary>What the policy proposed, or <see cref="NoArm"/>.</summary>
        public uint CandidateArm;
        /// <summary>Of the switch that was commanded; 0: none was.</summary>
        public ulong CommandId;
        /// <summary>The arm of the switch, or <see cref="NoArm"/>.</summary>
        public uint CommandArm;
        public SwitchReason CommandReason;
        public Verdict Verdict;
        /// <summary>Of choosing the leader, relative to the best arm's cost.</summary>
        public double ExpectedLossRatio;
        internal fixed double BestProbability[MaxArms];

        /// <summary>The probability that an arm is the best, 0 to 1; 0 for each: nothing is known.</summary>
        /// <exception cref="ArgumentOutOfRangeException">There is no such arm.</exception>
        public readonly double ProbabilityOf(int arm)
        {
            if (arm < 0 || arm >= MaxArms)
                throw new ArgumentOutOfRangeException(nameof(arm));
            return BestProbability[arm];
        }
    }

    /// <summary>A posterior of an arm's reward, Beta(Alpha, Beta).</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct Belief
    {
        public double Alpha;
        public double Beta;

        /// <summary>The expected reward, 0 to 1.</summary>
        public readonly double Mean => Alpha / (Alpha + Beta);
    }

    /// <summary>The shadow lane: a thread that measures the arms that are not active, and prepares the next one before a switch.</summary>
    public enum ShadowMode : uint
    {
        Off = 0,
        /// <summary>From the first <see cref="SessionMode.Ai"/> on, while there is a spare core.</summary>
        Auto = 1,
        /// <summary>In a game that has always been manual too.</summary>
        On = 2,
    }

    public enum ShadowState : uint
    {
        /// <summary>As asked for.</summary>
        Off = 0,
        /// <summary>Off: there is nothing to compare.</summary>
        OneArm = 1,
        /// <summary>At rest: the game's threads leave no core.</summary>
        NoSpareCore = 2,
        /// <summary><see cref="ShadowMode.Auto"/>, and never in <see cref="SessionMode.Ai"/>.</summary>
        Paused = 3,
        Running = 4,
        /// <summary>The scene does not fit in the lane's memory.</summary>
        TooBig = 5,
    }

    /// <summary>What the shadow lane has done since the session began.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct ShadowStats
    {
        internal uint StructSize;
        public ShadowState State;
        /// <summary>Sweeps over the arms that were due.</summary>
        public ulong SweepCount;
        /// <summary>Visits of one arm each.</summary>
        public ulong VisitCount;
        /// <summary>Of these, those that a cap ended early.</summary>
        public ulong CappedVisitCount;
        /// <summary>Of the lane's thread, in nanoseconds.</summary>
        public ulong BusyTimeNs;
        /// <summary>Held now.</summary>
        public ulong MemoryBytes;
        public ulong CopiedFrameCount;
        /// <summary>On the frame thread, in nanoseconds.</summary>
        public ulong CopyTimeNs;
        /// <summary>Switches that the lane prepared.</summary>
        public ulong WarmSwitchCount;
        public ulong ColdSwitchCount;
    }
}
