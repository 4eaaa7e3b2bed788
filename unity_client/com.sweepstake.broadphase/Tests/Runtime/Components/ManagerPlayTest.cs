#nullable disable
using System.Collections;
using System.Collections.Generic;
using System.Linq;
using NUnit.Framework;
using Sweepstake.Unity;
using UnityEngine;
using UnityEngine.TestTools;

namespace Sweepstake.Tests
{
    /// <summary>Tests of the manager in play mode. They also run on .NET, where a stub of Unity's test framework plays the frames.</summary>
    public sealed class ManagerPlayTest
    {
        private GameObject made;

        [SetUp]
        public void Make() => made = new GameObject("manager");

        [TearDown]
        public void DestroyAll()
        {
            Object.DestroyImmediate(made);
            Assert.That(SweepstakeLibrary.LiveCount(), Is.EqualTo(0), "no native object is left");
        }

        [UnityTest]
        public IEnumerator OneComponentWorksWithDefaultsAndWithoutADaemon()
        {
            var manager = made.AddComponent<SweepstakeManager>();
            Assert.That(manager.State, Is.EqualTo(SweepstakeState.Stopped).Or.EqualTo(SweepstakeState.Embedded));
            manager.Source = new MovingBoxes(200);
            yield return null;
            Assert.That(manager.ActiveBackend, Is.EqualTo("KDTree"), "not brute force, which is the first");
            for (int frame = 0; frame < 4; ++frame)
                yield return null;
            Assert.That(manager.State, Is.EqualTo(SweepstakeState.Embedded));
            Assert.That(manager.Mode, Is.EqualTo(SessionMode.Ai));
            Assert.That(manager.Backends, Is.EqualTo(SweepstakeLibrary.Backends));
            Assert.That(manager.LastSample.ObjectCount, Is.EqualTo(200));
            Assert.That(manager.Connection, Is.Null);
            Assert.That(manager.Decider, Is.Not.Null);
        }

        [UnityTest]
        public IEnumerator WithoutASourceNoFrameIsPlayed()
        {
            var manager = made.AddComponent<SweepstakeManager>();
            for (int frame = 0; frame < 5; ++frame)
                yield return null;
            Assert.That((manager.LastSample.FrameIndex, manager.LastSample.ObjectCount), Is.EqualTo((0ul, 0u)));
        }

        [UnityTest]
        public IEnumerator EachBackendIsSelectableWhileTheGamePlaysAndFindsTheSamePairs()
        {
            var manager = made.AddComponent<SweepstakeManager>();
            manager.Source = new MovingBoxes(300);
            yield return null;
            manager.Mode = SessionMode.Manual;
            manager.SelectBackend("BruteForce");
            yield return null;
            var boxes = new List<Aabb>();
            var changes = new List<string>();
            manager.BackendChanged += changes.Add;
            foreach (string backend in manager.Backends.Reverse())
            {
                manager.SelectBackend(backend);
                yield return null;
                yield return null;
                Assert.That(manager.ActiveBackend, Is.EqualTo(backend));
                manager.Source.CopyBoxes(boxes);
                Assert.That(Oracle.Sorted(manager.Session.Pairs), Is.EqualTo(Oracle.Pairs(boxes.ToArray())).And.Not.Empty);
            }
            Assert.That(changes, Is.EqualTo(manager.Backends.Reverse()));
            Assert.That(Assert.Throws<SweepstakeException>(() => manager.SelectBackend("Quadtree")).Message, Does.Contain("SAP"));
        }

        [UnityTest]
        public IEnumerator ADisabledObjectStopsAndAnEnabledOnePlaysAgain()
        {
            var manager = made.AddComponent<SweepstakeManager>();
            manager.Source = new MovingBoxes(50);
            yield return null;
            made.SetActive(false);
            yield return null;
            Assert.That((manager.State, manager.Session), Is.EqualTo((SweepstakeState.Stopped, (BroadPhaseSession)null)));
            made.SetActive(true);
            yield return null;
            yield return null;
            Assert.That(manager.LastSample.ObjectCount, Is.EqualTo(50));
        }

        /// <summary>Unit cubes that move back and forth in a cube of 24 units. They need no native object.</summary>
        private sealed class MovingBoxes : IBroadPhaseSource
        {
            private const float Reach = 12;

            private readonly Aabb[] boxes;
            private int frame;

            internal MovingBoxes(int count)
            {
                boxes = new Aabb[count];
            }

            public void Search(BroadPhaseSession session)
            {
                var random = new System.Random(1);
                float shift = Mathf.Abs(++frame % 40 - 20) / 20f;
                for (int index = 0; index < boxes.Length; ++index)
                    boxes[index] = Aabb.Around(At(random) + shift * At(random), At(random), At(random), 1, 1, 1);
                session.FindPairs(boxes);
            }

            public void Report()
            {
            }

            public bool TryGetPair(int index, out Aabb a, out Aabb b)
            {
                a = b = default;
                return false;
            }

            public void CopyBoxes(List<Aabb> copy)
            {
                copy.Clear();
                copy.AddRange(boxes);
            }

            private static float At(System.Random random) => Reach * (float)(2 * random.NextDouble() - 1);
        }
    }
}
