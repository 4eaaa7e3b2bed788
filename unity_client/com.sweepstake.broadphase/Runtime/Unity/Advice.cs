#nullable enable

namespace Sweepstake.Unity
{
    /// <summary>What a game or its developer can do about a verdict, and the reason of a decision in words.</summary>
    public static class Advice
    {
        public static string Of(VerdictKind verdict) => verdict switch
        {
            VerdictKind.Unknown => "Nothing has been learnt yet. Continue to play, or load priors.",
            VerdictKind.Stable => "One backend is the best here. There is nothing to do.",
            VerdictKind.Tie => "Some backends are equally good. There is nothing to do.",
            VerdictKind.Ambiguous => "The best backend is not known yet. Expect switches.",
            VerdictKind.Degraded => "Even the best backend takes too long for the frame-rate floor. Spawn fewer or smaller objects, or track fewer layers.",
            _ => "This version of the package does not know the verdict. Update the package.",
        };

        /// <summary>The reason of a decision as part of a sentence.</summary>
        public static string Of(DecisionOutcome outcome) => outcome switch
        {
            DecisionOutcome.None => "no decision yet",
            DecisionOutcome.Kept => "the active backend is the best",
            DecisionOutcome.Switched => "another backend is better",
            DecisionOutcome.HeldCooldown => "held: the cooldown after the latest switch",
            DecisionOutcome.HeldSettling => "held: the latest switch is settling",
            DecisionOutcome.NoFrames => "there were no frames to learn from",
            DecisionOutcome.Manual => "manual: the game chooses",
            DecisionOutcome.Exploring => "trying each backend",
            DecisionOutcome.Rejected => "a measurement was not finite",
            DecisionOutcome.HeldGate => "held: not worth the cost of a switch",
            _ => "a reason that this version of the package does not know",
        };
    }
}
