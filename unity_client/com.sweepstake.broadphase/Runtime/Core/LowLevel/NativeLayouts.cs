// Written by unity_client/tools/make_bindings.py from the headers of the C ABI.
#nullable enable
namespace Sweepstake.LowLevel
{
    /// <summary>The offset of each field in C, to compare with this runtime and with the loaded library.</summary>
    internal static unsafe class NativeLayouts
    {
        /// <summary>SWP_ABI_VERSION of the headers.</summary>
        internal const uint AbiVersion = 3;

        internal static void Check(LayoutProblems problems)
        {
            CheckAabb(problems);
            CheckOverlapPair(problems);
            CheckWorldOptions(problems);
            CheckWorldCounters(problems);
            CheckNativeSessionOptions(problems);
            CheckFrameSample(problems);
            CheckSwitchCommand(problems);
            CheckSwitchOutcome(problems);
            CheckShadowStats(problems);
            CheckVerdict(problems);
            CheckNativeDeciderOptions(problems);
            CheckBelief(problems);
            CheckProxySetOptions(problems);
            CheckProxyFilter(problems);
            CheckProxyOptions(problems);
            CheckProxyPair(problems);
            CheckRayQuery(problems);
            CheckQueryHit(problems);
            CheckSceneOptions(problems);
            CheckNativeLinkOptions(problems);
            CheckLinkStats(problems);
            CheckDecision(problems);
            CheckSphereQuery(problems);
            CheckBoxSweepQuery(problems);
            CheckRewardWeights(problems);
        }

        private static void CheckAabb(LayoutProblems problems)
        {
            byte* start;
            var aabb = default(Aabb);
            start = (byte*)&aabb;
            problems.Size("Aabb", 1, sizeof(Aabb), 24, false);
            problems.Field("Aabb.MinX", (byte*)&aabb.MinX - start, 0);
            problems.Field("Aabb.MaxX", (byte*)&aabb.MaxX - start, 12);
        }

        private static void CheckOverlapPair(LayoutProblems problems)
        {
            byte* start;
            var overlapPair = default(OverlapPair);
            start = (byte*)&overlapPair;
            problems.Size("OverlapPair", 2, sizeof(OverlapPair), 8, false);
            problems.Field("OverlapPair.A", (byte*)&overlapPair.A - start, 0);
            problems.Field("OverlapPair.B", (byte*)&overlapPair.B - start, 4);
        }

        private static void CheckWorldOptions(LayoutProblems problems)
        {
            byte* start;
            var worldOptions = default(WorldOptions);
            start = (byte*)&worldOptions;
            problems.Size("WorldOptions", 4, sizeof(WorldOptions), 32, true);
            problems.Field("WorldOptions.StructSize", (byte*)&worldOptions.StructSize - start, 0);
            problems.Field("WorldOptions.ThreadCount", (byte*)&worldOptions.ThreadCount - start, 4);
            problems.Field("WorldOptions.Executor", (byte*)&worldOptions.Executor - start, 8);
            problems.Field("WorldOptions.SortedPairs", (byte*)&worldOptions.SortedPairs - start, 16);
            problems.Field("WorldOptions.Reserved", (byte*)&worldOptions.Reserved - start, 20);
            problems.Field("WorldOptions.MaxPairs", (byte*)&worldOptions.MaxPairs - start, 24);
        }

        private static void CheckWorldCounters(LayoutProblems problems)
        {
            byte* start;
            var worldCounters = default(WorldCounters);
            start = (byte*)&worldCounters;
            problems.Size("WorldCounters", 5, sizeof(WorldCounters), 48, true);
            problems.Field("WorldCounters.StructSize", (byte*)&worldCounters.StructSize - start, 0);
            problems.Field("WorldCounters.ObjectCount", (byte*)&worldCounters.ObjectCount - start, 4);
            problems.Field("WorldCounters.AabbCheckCount", (byte*)&worldCounters.AabbCheckCount - start, 8);
            problems.Field("WorldCounters.NativeBytes", (byte*)&worldCounters.NativeBytes - start, 16);
            problems.Field("WorldCounters.DetectionTimeNs", (byte*)&worldCounters.DetectionTimeNs - start, 24);
            problems.Field("WorldCounters.PairCount", (byte*)&worldCounters.PairCount - start, 32);
            problems.Field("WorldCounters.BackendVersion", (byte*)&worldCounters.BackendVersion - start, 40);
            problems.Field("WorldCounters.InvalidBoxCount", (byte*)&worldCounters.InvalidBoxCount - start, 44);
        }

