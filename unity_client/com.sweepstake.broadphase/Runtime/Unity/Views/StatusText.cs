#nullable enable
using System;
using System.Globalization;
using System.Text;
using UnityEngine;

namespace Sweepstake.Unity
{
    /// <summary>Formats the state of a manager for the HUD, the inspector and the window, in the invariant culture.</summary>
    public static class StatusText
    {
        /// <summary>The state in one or two words.</summary>
        public static string Chip(SweepstakeState state) => state switch
        {
            SweepstakeState.Embedded => "Offline (embedded)",
            SweepstakeState.Connecting => "Connecting",
            SweepstakeState.Online => "Online",
            SweepstakeState.Offline => "Offline",
            SweepstakeState.Refused => "Refused",
            _ => state.ToString(),
        };

        /// <summary>Appends the lines of a HUD.</summary>
        /// <param name="fps">Frames per second, averaged by the caller.</param>
        public static void Append(StringBuilder text, SweepstakeManager manager, double fps)
        {
            text.Append("Sweepstake: ").Append(Chip(manager.State)).Append(", ").Append(manager.Mode == SessionMode.Ai ? "AI Decides" : "Manual");
            if (manager.Problem.Length > 0)
                text.Append('\n').Append(manager.Problem);
            if (manager.Session == null)
                return;
            FrameSample sample = manager.LastSample;
            text.Append('\n').Append(manager.ActiveBackend).AppendFormat(
                CultureInfo.InvariantCulture, ": {0:F3} ms of {1:F1} ms ({2:F0} fps)\n{3} objects, {4} pairs, {5} switches\n",
                sample.DetectionTimeNs / 1e6, fps > 0 ? 1000 / fps : 0, fps, sample.ObjectCount, sample.PairCount, manager.Session.SwitchEpoch);
            AppendDecision(text, manager);
            text.Append('\n').Append(Advice.Of(manager.Verdict.Kind));
            if (QualitySettings.vSyncCount > 0)
                text.Append("\nvSync is on: it limits the frame rate, and with it the gain of a faster backend.");
        }

        /// <summary>Appends the latest decision: reason, command or candidate, the best backend, and age. Unknown parts are left out.</summary>
        public static void AppendDecision(StringBuilder text, SweepstakeManager manager) => AppendDecision(text, manager, manager.LastDecision);

        internal static void AppendDecision(StringBuilder text, SweepstakeManager manager, in Decision decision)
        {
            text.Append("Decision: ").Append(Advice.Of(decision.Outcome));
            if (decision.Outcome == DecisionOutcome.None || manager.Session == null)
                return;
            if (decision.CommandArm != Decision.NoArm)
                text.Append("; command: ").Append(NameOf(manager, decision.CommandArm));
            else if (IsHeld(decision.Outcome) && decision.CandidateArm != Decision.NoArm)
                text.Append("; candidate: ").Append(NameOf(manager, decision.CandidateArm));
            Verdict verdict = decision.Verdict;
            if (verdict.LeaderProbability > 0)
            {
                text.AppendFormat(
                    CultureInfo.InvariantCulture, "; {0} is the best with {1:P0}", NameOf(manager, verdict.LeaderArm), verdict.LeaderProbability);
            }
            long ageNs = decision.TimeNs == 0 ? 0 : Math.Max(0, (long)(SteadyClock.NowNs - decision.TimeNs));
            text.AppendFormat(CultureInfo.InvariantCulture, "; {0:F0} s ago", ageNs / 1e9);
        }

        private static bool IsHeld(DecisionOutcome outcome) =>
            outcome == DecisionOutcome.HeldCooldown || outcome == DecisionOutcome.HeldSettling || outcome == DecisionOutcome.HeldGate;

        private static string NameOf(SweepstakeManager manager, uint arm) => arm < manager.Backends.Count ? manager.Backends[(int)arm] : "?";
    }

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
            _ => "The verdict is newer than this version of the package. Update the package.",
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
            _ => "a reason that is newer than this version of the package",
        };
    }
}
