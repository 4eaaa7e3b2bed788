#nullable enable

namespace Sweepstake.Unity
{
    /// <summary>Remembers the values of the latest events, so that each change raises one event.</summary>
    internal sealed class ChangeWatcher
    {
        private int backend;
        private ulong decisionId;
        private ulong commandId;
        private VerdictKind verdictKind;

        internal void Reset(BroadPhaseSession session)
        {
            backend = session.ActiveArm;
            decisionId = session.LastDecision.DecisionId;
            commandId = session.LastDecision.CommandId;
            verdictKind = session.Verdict.Kind;
        }

        internal bool HasOtherBackend(BroadPhaseSession session)
        {
            int active = session.ActiveArm;
            bool isOther = active != backend;
            backend = active;
            return isOther;
        }

        /// <summary>Compares decision ids and command ids, because decisions of a daemon have a command id but no decision id.</summary>
        internal bool HasNewDecision(BroadPhaseSession session, out Decision decision)
        {
            decision = session.LastDecision;
            bool isNew = decision.DecisionId != decisionId || decision.CommandId != commandId;
            decisionId = decision.DecisionId;
            commandId = decision.CommandId;
            return isNew && decision.Outcome != DecisionOutcome.None;
        }

        internal bool HasOtherVerdict(BroadPhaseSession session, out Verdict verdict)
        {
            verdict = session.Verdict;
            bool isOther = verdict.Kind != verdictKind;
            verdictKind = verdict.Kind;
            return isOther;
        }
    }
}