        private static void CheckNativeSessionOptions(LayoutProblems problems)
        {
            byte* start;
            var nativeSessionOptions = default(NativeSessionOptions);
            start = (byte*)&nativeSessionOptions;
            problems.Size("NativeSessionOptions", 6, sizeof(NativeSessionOptions), 96, true);
            problems.Field("NativeSessionOptions.StructSize", (byte*)&nativeSessionOptions.StructSize - start, 0);
            problems.Field("NativeSessionOptions.Mode", (byte*)&nativeSessionOptions.Mode - start, 4);
            problems.Field("NativeSessionOptions.Arms", (byte*)&nativeSessionOptions.Arms - start, 8);
            problems.Field("NativeSessionOptions.InitialArm", (byte*)&nativeSessionOptions.InitialArm - start, 16);
            problems.Field("NativeSessionOptions.BailOutNs", (byte*)&nativeSessionOptions.BailOutNs - start, 24);
            problems.Field("NativeSessionOptions.SettlingNs", (byte*)&nativeSessionOptions.SettlingNs - start, 32);
            problems.Field("NativeSessionOptions.Executor", (byte*)&nativeSessionOptions.Executor - start, 40);
            problems.Field("NativeSessionOptions.ThreadCount", (byte*)&nativeSessionOptions.ThreadCount - start, 48);
            problems.Field("NativeSessionOptions.QueueFrames", (byte*)&nativeSessionOptions.QueueFrames - start, 52);
            problems.Field("NativeSessionOptions.Shadow", (byte*)&nativeSessionOptions.Shadow - start, 56);
            problems.Field("NativeSessionOptions.SortedPairs", (byte*)&nativeSessionOptions.SortedPairs - start, 60);
            problems.Field("NativeSessionOptions.ShadowDutyRatio", (byte*)&nativeSessionOptions.ShadowDutyRatio - start, 64);
            problems.Field("NativeSessionOptions.ShadowMemoryBytes", (byte*)&nativeSessionOptions.ShadowMemoryBytes - start, 72);
            problems.Field("NativeSessionOptions.MemoryBudgetBytes", (byte*)&nativeSessionOptions.MemoryBudgetBytes - start, 80);
            problems.Field("NativeSessionOptions.MaxPairs", (byte*)&nativeSessionOptions.MaxPairs - start, 88);
        }

        private static void CheckFrameSample(LayoutProblems problems)
        {
            byte* start;
            var frameSample = default(FrameSample);
            start = (byte*)&frameSample;
            problems.Size("FrameSample", 7, sizeof(FrameSample), 64, false);
            problems.Field("FrameSample.FrameIndex", (byte*)&frameSample.FrameIndex - start, 0);
            problems.Field("FrameSample.FrameTimeNs", (byte*)&frameSample.FrameTimeNs - start, 8);
            problems.Field("FrameSample.DetectionTimeNs", (byte*)&frameSample.DetectionTimeNs - start, 16);
            problems.Field("FrameSample.AabbCheckCount", (byte*)&frameSample.AabbCheckCount - start, 24);
            problems.Field("FrameSample.NativeBytes", (byte*)&frameSample.NativeBytes - start, 32);
            problems.Field("FrameSample.PairCount", (byte*)&frameSample.PairCount - start, 40);
            problems.Field("FrameSample.ObjectCount", (byte*)&frameSample.ObjectCount - start, 44);
            problems.Field("FrameSample.Arm", (byte*)&frameSample.Arm - start, 48);
            problems.Field("FrameSample.SwitchEpoch", (byte*)&frameSample.SwitchEpoch - start, 52);
            problems.Field("FrameSample.Flags", (byte*)&frameSample.Flags - start, 56);
            problems.Field("FrameSample.InvalidBoxCount", (byte*)&frameSample.InvalidBoxCount - start, 60);
        }

