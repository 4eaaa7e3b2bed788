#nullable enable
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
            SweepstakeState.Stopped => "Stopped",
            SweepstakeState.Failed => "Failed",
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

        /// <summary>
        /// Appends the latest decision: its reason, the backend that it commands or holds back, the best backend with its probability, and its age.
        /// Unknown parts are left out.
        /// </summary>
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
            text.AppendFormat(CultureInfo.InvariantCulture, "; {0:F0} s ago", AgeSeconds(decision));
        }

        public static double AgeSeconds(in Decision decision)
        {
            ulong nowNs = SteadyClock.NowNs;
            return decision.TimeNs == 0 || decision.TimeNs > nowNs ? 0 : (nowNs - decision.TimeNs) / 1e9;
        }

        private static bool IsHeld(DecisionOutcome outcome) =>
            outcome == DecisionOutcome.HeldCooldown || outcome == DecisionOutcome.HeldSettling || outcome == DecisionOutcome.HeldGate;

        private static string NameOf(SweepstakeManager manager, uint arm) => arm < manager.Backends.Count ? manager.Backends[(int)arm] : "?";
    }
}
