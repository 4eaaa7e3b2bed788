using System;
using System.Diagnostics;
using System.Linq;
using NUnit.Framework;
using Sweepstake.Unity;
using Unity.Collections;
using UnityEngine;
using UnityEngine.Jobs;

namespace Sweepstake.Tests
{
    /// <summary>
    /// Prints the cost of 10,000 moving colliders, of which every tenth has a body. It checks nothing, and only the command in colliders.md starts
    /// it. Stubs replace Unity's transforms and job system: the job runs on one thread and without Burst.
    /// </summary>
    [Explicit]
    public sealed class ColliderCost : Stage
    {
        private const int Count = 10_000;
        private const int Rounds = 500;
        private const int WarmUpRounds = 100;
        /// <summary>Boxes of size 1 in a cube of this size have about 1,900 pairs.</summary>
        private const float Reach = 60;

        private readonly System.Random random = new System.Random(11);
        private BoxCollider[] boxes;
        private Vector3[] origins;

        [SetUp]
        public void Make()
        {
            boxes = Enumerable.Range(0, Count).Select(_ => MakeBox(Reach * Vector(0, 1))).ToArray();
            origins = boxes.Select(box => box.transform.position).ToArray();
        }

        [Test]
        public void TenThousandColliders()
        {
            var filters = new LayerFilters();
            filters.Read(~0, 0, true);
            using var set = new ColliderSet(filters);
            using var session = new BroadPhaseSession(new SessionOptions { Mode = SessionMode.Manual, InitialArm = "KDTree" });
            var listeners = new Listeners<ColliderPair>();
            for (int index = 0; index < Count; ++index)
                set.Add(boxes[index], index % 10 == 0 ? boxes[index].gameObject.AddComponent<SweepstakeBody>() : null, false);
            Print("the job", TimeOfJob());
            var times = new double[4][].Select(_ => new double[Rounds]).ToArray();
            for (int round = -WarmUpRounds; round < Rounds; ++round)
            {
                Move(round);
                int at = Math.Max(0, round);
                times[0][at] = MsOf(set.ReadBoxes);
                session.BeginFrame();
                times[1][at] = MsOf(() => set.FindPairs(session));
                times[2][at] = MsOf(() => set.Pairs.Raise(listeners, listeners, null));
                session.EndFrame(1);
                times[3][at] = session.LastSample.DetectionTimeNs / 1e6;
            }
            Print("checks, job, and passing the boxes", times[0]);
            Print("search and pairs", times[1]);
            Print("of which the search", times[3]);
            Print("events", times[2]);
            TestContext.Out.WriteLine($"{set.Pairs.OpenCount} pairs in the last frame");
        }

        /// <summary>The time of the job's code for each frame, with the transforms of the boxes.</summary>
        private double[] TimeOfJob()
        {
            using var shapes = new NativeArray<ColliderShape>(Count, Allocator.Persistent);
            using var result = new NativeArray<Aabb>(Count, Allocator.Persistent);
            using var transforms = new TransformAccessArray(Count);
            for (int index = 0; index < Count; ++index)
            {
                shapes.AsSpan()[index] = ColliderShape.Of(boxes[index], default);
                transforms.Add(boxes[index].transform);
            }
            var job = new ColliderBoxesJob { Shapes = shapes, Boxes = result };
            return Enumerable.Range(0, WarmUpRounds + Rounds).Select(_ => MsOf(() => job.ScheduleReadOnly(transforms, 64).Complete())).Skip(WarmUpRounds).ToArray();
        }

        /// <summary>Each box swings around its origin, so that the number of pairs stays about the same.</summary>
        private void Move(int round)
        {
            for (int index = 0; index < Count; ++index)
                boxes[index].transform.position = origins[index] + new Vector3(MathF.Sin(0.05f * round + index), MathF.Cos(0.05f * round + index), 0);
        }

        private static double MsOf(Action action)
        {
            long start = Stopwatch.GetTimestamp();
            action();
            return (Stopwatch.GetTimestamp() - start) * 1000.0 / Stopwatch.Frequency;
        }

        private static void Print(string what, double[] ms)
        {
            double[] sorted = ms.OrderBy(value => value).ToArray();
            TestContext.Out.WriteLine(FormattableString.Invariant($"{what}: median {sorted[sorted.Length / 2]:F3} ms, minimum {sorted[0]:F3} ms"));
        }

        private Vector3 Vector(float min, float max) => new Vector3(Value(min, max), Value(min, max), Value(min, max));

        private float Value(float min, float max) => min + (max - min) * (float)random.NextDouble();
    }
}