        private static void CheckSwitchCommand(LayoutProblems problems)
        {
            byte* start;
            var switchCommand = default(SwitchCommand);
            start = (byte*)&switchCommand;
            problems.Size("SwitchCommand", 8, sizeof(SwitchCommand), 16, false);
            problems.Field("SwitchCommand.CommandId", (byte*)&switchCommand.CommandId - start, 0);
            problems.Field("SwitchCommand.Arm", (byte*)&switchCommand.Arm - start, 8);
            problems.Field("SwitchCommand.Reason", (byte*)&switchCommand.Reason - start, 12);
        }

        private static void CheckSwitchOutcome(LayoutProblems problems)
        {
            byte* start;
            var switchOutcome = default(SwitchOutcome);
            start = (byte*)&switchOutcome;
            problems.Size("SwitchOutcome", 9, sizeof(SwitchOutcome), 40, false);
            problems.Field("SwitchOutcome.CommandId", (byte*)&switchOutcome.CommandId - start, 0);
            problems.Field("SwitchOutcome.Arm", (byte*)&switchOutcome.Arm - start, 8);
            problems.Field("SwitchOutcome.SwitchEpoch", (byte*)&switchOutcome.SwitchEpoch - start, 12);
            problems.Field("SwitchOutcome.RebuildTimeNs", (byte*)&switchOutcome.RebuildTimeNs - start, 16);
            problems.Field("SwitchOutcome.SettlingCostNs", (byte*)&switchOutcome.SettlingCostNs - start, 24);
            problems.Field("SwitchOutcome.Reason", (byte*)&switchOutcome.Reason - start, 32);
            problems.Field("SwitchOutcome.Executed", (byte*)&switchOutcome.Executed - start, 36);
        }

        private static void CheckShadowStats(LayoutProblems problems)
        {
            byte* start;
            var shadowStats = default(ShadowStats);
            start = (byte*)&shadowStats;
            problems.Size("ShadowStats", 10, sizeof(ShadowStats), 80, true);
            problems.Field("ShadowStats.StructSize", (byte*)&shadowStats.StructSize - start, 0);
            problems.Field("ShadowStats.State", (byte*)&shadowStats.State - start, 4);
            problems.Field("ShadowStats.SweepCount", (byte*)&shadowStats.SweepCount - start, 8);
            problems.Field("ShadowStats.VisitCount", (byte*)&shadowStats.VisitCount - start, 16);
            problems.Field("ShadowStats.CappedVisitCount", (byte*)&shadowStats.CappedVisitCount - start, 24);
            problems.Field("ShadowStats.BusyTimeNs", (byte*)&shadowStats.BusyTimeNs - start, 32);
            problems.Field("ShadowStats.MemoryBytes", (byte*)&shadowStats.MemoryBytes - start, 40);
            problems.Field("ShadowStats.CopiedFrameCount", (byte*)&shadowStats.CopiedFrameCount - start, 48);
            problems.Field("ShadowStats.CopyTimeNs", (byte*)&shadowStats.CopyTimeNs - start, 56);
            problems.Field("ShadowStats.WarmSwitchCount", (byte*)&shadowStats.WarmSwitchCount - start, 64);
            problems.Field("ShadowStats.ColdSwitchCount", (byte*)&shadowStats.ColdSwitchCount - start, 72);
        }

        private static void CheckVerdict(LayoutProblems problems)
        {
            byte* start;
            var verdict = default(Verdict);
            start = (byte*)&verdict;
            problems.Size("Verdict", 11, sizeof(Verdict), 16, false);
            problems.Field("Verdict.Kind", (byte*)&verdict.Kind - start, 0);
            problems.Field("Verdict.LeaderArm", (byte*)&verdict.LeaderArm - start, 4);
            problems.Field("Verdict.LeaderProbability", (byte*)&verdict.LeaderProbability - start, 8);
        }

