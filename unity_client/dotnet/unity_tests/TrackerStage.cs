using System.Collections.Generic;
using NUnit.Framework;
using Sweepstake.Unity;
using UnityEngine;

namespace Sweepstake.Tests
{
    /// <summary>Makes a manager with a tracker before each test, and collects its events.</summary>
    public abstract class TrackerStage : Stage
    {
        protected static readonly Vector3 Here = Vector3.zero;
        protected static readonly Vector3 Away = new Vector3(10, 0, 0);

        protected readonly List<(Collider, Collider)> began = new List<(Collider, Collider)>();
        protected readonly List<(Collider, Collider)> ended = new List<(Collider, Collider)>();
        protected SweepstakeManager manager;
        protected ColliderTracker tracker;

        [SetUp]
        public void MakeTracker()
        {
            began.Clear();
            ended.Clear();
            manager = MakeManager();
            tracker = manager.gameObject.AddComponent<ColliderTracker>();
            tracker.StaticLayers = StaticLayers;
            tracker.PairBegan += pair => began.Add((pair.A, pair.B));
            tracker.PairEnded += pair => ended.Add((pair.A, pair.B));
        }

        [TearDown]
        public void ResetCollisionMatrix()
        {
            for (int layer = 0; layer < 32; ++layer)
            {
                for (int other = 0; other < 32; ++other)
                    Physics.IgnoreLayerCollision(layer, other, false);
            }
        }

        protected BoxCollider Tracked(Vector3 position, int layer = 0, bool isStatic = false)
        {
            BoxCollider box = MakeBox(position, layer, isStatic);
            Assert.That(tracker.Register(box), Is.True);
            return box;
        }

        protected (int Began, int Ended) Counts => (began.Count, ended.Count);
    }
}
