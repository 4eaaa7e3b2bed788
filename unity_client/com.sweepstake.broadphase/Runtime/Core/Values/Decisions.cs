#nullable enable
using System;

namespace Sweepstake
{
    /// <summary>The decider's conclusion about the scene. Newer libraries may add kinds: treat those as unknown.</summary>
    public enum VerdictKind : uint
    {
        /// <summary>Nothing has been learnt yet.</summary>
        Unknown = 0,
        /// <summary>The leader is the best arm with a probability of 0.8 or more.</summary>
        Stable = 1,
        /// <summary>The leader is the best arm with a probability below 0.8, but choosing it loses 0.5 % or less.</summary>
        Tie = 2,
        /// <summary>The leader is the best arm with a probability below 0.8 and may lose more than 0.5 %: expect switches.</summary>
        Ambiguous = 3,
        /// <summary>
        /// Even with the leader, the broad phase keeps the game below the frame-rate floor. No other one will help: spawn fewer or smaller objects.
        /// </summary>
        Degraded = 4,
    }

    public struct Verdict
    {
        public VerdictKind Kind;
        /// <summary>The arm with the highest probability of being the best; 0 while nothing is known.</summary>
        public uint LeaderArm;
        /// <summary>The probability that the leader is the best arm, 0 to 1.</summary>
        public double LeaderProbability;
    }

    /// <summary>The result of a decision. Newer libraries may add values.</summary>
    public enum DecisionOutcome : uint
    {
        /// <summary>There has been no decision yet.</summary>
        None = 0,
        /// <summary>The candidate is already active.</summary>
        Kept = 1,
        /// <summary>A switch was commanded.</summary>
        Switched = 2,
        /// <summary>No switch: the cooldown after the latest switch has not passed.</summary>
        HeldCooldown = 3,
        /// <summary>No switch: all frames were settling frames, or a switch is in progress.</summary>
        HeldSettling = 4,
        /// <summary>There were no new frames to learn from.</summary>
        NoFrames = 5,
        /// <summary>The session is in <see cref="SessionMode.Manual"/>.</summary>
        Manual = 6,
        /// <summary>The policy still tries each arm: it proposes no candidate, and the command switches to the next arm to try.</summary>
        Exploring = 7,
        /// <summary>A measurement was rejected because it is not finite.</summary>
        Rejected = 8,
        /// <summary>No switch: the expected gain is lower than the cost of the switch.</summary>
        HeldGate = 9,
    }

    /// <summary>A decision and its reasons, for logs and debug views.</summary>
    public unsafe struct Decision
    {
        /// <summary>Value of an arm field for "no arm".</summary>
        public const uint NoArm = uint.MaxValue;
        private const int MaxArms = 32;

        internal uint StructSize;
        public DecisionOutcome Outcome;
        /// <summary>Number of the decision, from 1; 0 for a decision of a daemon, which sends only its commands.</summary>
        public ulong DecisionId;
        /// <summary>Time of the decision in nanoseconds of <see cref="SteadyClock"/>; the difference to now is its age.</summary>
        public ulong TimeNs;
        public uint ActiveArm;
        /// <summary>The arm that the policy proposed, or <see cref="NoArm"/>.</summary>
        public uint CandidateArm;
        /// <summary>Id of the commanded switch; 0 if there was none.</summary>
        public ulong CommandId;
        /// <summary>The arm of the commanded switch, or <see cref="NoArm"/>.</summary>
        public uint CommandArm;
        public SwitchReason CommandReason;
        public Verdict Verdict;
        /// <summary>The expected extra cost of choosing the leader, relative to the cost of the best arm.</summary>
        public double ExpectedLossRatio;
        internal fixed double BestProbability[MaxArms];

        /// <summary>The probability that an arm is the best, 0 to 1; 0 for every arm if nothing is known.</summary>
        /// <exception cref="ArgumentOutOfRangeException">The session does not have such an arm.</exception>
        public readonly double ProbabilityOf(int arm)
        {
            if (arm < 0 || arm >= MaxArms)
                throw new ArgumentOutOfRangeException(nameof(arm));
            return BestProbability[arm];
        }
    }

    /// <summary>The posterior Beta(Alpha, Beta) of an arm's reward.</summary>
    public struct Belief
    {
        public double Alpha;
        public double Beta;

        /// <summary>The expected reward, 0 to 1.</summary>
        public readonly double Mean => Alpha / (Alpha + Beta);
    }

    /// <summary>Mode of the shadow lane, a thread that measures the inactive arms and prepares the next arm before a switch.</summary>
    public enum ShadowMode : uint
    {
        Off = 0,
        /// <summary>
        /// The lane starts when the session first enters <see cref="SessionMode.Ai"/>, and runs while there is a spare core. It rests with a
        /// policy that does not learn from it, such as `paper`, whose switches are then cold.
        /// </summary>
        Auto = 1,
        /// <summary>The lane runs even if the session has never been in <see cref="SessionMode.Ai"/>, and with each policy.</summary>
        On = 2,
    }

    public enum ShadowState : uint
    {
        /// <summary>Switched off by the options.</summary>
        Off = 0,
        /// <summary>Off: there is only one arm, so nothing can be compared.</summary>
        OneArm = 1,
        /// <summary>Inactive: the game's threads use all cores.</summary>
        NoSpareCore = 2,
        /// <summary>Inactive: <see cref="ShadowMode.Auto"/> rests.</summary>
        Paused = 3,
        Running = 4,
        /// <summary>Inactive: the scene does not fit in the lane's memory.</summary>
        TooBig = 5,
    }

    /// <summary>Counters of the shadow lane since the session began.</summary>
    public struct ShadowStats
    {
        internal uint StructSize;
        public ShadowState State;
        /// <summary>Sweeps: passes over all arms that were due for measurement.</summary>
        public ulong SweepCount;
        /// <summary>Visits: measurements of one arm each.</summary>
        public ulong VisitCount;
        /// <summary>Visits that a limit ended early.</summary>
        public ulong CappedVisitCount;
        /// <summary>Busy time of the lane's thread in nanoseconds.</summary>
        public ulong BusyTimeNs;
        /// <summary>Memory that the lane holds now.</summary>
        public ulong MemoryBytes;
        public ulong CopiedFrameCount;
        /// <summary>Time that copying boxes took on the frame thread, in nanoseconds.</summary>
        public ulong CopyTimeNs;
        /// <summary>Switches for which the lane had prepared the arm.</summary>
        public ulong WarmSwitchCount;
        public ulong ColdSwitchCount;
    }
}