        private static void CheckNativeDeciderOptions(LayoutProblems problems)
        {
            byte* start;
            var nativeDeciderOptions = default(NativeDeciderOptions);
            start = (byte*)&nativeDeciderOptions;
            problems.Size("NativeDeciderOptions", 12, sizeof(NativeDeciderOptions), 152, true);
            problems.Field("NativeDeciderOptions.StructSize", (byte*)&nativeDeciderOptions.StructSize - start, 0);
            problems.Field("NativeDeciderOptions.Reserved", (byte*)&nativeDeciderOptions.Reserved - start, 4);
            problems.Field("NativeDeciderOptions.Policy", (byte*)&nativeDeciderOptions.Policy - start, 8);
            problems.Field("NativeDeciderOptions.Project", (byte*)&nativeDeciderOptions.Project - start, 16);
            problems.Field("NativeDeciderOptions.Scene", (byte*)&nativeDeciderOptions.Scene - start, 24);
            problems.Field("NativeDeciderOptions.MachineClass", (byte*)&nativeDeciderOptions.MachineClass - start, 32);
            problems.Field("NativeDeciderOptions.Build", (byte*)&nativeDeciderOptions.Build - start, 40);
            problems.Field("NativeDeciderOptions.SourceId", (byte*)&nativeDeciderOptions.SourceId - start, 48);
            problems.Field("NativeDeciderOptions.PriorsFile", (byte*)&nativeDeciderOptions.PriorsFile - start, 56);
            problems.Field("NativeDeciderOptions.PriorsData", (byte*)&nativeDeciderOptions.PriorsData - start, 64);
            problems.Field("NativeDeciderOptions.PriorsDataBytes", (byte*)&nativeDeciderOptions.PriorsDataBytes - start, 72);
            problems.Field("NativeDeciderOptions.Seed", (byte*)&nativeDeciderOptions.Seed - start, 80);
            problems.Field("NativeDeciderOptions.TimeScale", (byte*)&nativeDeciderOptions.TimeScale - start, 88);
            problems.Field("NativeDeciderOptions.DecisionIntervalNs", (byte*)&nativeDeciderOptions.DecisionIntervalNs - start, 96);
            problems.Field("NativeDeciderOptions.CooldownNs", (byte*)&nativeDeciderOptions.CooldownNs - start, 104);
            problems.Field("NativeDeciderOptions.FpsFloor", (byte*)&nativeDeciderOptions.FpsFloor - start, 112);
            problems.Field("NativeDeciderOptions.Weights", (byte*)&nativeDeciderOptions.Weights - start, 120);
        }

        private static void CheckBelief(LayoutProblems problems)
        {
            byte* start;
            var belief = default(Belief);
            start = (byte*)&belief;
            problems.Size("Belief", 13, sizeof(Belief), 16, false);
            problems.Field("Belief.Alpha", (byte*)&belief.Alpha - start, 0);
            problems.Field("Belief.Beta", (byte*)&belief.Beta - start, 8);
        }

        private static void CheckProxySetOptions(LayoutProblems problems)
        {
            byte* start;
            var proxySetOptions = default(ProxySetOptions);
            start = (byte*)&proxySetOptions;
            problems.Size("ProxySetOptions", 14, sizeof(ProxySetOptions), 40, true);
            problems.Field("ProxySetOptions.StructSize", (byte*)&proxySetOptions.StructSize - start, 0);
            problems.Field("ProxySetOptions.PairEvents", (byte*)&proxySetOptions.PairEvents - start, 4);
            problems.Field("ProxySetOptions.SortedPairs", (byte*)&proxySetOptions.SortedPairs - start, 8);
            problems.Field("ProxySetOptions.ThreadCount", (byte*)&proxySetOptions.ThreadCount - start, 12);
            problems.Field("ProxySetOptions.Executor", (byte*)&proxySetOptions.Executor - start, 16);
            problems.Field("ProxySetOptions.EventMargin", (byte*)&proxySetOptions.EventMargin - start, 24);
            problems.Field("ProxySetOptions.Reserved", (byte*)&proxySetOptions.Reserved - start, 28);
            problems.Field("ProxySetOptions.MaxPairs", (byte*)&proxySetOptions.MaxPairs - start, 32);
        }

        private static void CheckProxyFilter(LayoutProblems problems)
        {
            byte* start;
            var proxyFilter = default(ProxyFilter);
            start = (byte*)&proxyFilter;
            problems.Size("ProxyFilter", 15, sizeof(ProxyFilter), 8, false);
            problems.Field("ProxyFilter.Category", (byte*)&proxyFilter.Category - start, 0);
            problems.Field("ProxyFilter.Mask", (byte*)&proxyFilter.Mask - start, 4);
        }

