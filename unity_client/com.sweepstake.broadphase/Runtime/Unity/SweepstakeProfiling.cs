#nullable enable
using Unity.Profiling;

namespace Sweepstake.Unity
{
    /// <summary>Markers of the parts of a frame, and counters of each search in the category Scripts. They cost nothing in release players.</summary>
    public static class SweepstakeProfiling
    {
        public const string DetectionName = "Sweepstake Detection Time";
        public const string PairsName = "Sweepstake Pairs";
        public const string ObjectsName = "Sweepstake Objects";
        public const string ChecksName = "Sweepstake AABB Checks";
        public const string BackendName = "Sweepstake Backend";

        internal static readonly ProfilerMarker Search = new ProfilerMarker("Sweepstake.Search");
        internal static readonly ProfilerMarker Boxes = new ProfilerMarker("Sweepstake.ReadBoxes");
        internal static readonly ProfilerMarker Events = new ProfilerMarker("Sweepstake.Events");

        private static readonly ProfilerCounterValue<long> Detection = Counter(DetectionName, ProfilerMarkerDataUnit.TimeNanoseconds);
        private static readonly ProfilerCounterValue<long> Pairs = Counter(PairsName, ProfilerMarkerDataUnit.Count);
        private static readonly ProfilerCounterValue<long> Objects = Counter(ObjectsName, ProfilerMarkerDataUnit.Count);
        private static readonly ProfilerCounterValue<long> Checks = Counter(ChecksName, ProfilerMarkerDataUnit.Count);
        private static readonly ProfilerCounterValue<long> Backend = Counter(BackendName, ProfilerMarkerDataUnit.Undefined);

        internal static void Show(in FrameSample sample)
        {
            Detection.Value = (long)sample.DetectionTimeNs;
            Pairs.Value = sample.PairCount;
            Objects.Value = sample.ObjectCount;
            Checks.Value = (long)sample.AabbCheckCount;
            Backend.Value = sample.Arm;
        }

        private static ProfilerCounterValue<long> Counter(string name, ProfilerMarkerDataUnit unit) =>
            new ProfilerCounterValue<long>(ProfilerCategory.Scripts, name, unit, ProfilerCounterOptions.FlushOnEndOfFrame);
    }
}
