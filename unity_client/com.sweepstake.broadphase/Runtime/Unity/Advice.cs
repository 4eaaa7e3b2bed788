#nullable enable

namespace Sweepstake.Unity
{
    /// <summary>What a game, or whoever makes it, can do about a verdict or an outcome.</summary>
    public static class Advice
    {
        public static string Of(VerdictKind verdict) => verdict switch
        {
            VerdictKind.Unknown => "Nothing is learnt yet. Play on, or give the game priors.",
            VerdictKind.Stable => "One backend is the best here. There is nothing to do.",
            VerdictKind.Tie => "Some backends are equally good. There is nothing to do.",
            VerdictKind.Ambiguous => "It is not known yet which backend is the best. Expect switches.",
            VerdictKind.Degraded => "Even the best backend misses the frame-rate floor. Spawn fewer or smaller objects, or track fewer layers.",
            _ => "This package does not know the verdict. Update it.",
        };

        /// <summary>The reason of a decision, as a part of a sentence.</summary>
        public static string Of(DecisionOutcome outcome) => outcome switch
        {
            DecisionOutcome.None => "no decision yet",
            DecisionOutcome.Kept => "the active backend is the best",
            DecisionOutcome.Switched => "another backend is better",
            DecisionOutcome.HeldCooldown => "held: the cooldown after the latest switch",
            DecisionOutcome.HeldSettling => "held: the latest switch settles",
            DecisionOutcome.NoFrames => "there were no frames to learn from",
            DecisionOutcome.Manual => "manual: the game chooses",
            DecisionOutcome.Exploring => "trying each backend",
            DecisionOutcome.Rejected => "a measurement was not finite",
            DecisionOutcome.HeldGate => "held: not worth the cost of a switch",
            DecisionOutcome.HeldTie => "held: not better by as much as matters",
            _ => "a reason that this package does not know",
        };
    }
}