        private static void CheckProxyOptions(LayoutProblems problems)
        {
            byte* start;
            var proxyOptions = default(ProxyOptions);
            start = (byte*)&proxyOptions;
            problems.Size("ProxyOptions", 16, sizeof(ProxyOptions), 24, false);
            problems.Field("ProxyOptions.Filter", (byte*)&proxyOptions.Filter - start, 0);
            problems.Field("ProxyOptions.Flags", (byte*)&proxyOptions.Flags - start, 8);
            problems.Field("ProxyOptions.Reserved", (byte*)&proxyOptions.Reserved - start, 12);
            problems.Field("ProxyOptions.User", (byte*)&proxyOptions.User - start, 16);
        }

        private static void CheckProxyPair(LayoutProblems problems)
        {
            byte* start;
            var proxyPair = default(ProxyPair);
            start = (byte*)&proxyPair;
            problems.Size("ProxyPair", 17, sizeof(ProxyPair), 16, false);
            problems.Field("ProxyPair.A", (byte*)&proxyPair.A - start, 0);
            problems.Field("ProxyPair.B", (byte*)&proxyPair.B - start, 8);
        }

        private static void CheckRayQuery(LayoutProblems problems)
        {
            byte* start;
            var rayQuery = default(RayQuery);
            start = (byte*)&rayQuery;
            problems.Size("RayQuery", 18, sizeof(RayQuery), 28, false);
            problems.Field("RayQuery.OriginX", (byte*)&rayQuery.OriginX - start, 0);
            problems.Field("RayQuery.DirectionX", (byte*)&rayQuery.DirectionX - start, 12);
            problems.Field("RayQuery.MaxDistance", (byte*)&rayQuery.MaxDistance - start, 24);
        }

        private static void CheckQueryHit(LayoutProblems problems)
        {
            byte* start;
            var queryHit = default(QueryHit);
            start = (byte*)&queryHit;
            problems.Size("QueryHit", 19, sizeof(QueryHit), 16, false);
            problems.Field("QueryHit.Proxy", (byte*)&queryHit.Proxy - start, 0);
            problems.Field("QueryHit.Distance", (byte*)&queryHit.Distance - start, 8);
            problems.Field("QueryHit.Reserved", (byte*)&queryHit.Reserved - start, 12);
        }

        private static void CheckSceneOptions(LayoutProblems problems)
        {
            byte* start;
            var sceneOptions = default(SceneOptions);
            start = (byte*)&sceneOptions;
            problems.Size("SceneOptions", 20, sizeof(SceneOptions), 56, true);
            problems.Field("SceneOptions.StructSize", (byte*)&sceneOptions.StructSize - start, 0);
            problems.Field("SceneOptions.ObjectCount", (byte*)&sceneOptions.ObjectCount - start, 4);
            problems.Field("SceneOptions.SpawnSeed", (byte*)&sceneOptions.SpawnSeed - start, 8);
            problems.Field("SceneOptions.MotionSeed", (byte*)&sceneOptions.MotionSeed - start, 16);
            problems.Field("SceneOptions.WorldHalfExtent", (byte*)&sceneOptions.WorldHalfExtent - start, 24);
            problems.Field("SceneOptions.FixedStepS", (byte*)&sceneOptions.FixedStepS - start, 28);
            problems.Field("SceneOptions.HalfExtentMin", (byte*)&sceneOptions.HalfExtentMin - start, 32);
            problems.Field("SceneOptions.HalfExtentMax", (byte*)&sceneOptions.HalfExtentMax - start, 36);
            problems.Field("SceneOptions.Speed", (byte*)&sceneOptions.Speed - start, 40);
            problems.Field("SceneOptions.Gravity", (byte*)&sceneOptions.Gravity - start, 44);
            problems.Field("SceneOptions.DirectionIntervalS", (byte*)&sceneOptions.DirectionIntervalS - start, 48);
            problems.Field("SceneOptions.Reserved", (byte*)&sceneOptions.Reserved - start, 52);
        }

