#nullable enable
using System;
using System.Globalization;
using System.Text;

namespace Sweepstake.Unity
{
    /// <summary>What a manager knows, as text for the HUD, the inspector and the window; in the invariant culture.</summary>
    public static class StatusText
    {
        /// <summary>A word or two.</summary>
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
        /// <param name="fps">Frames per second, which the caller averages.</param>
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
        }

        /// <summary>Appends backend, confidence, reason and age of the latest decision.</summary>
        public static void AppendDecision(StringBuilder text, SweepstakeManager manager)
        {
            Decision decision = manager.LastDecision;
            text.Append("Decision: ").Append(Advice.Of(decision.Outcome));
            if (decision.Outcome == DecisionOutcome.None || manager.Session == null)
                return;
            int arm = (int)(decision.CommandArm != Decision.NoArm ? decision.CommandArm : decision.ActiveArm);
            text.AppendFormat(
                CultureInfo.InvariantCulture, "; {0} is the best with {1:P0}, {2:F0} s ago",
                arm < manager.Backends.Count ? manager.Backends[arm] : "?", decision.ProbabilityOf(Math.Min(arm, 31)), AgeSeconds(decision));
        }

        public static double AgeSeconds(in Decision decision)
        {
            ulong nowNs = SteadyClock.NowNs;
            return decision.TimeNs == 0 || decision.TimeNs > nowNs ? 0 : (nowNs - decision.TimeNs) / 1e9;
        }
    }
}
