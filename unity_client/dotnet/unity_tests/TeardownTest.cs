using System;
using System.Diagnostics;
using System.IO;
using System.Linq;
using System.Threading;
using NUnit.Framework;
using Sweepstake.Samples;
using Sweepstake.Unity;

namespace Sweepstake.Tests
{
    /// <summary>Tests the end of managers whose threads hang: it waits once for all of them together, not once for each.</summary>
    public sealed class TeardownTest : Stage
    {
        // Ended one after another, the managers would take 8 × 500 ms = 4 s.
        private const int ManagerCount = 8;
        private static readonly TimeSpan Bound = TimeSpan.FromSeconds(2);

        [Test]
        public void ManyManagersWithAStuckTransportEndWithinOneDeadline() => Eventually.TakesLessThan(Bound, EndOfStuckManagers);

        private static TimeSpan EndOfStuckManagers()
        {
            using var release = new ManualResetEventSlim();
            using var stuck = new CountdownEvent(ManagerCount);
            for (int index = 0; index < ManagerCount; ++index)
            {
                SweepstakeManager manager = MakeManager();
                manager.gameObject.AddComponent<ScenarioPlayer>().ObjectCount = 10;
                manager.Connect(new StuckTransport(stuck, release), new LinkOptions { Project = "p", Scene = "s" });
            }
            FramesUntil(() => stuck.IsSet, "stuck");
            var watch = Stopwatch.StartNew();
            SweepstakeManager.Shutdown();
            TimeSpan taken = watch.Elapsed;
            release.Set();
            return taken;
        }

        [Test]
        public void ACsvFileIsWrittenToItsEndWhenItsManagerEnds()
        {
            string path = Path.GetTempFileName();
            SweepstakeManager manager = MakeManager();
            manager.gameObject.AddComponent<ScenarioPlayer>().ObjectCount = 10;
            manager.StartCsv(path);
            Frames(2000);
            SweepstakeManager.Shutdown();
            Eventually.Is(() => File.ReadLines(path).Count() == 2001, () => "written to the end");
            File.Delete(path);
        }

        /// <summary>A transport whose Open blocks until the test releases it.</summary>
        private sealed class StuckTransport : ITelemetryTransport
        {
            private readonly CountdownEvent stuck;
            private readonly ManualResetEventSlim release;
            private bool isStuck;

            internal StuckTransport(CountdownEvent stuck, ManualResetEventSlim release)
            {
                this.stuck = stuck;
                this.release = release;
            }

            public ITelemetryStream Open()
            {
                if (!isStuck)
                    stuck.Signal();
                isStuck = true;
                release.Wait();
                throw new SweepstakeException(ResultCode.Unavailable, "The network is missing.");
            }

            public void Dispose()
            {
            }
        }
    }
}