        private static void CheckNativeLinkOptions(LayoutProblems problems)
        {
            byte* start;
            var nativeLinkOptions = default(NativeLinkOptions);
            start = (byte*)&nativeLinkOptions;
            problems.Size("NativeLinkOptions", 21, sizeof(NativeLinkOptions), 168, true);
            problems.Field("NativeLinkOptions.StructSize", (byte*)&nativeLinkOptions.StructSize - start, 0);
            problems.Field("NativeLinkOptions.AllowOperatorOrders", (byte*)&nativeLinkOptions.AllowOperatorOrders - start, 4);
            problems.Field("NativeLinkOptions.Daemon", (byte*)&nativeLinkOptions.Daemon - start, 8);
            problems.Field("NativeLinkOptions.Project", (byte*)&nativeLinkOptions.Project - start, 16);
            problems.Field("NativeLinkOptions.Scene", (byte*)&nativeLinkOptions.Scene - start, 24);
            problems.Field("NativeLinkOptions.Build", (byte*)&nativeLinkOptions.Build - start, 32);
            problems.Field("NativeLinkOptions.MachineClass", (byte*)&nativeLinkOptions.MachineClass - start, 40);
            problems.Field("NativeLinkOptions.Policy", (byte*)&nativeLinkOptions.Policy - start, 48);
            problems.Field("NativeLinkOptions.Seed", (byte*)&nativeLinkOptions.Seed - start, 56);
            problems.Field("NativeLinkOptions.TimeScale", (byte*)&nativeLinkOptions.TimeScale - start, 64);
            problems.Field("NativeLinkOptions.JitterSeed", (byte*)&nativeLinkOptions.JitterSeed - start, 72);
            problems.Field("NativeLinkOptions.IgnorePriors", (byte*)&nativeLinkOptions.IgnorePriors - start, 80);
            problems.Field("NativeLinkOptions.BatchIntervalMs", (byte*)&nativeLinkOptions.BatchIntervalMs - start, 84);
            problems.Field("NativeLinkOptions.BatchFrames", (byte*)&nativeLinkOptions.BatchFrames - start, 88);
            problems.Field("NativeLinkOptions.BatchBytes", (byte*)&nativeLinkOptions.BatchBytes - start, 92);
            problems.Field("NativeLinkOptions.UnacknowledgedMessages", (byte*)&nativeLinkOptions.UnacknowledgedMessages - start, 96);
            problems.Field("NativeLinkOptions.BackoffMinMs", (byte*)&nativeLinkOptions.BackoffMinMs - start, 100);
            problems.Field("NativeLinkOptions.BackoffMaxMs", (byte*)&nativeLinkOptions.BackoffMaxMs - start, 104);
            problems.Field("NativeLinkOptions.Reserved", (byte*)&nativeLinkOptions.Reserved - start, 108);
            problems.Field("NativeLinkOptions.DecisionIntervalNs", (byte*)&nativeLinkOptions.DecisionIntervalNs - start, 112);
            problems.Field("NativeLinkOptions.CooldownNs", (byte*)&nativeLinkOptions.CooldownNs - start, 120);
            problems.Field("NativeLinkOptions.SettlingNs", (byte*)&nativeLinkOptions.SettlingNs - start, 128);
            problems.Field("NativeLinkOptions.Weights", (byte*)&nativeLinkOptions.Weights - start, 136);
        }

