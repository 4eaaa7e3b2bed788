#nullable enable
using System;
using Sweepstake.Unity;
using Unity.Profiling;
using Unity.Profiling.Editor;

namespace Sweepstake.Editor
{
    /// <summary>The profiler's chart of the cost and the results of each search.</summary>
    [Serializable]
    [ProfilerModuleMetadata("Sweepstake")]
    internal sealed class SweepstakeProfilerModule : ProfilerModule
    {
        private static readonly ProfilerCounterDescriptor[] Counters =
        {
            Counter(SweepstakeProfiling.DetectionName), Counter(SweepstakeProfiling.PairsName), Counter(SweepstakeProfiling.ObjectsName),
            Counter(SweepstakeProfiling.ChecksName), Counter(SweepstakeProfiling.BackendName),
        };

        public SweepstakeProfilerModule()
            : base(Counters)
        {
        }

        private static ProfilerCounterDescriptor Counter(string name) => new ProfilerCounterDescriptor(name, ProfilerCategory.Scripts);
    }
}
