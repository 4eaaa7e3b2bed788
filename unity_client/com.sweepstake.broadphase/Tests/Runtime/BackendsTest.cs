#nullable enable
using System;
using System.Collections.Generic;
using NUnit.Framework;

namespace Sweepstake.Tests
{
    public sealed class BackendsTest
    {
        private const int Frames = 60;

        public static IEnumerable<string> Backends => SweepstakeLibrary.Backends;

        private static readonly string[] Scenarios = { "brownian", "rotating-gravity", "hurricane", "free-fall", "random-gravity" };

        [Test]
        public void EachBackendFindsThePairsOfTheOracleInEachScenario(
            [ValueSource(nameof(Backends))] string backend, [ValueSource(nameof(Scenarios))] string scenario)
        {
            using var scene = Oracle.CrowdedScene(scenario);
            using var world = new BroadPhaseWorld(backend);
            world.Build(scene.Boxes);
            int pairCount = 0;
            for (int frame = 0; frame < Frames; ++frame)
            {
                scene.Step();
                world.Update(scene.Boxes);
                world.FindPairs();
                List<OverlapPair> expected = Oracle.Pairs(scene.Boxes);
                Assert.That(Oracle.Sorted(world.Pairs), Is.EqualTo(expected), $"frame {frame}");
                Assert.That(world.Counters.PairCount, Is.EqualTo(expected.Count));
                pairCount += expected.Count;
            }
            Assert.That(pairCount, Is.GreaterThan(0), "the test needs a scene with pairs");
        }

        [Test]
        public void EachBackendTakesAnotherCountOfBoxesAndBrokenOnes([ValueSource(nameof(Backends))] string backend)
        {
            using var scene = Oracle.CrowdedScene("brownian");
            using var world = new BroadPhaseWorld(backend);
            Aabb[] boxes = scene.Boxes.ToArray();
            boxes[3].MinX = float.NaN;
            boxes[5].MaxY = float.PositiveInfinity;
            boxes[7] = new Aabb(1, 1, 1, -1, -1, -1);
            world.Build(boxes);
            foreach (int count in new[] { 300, 120, 250, 0, 1, 300 })
            {
                world.Update(boxes.AsSpan(0, count));
                world.FindPairs();
                Assert.That(Oracle.Sorted(world.Pairs), Is.EqualTo(Oracle.Pairs(boxes.AsSpan(0, count))), $"{count} boxes");
            }
        }

        [Test]
        public void SortedPairsAscendAndThreadsChangeNothing([ValueSource(nameof(Backends))] string backend)
        {
            WorldOptions options = WorldOptions.Default;
            options.IsSorted = true;
            options.ThreadCount = 3;
            using var scene = Oracle.CrowdedScene("hurricane");
            using var world = new BroadPhaseWorld(backend, options);
            world.Build(scene.Boxes);
            world.FindPairs();
            Assert.That(world.Pairs.ToArray(), Is.EqualTo(Oracle.Pairs(scene.Boxes)));
        }

        [Test]
        public void AnUnknownBackendIsRefusedWithTheNamesOfAll()
        {
            var refused = Assert.Throws<SweepstakeException>(() => new BroadPhaseWorld("Quadtree"));
            Assert.That(refused!.Code, Is.EqualTo(ResultCode.NotFound));
            Assert.That(refused.Message, Does.Contain("Quadtree"));
            foreach (string backend in SweepstakeLibrary.Backends)
                Assert.That(refused.Message, Does.Contain(backend));
        }

        [Test]
        public void CallsInTheWrongOrderSaySo()
        {
            using var world = new BroadPhaseWorld("SAP");
            var refused = Assert.Throws<SweepstakeException>(() => world.FindPairs());
            Assert.That(refused!.Code, Is.EqualTo(ResultCode.FailedPrecondition));
            world.Dispose();
            world.Dispose();
            Assert.Throws<ObjectDisposedException>(() => world.FindPairs());
        }
    }
}