        private static void CheckLinkStats(LayoutProblems problems)
        {
            byte* start;
            var linkStats = default(LinkStats);
            start = (byte*)&linkStats;
            problems.Size("LinkStats", 22, sizeof(LinkStats), 104, true);
            problems.Field("LinkStats.StructSize", (byte*)&linkStats.StructSize - start, 0);
            problems.Field("LinkStats.State", (byte*)&linkStats.State - start, 4);
            problems.Field("LinkStats.SentFrameCount", (byte*)&linkStats.SentFrameCount - start, 8);
            problems.Field("LinkStats.DiscardedFrameCount", (byte*)&linkStats.DiscardedFrameCount - start, 16);
            problems.Field("LinkStats.SentSequence", (byte*)&linkStats.SentSequence - start, 24);
            problems.Field("LinkStats.AcknowledgedSequence", (byte*)&linkStats.AcknowledgedSequence - start, 32);
            problems.Field("LinkStats.ConnectionCount", (byte*)&linkStats.ConnectionCount - start, 40);
            problems.Field("LinkStats.ResumedCount", (byte*)&linkStats.ResumedCount - start, 48);
            problems.Field("LinkStats.ResentMessageCount", (byte*)&linkStats.ResentMessageCount - start, 56);
            problems.Field("LinkStats.CommandCount", (byte*)&linkStats.CommandCount - start, 64);
            problems.Field("LinkStats.UnknownMessageCount", (byte*)&linkStats.UnknownMessageCount - start, 72);
            problems.Field("LinkStats.PriorSourceCount", (byte*)&linkStats.PriorSourceCount - start, 80);
            problems.Field("LinkStats.Seed", (byte*)&linkStats.Seed - start, 88);
            problems.Field("LinkStats.PriorsUnavailable", (byte*)&linkStats.PriorsUnavailable - start, 96);
            problems.Field("LinkStats.AwaitsAcknowledgement", (byte*)&linkStats.AwaitsAcknowledgement - start, 100);
        }

        private static void CheckDecision(LayoutProblems problems)
        {
            byte* start;
            var decision = default(Decision);
            start = (byte*)&decision;
            problems.Size("Decision", 23, sizeof(Decision), 328, true);
            problems.Field("Decision.StructSize", (byte*)&decision.StructSize - start, 0);
            problems.Field("Decision.Outcome", (byte*)&decision.Outcome - start, 4);
            problems.Field("Decision.DecisionId", (byte*)&decision.DecisionId - start, 8);
            problems.Field("Decision.TimeNs", (byte*)&decision.TimeNs - start, 16);
            problems.Field("Decision.ActiveArm", (byte*)&decision.ActiveArm - start, 24);
            problems.Field("Decision.CandidateArm", (byte*)&decision.CandidateArm - start, 28);
            problems.Field("Decision.CommandId", (byte*)&decision.CommandId - start, 32);
            problems.Field("Decision.CommandArm", (byte*)&decision.CommandArm - start, 40);
            problems.Field("Decision.CommandReason", (byte*)&decision.CommandReason - start, 44);
            problems.Field("Decision.Verdict", (byte*)&decision.Verdict - start, 48);
            problems.Field("Decision.ExpectedLossRatio", (byte*)&decision.ExpectedLossRatio - start, 64);
            problems.Field("Decision.BestProbability", (byte*)decision.BestProbability - start, 72);
        }

        private static void CheckSphereQuery(LayoutProblems problems)
        {
            byte* start;
            var sphereQuery = default(SphereQuery);
            start = (byte*)&sphereQuery;
            problems.Size("SphereQuery", 24, sizeof(SphereQuery), 16, false);
            problems.Field("SphereQuery.CenterX", (byte*)&sphereQuery.CenterX - start, 0);
            problems.Field("SphereQuery.Radius", (byte*)&sphereQuery.Radius - start, 12);
        }

        private static void CheckBoxSweepQuery(LayoutProblems problems)
        {
            byte* start;
            var boxSweepQuery = default(BoxSweepQuery);
            start = (byte*)&boxSweepQuery;
            problems.Size("BoxSweepQuery", 25, sizeof(BoxSweepQuery), 36, false);
            problems.Field("BoxSweepQuery.Box", (byte*)&boxSweepQuery.Box - start, 0);
            problems.Field("BoxSweepQuery.TranslationX", (byte*)&boxSweepQuery.TranslationX - start, 24);
        }

        private static void CheckRewardWeights(LayoutProblems problems)
        {
            byte* start;
            var rewardWeights = default(RewardWeights);
            start = (byte*)&rewardWeights;
            problems.Size("RewardWeights", 28, sizeof(RewardWeights), 32, false);
            problems.Field("RewardWeights.Fps", (byte*)&rewardWeights.Fps - start, 0);
            problems.Field("RewardWeights.Detection", (byte*)&rewardWeights.Detection - start, 8);
            problems.Field("RewardWeights.Memory", (byte*)&rewardWeights.Memory - start, 16);
            problems.Field("RewardWeights.Checks", (byte*)&rewardWeights.Checks - start, 24);
        }
    }
}
