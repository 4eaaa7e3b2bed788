using System;
using System.Collections.Generic;
using System.Linq;
using NUnit.Framework;
using Sweepstake.Samples;
using Sweepstake.Unity;
using UnityEngine;
using UnityEngine.SceneManagement;
using Object = UnityEngine.Object;

namespace Sweepstake.Tests
{
    public sealed class TrackerTest : TrackerStage
    {
        [Test]
        public void PairsBeginAndEndAsCollidersMove()
        {
            BoxCollider a = Tracked(Here);
            BoxCollider b = Tracked(Away);
            Frames(1);
            Assert.That(began, Is.Empty);
            b.transform.position = Here;
            Frames(1);
            Assert.That(began, Is.EqualTo(new[] { ((Collider)a, (Collider)b) }));
            Frames(3);
            Assert.That(began, Has.Count.EqualTo(1), "a pair begins once");
            Assert.That(ended, Is.Empty);
            b.transform.position = Away;
            Frames(1);
            Assert.That(ended, Has.Count.EqualTo(1));
        }

        [Test]
        public void LayersAndTheCollisionMatrixDecide()
        {
            Physics.IgnoreLayerCollision(8, 9, true);
            tracker.RefreshLayers();
            BoxCollider a = Tracked(Here, 8);
            BoxCollider b = Tracked(Here, 9);
            Frames(1);
            Assert.That(began, Is.Empty, "the matrix excludes this pair of layers");
            Physics.IgnoreLayerCollision(8, 9, false);
            tracker.RefreshLayers();
            Frames(1);
            Assert.That(began, Has.Count.EqualTo(1));
            tracker.Layers = 1 << 8;
            Frames(1);
            Assert.That(ended, Has.Count.EqualTo(1), "layer 9 is not tracked any longer");
            tracker.Layers = ~0;
            Frames(1);
            Assert.That(began, Has.Count.EqualTo(2));
            Physics.IgnoreLayerCollision(8, 10, true);
            tracker.RefreshLayers();
            b.gameObject.layer = 10;
            Frames(3);
            Assert.That(ended, Has.Count.EqualTo(2), "the change of the layer is noticed");
            Assert.That(tracker.IsTracked(a) && tracker.IsTracked(b), Is.True);
        }

        [Test]
        public void EachPairOfLayersMeetsAsTheMatrixSays()
        {
            var random = new System.Random(5);
            for (int layer = 0; layer < 32; ++layer)
            {
                for (int other = layer; other < 32; ++other)
                    Physics.IgnoreLayerCollision(layer, other, random.Next(2) == 0);
            }
            tracker.RefreshLayers();
            tracker.StaticLayers = 0;
            var boxes = new List<BoxCollider>();
            for (int layer = 0; layer < 32; ++layer)
            {
                boxes.Add(Tracked(Here, layer));
                boxes.Add(Tracked(Here, layer));
            }
            Frames(1);
            var expected = from a in boxes
                           from b in boxes
                           where boxes.IndexOf(a) < boxes.IndexOf(b) && !Physics.GetIgnoreLayerCollision(a.gameObject.layer, b.gameObject.layer)
                           select ((Collider)a, (Collider)b);
            Assert.That(began, Is.EquivalentTo(expected));
        }

        [Test]
        public void WithoutTheMatrixAllTrackedLayersMeet()
        {
            Physics.IgnoreLayerCollision(8, 9, true);
            Set(tracker, "usesCollisionMatrix", false);
            tracker.RefreshLayers();
            Tracked(Here, 8);
            Tracked(Here, 9);
            Frames(1);
            Assert.That(began, Has.Count.EqualTo(1));
        }

        [Test]
        public void DisabledCollidersAndInactiveObjectsHaveNoPairs([Values] bool isStatic)
        {
            Tracked(Here);
            BoxCollider b = Tracked(Here, 0, isStatic);
            Frames(1);
            b.enabled = false;
            Frames(1);
            Assert.That(ended, Has.Count.EqualTo(1));
            b.enabled = true;
            Frames(1);
            Assert.That(began, Has.Count.EqualTo(2));
            b.gameObject.SetActive(false);
            Frames(1);
            Assert.That(ended, Has.Count.EqualTo(2));
            Assert.That(tracker.Count, Is.EqualTo(2), "they stay tracked");
        }

        [Test]
        public void StaticCollidersThatWereInactiveWhenScannedHavePairsOnceTheyAreActive()
        {
            var walls = Enumerable.Range(0, 200).Select(_ => MakeBox(Here, 0, true)).ToList();
            walls.ForEach(wall => wall.gameObject.SetActive(false));
            tracker.Scan();
            Tracked(Here);
            Frames(1);
            Assert.That(began, Is.Empty);
            walls.ForEach(wall => wall.gameObject.SetActive(true));
            Frames(4);
            Assert.That(began, Has.Count.EqualTo(200));
        }

        [Test]
        public void DestroyedCollidersEndTheirPairsAndAreDropped([Values] bool isStatic)
        {
            BoxCollider a = Tracked(Here);
            BoxCollider b = Tracked(Here, 0, isStatic);
            Frames(1);
            Assert.That(began, Has.Count.EqualTo(1));
            Object.DestroyImmediate(b.gameObject);
            Frames(2);
            Assert.That(tracker.Count, Is.EqualTo(1));
            Assert.That(ended, Has.Count.EqualTo(1));
            Assert.That(ReferenceEquals(ended[0].Item1, b) || ReferenceEquals(ended[0].Item2, b), Is.True, "the event identifies the destroyed collider");
            Assert.That(a == null, Is.False);
            Assert.That(b == null, Is.True);
            Assert.That(Debug.Lines, Is.Empty);
        }

        [Test]
        public void StaticCollidersMeetMovingOnesAndNotOneAnother()
        {
            BoxCollider wall = Tracked(Here, 0, true);
            Tracked(Here, 0, true);
            BoxCollider ball = Tracked(Away);
            Frames(1);
            Assert.That(began, Is.Empty);
            ball.transform.position = Here;
            Frames(1);
            Assert.That(began, Has.Count.EqualTo(2));
            wall.transform.position = Away;
            Frames(1);
            Assert.That(ended, Is.Empty, "a static collider is not read again automatically");
            tracker.Refresh(wall);
            Frames(1);
            Assert.That(ended.Exists(pair => ReferenceEquals(pair.Item1, wall) || ReferenceEquals(pair.Item2, wall)), Is.True);
        }

        [Test]
        public void ManyCollidersThatComeMoveAndGoFindTheOraclesPairs()
        {
            var random = new System.Random(3);
            var boxes = new List<BoxCollider>();
            var open = new HashSet<(Collider, Collider)>();
            for (int frame = 0; frame < 60; ++frame)
            {
                for (int made = 0; made < 5; ++made)
                    boxes.Add(Tracked(Place(random), random.Next(3), random.Next(4) == 0));
                BoxCollider gone = boxes[random.Next(boxes.Count)];
                boxes.Remove(gone);
                if (frame % 2 == 0 || IsStatic(gone))
                    Assert.That(tracker.Unregister(gone), Is.True);
                else
                    Object.DestroyImmediate(gone.gameObject);
                // A box becomes static or moving.
                boxes[random.Next(boxes.Count)].gameObject.layer ^= 16;
                foreach (BoxCollider box in boxes.Where(box => !IsStatic(box)))
                    box.transform.position = Place(random);
                Frames(1);
                Follow(open);
                Assert.That(open.SetEquals(Overlapping(boxes)), Is.True, $"frame {frame}");
            }
            Assert.That(tracker.Count, Is.EqualTo(boxes.Count));
        }

        [Test]
        public void TheScopeSaysWhatIsTrackedByItself()
        {
            BoxCollider below = MakeBox(Here, parent: tracker.transform);
            BoxCollider elsewhere = MakeBox(Here);
            elsewhere.isTrigger = false;
            BoxCollider inactive = MakeBox(Here);
            inactive.gameObject.SetActive(false);
            Set(tracker, "scope", ColliderScope.Registered);
            tracker.Scan();
            Assert.That(tracker.Count, Is.EqualTo(0));
            Set(tracker, "scope", ColliderScope.Children);
            tracker.Scan();
            Assert.That(tracker.IsTracked(below) && !tracker.IsTracked(elsewhere), Is.True);
            Set(tracker, "scope", ColliderScope.LoadedScenes);
            Set(tracker, "findsTriggersOnly", true);
            tracker.Scan();
            Assert.That(tracker.IsTracked(elsewhere), Is.False, "it is not a trigger");
            Set(tracker, "findsTriggersOnly", false);
            tracker.Scan();
            Assert.That(tracker.IsTracked(elsewhere) && tracker.IsTracked(inactive), Is.True);
            Assert.That(tracker.Register(elsewhere), Is.False, "it is already tracked");
            Assert.That(tracker.Unregister(elsewhere) && !tracker.Unregister(elsewhere), Is.True);

            Scene next = SceneManager.Add("next level");
            BoxCollider loaded = MakeBox(Here);
            SceneManager.SayLoaded(next);
            Assert.That(tracker.IsTracked(loaded), Is.True);
        }

        [Test]
        public void AListenerMayDestroyRegisterAndThrow()
        {
            var boxes = Enumerable.Range(0, 6).Select(_ => Tracked(Here)).ToList();
            BoxCollider late = MakeBox(Here);
            tracker.PairBegan += pair =>
            {
                tracker.Register(late);
                Object.DestroyImmediate(pair.A.gameObject);
                throw new InvalidOperationException("a bug of the game");
            };
            Assert.DoesNotThrow(() => Frames(3));
            Assert.That(tracker.IsTracked(late), Is.True);
            Assert.That(Logged("a bug of the game"), Is.Not.Empty);
            Assert.That(boxes.Count(box => box == null), Is.GreaterThan(0));
        }

        [Test]
        public void AListenerThatThrowsKeepsNothingFromTheOthers()
        {
            var told = new List<ColliderPair>();
            tracker.PairBegan += _ => throw new InvalidOperationException("a bug of the game");
            tracker.PairBegan += told.Add;
            Enumerable.Range(0, 4).ToList().ForEach(_ => Tracked(Here));
            Frames(1);
            Assert.That(told.Select(pair => (pair.A, pair.B)), Is.EqualTo(began).And.Exactly(6).Items);
            Assert.That(Logged("a bug of the game"), Has.Exactly(6).Items);
            tracker.PairBegan -= told.Add;
            Tracked(Here);
            Frames(1);
            Assert.That((began.Count, told.Count), Is.EqualTo((10, 6)), "a removed listener is not called");
        }

        [Test]
        public void QueriesFindNoColliderThatIsDestroyed([Values] bool isStatic)
        {
            BoxCollider gone = Tracked(Here, 0, isStatic);
            BoxCollider behind = Tracked(new Vector3(1, 0, 0));
            Frames(1);
            Object.DestroyImmediate(gone.gameObject);
            var found = new List<Collider>();
            tracker.OverlapBox(new Bounds(Here, new Vector3(9, 9, 9)), ~0, found);
            Assert.That(found, Is.EqualTo(new[] { behind }));
            tracker.OverlapSphere(Here, 5, ~0, found);
            Assert.That(found, Is.EqualTo(new[] { behind }));
            var ray = new Ray(new Vector3(-5, 0, 0), new Vector3(1, 0, 0));
            Assert.That(tracker.Raycast(ray, 100, ~0, out Collider hit, out float distance), Is.True);
            Assert.That(hit, Is.SameAs(behind));
            Assert.That(distance, Is.EqualTo(5.5f).Within(1e-4), "what is destroyed does not hide what is behind it");
            Object.DestroyImmediate(behind.gameObject);
            Assert.That(tracker.Raycast(ray, 100, ~0, out hit, out distance), Is.False);
            Assert.That((hit is null, distance), Is.EqualTo((true, 0f)));
            Frames(1);
            Assert.That(tracker.Count, Is.EqualTo(0));
            Assert.That(ended, Has.Count.EqualTo(1), "the end event of their pair is still raised");
        }

        [Test]
        public void QueriesFindWhatIsThereByLayer()
        {
            BoxCollider a = Tracked(Here, 8);
            BoxCollider b = Tracked(Away, 9, true);
            Frames(1);
            var found = new List<Collider>();
            tracker.OverlapBox(new Bounds(Here, new Vector3(1, 1, 1)), ~0, found);
            Assert.That(found, Is.EqualTo(new[] { a }));
            tracker.OverlapSphere(Away, 0.1f, ~0, found);
            Assert.That(found, Is.EqualTo(new[] { b }));
            tracker.OverlapSphere(Away, 0.1f, 1 << 8, found);
            Assert.That(found, Is.Empty);
            var ray = new Ray(new Vector3(-5, 0, 0), new Vector3(1, 0, 0));
            Assert.That(tracker.Raycast(ray, float.PositiveInfinity, ~0, out Collider hit, out float distance), Is.True);
            Assert.That(hit, Is.SameAs(a));
            Assert.That(distance, Is.EqualTo(4.5f).Within(1e-4));
            Assert.That(tracker.Raycast(ray, float.PositiveInfinity, 1 << 25, out hit, out distance), Is.True);
            Assert.That(hit, Is.SameAs(b));
            Assert.That(tracker.Raycast(ray, 1, ~0, out hit, out _), Is.False);
            for (int index = 0; index < 200; ++index)
                Tracked(Here, 8);
            Frames(1);
            tracker.OverlapBox(new Bounds(Here, new Vector3(1, 1, 1)), ~0, found);
            Assert.That(found, Has.Count.EqualTo(201), "the buffer grows");
        }

        [Test]
        public void AFrameAllocatesNothingWhilePairsBeginAndEnd()
        {
            var boxes = Enumerable.Range(0, 100).Select(index => Tracked(new Vector3(index % 10, index / 10, 0), index % 3, index % 7 == 0)).ToArray();
            began.Capacity = ended.Capacity = 1 << 16;
            var found = new List<Collider>(256);
            manager.gameObject.AddComponent<Mover>().Boxes = boxes;
            manager.gameObject.GetComponent<Mover>().Query = () => tracker.OverlapSphere(Here, 3, ~0, found);
            Assert.That(AllocatedBy(200), Is.EqualTo(0));
            Assert.That(began, Is.Not.Empty);
            Assert.That(found, Is.Not.Empty);
        }

        [Test]
        public void OneManagerHasOneSource()
        {
            manager.gameObject.AddComponent<ScenarioPlayer>();
            Assert.That(Logged("another source"), Has.Exactly(1).Items);
            Assert.That(manager.Source, Is.SameAs(tracker));
            tracker.enabled = false;
            Assert.That(manager.Source, Is.Null);
        }

        [Test]
        public void GizmosAreOffAndCapped()
        {
            for (int index = 0; index < 50; ++index)
                Tracked(Here);
            var gizmos = manager.gameObject.AddComponent<PairGizmos>();
            Player.CallAll("OnDrawGizmos");
            Assert.That(gizmos.DrawnCount, Is.EqualTo(0), "off by default");
            gizmos.IsDrawn = true;
            Player.CallAll("OnDrawGizmos");
            Assert.That(gizmos.DrawnCount, Is.EqualTo(0), "before the first search");
            Frames(1);
            Player.CallAll("OnDrawGizmos");
            Assert.That(gizmos.DrawnCount, Is.EqualTo(200), "of 1,225");
        }

        [Test]
        public void GizmosDrawNoPairOfARemovedCollider([Values] bool isRefresh)
        {
            Tracked(Here);
            Tracked(Here);
            tracker.PairBegan += pair => Change(pair.A, isRefresh);
            var gizmos = manager.gameObject.AddComponent<PairGizmos>();
            gizmos.IsDrawn = true;
            Frames(1);
            Assert.DoesNotThrow(() => Player.CallAll("OnDrawGizmos"));
            Assert.That(gizmos.DrawnCount, Is.EqualTo(isRefresh ? 1 : 0));
        }

        [Test]
        public void GizmosDrawNothingOfWhatHasEnded([Values] bool isScenario)
        {
            Tracked(Here);
            Tracked(Here);
            tracker.enabled = !isScenario;
            if (isScenario)
                manager.gameObject.AddComponent<ScenarioPlayer>();
            var gizmos = manager.gameObject.AddComponent<PairGizmos>();
            gizmos.IsDrawn = true;
            Frames(1);
            Player.CallAll("OnDrawGizmos");
            Assert.That(gizmos.DrawnCount, Is.GreaterThan(0));
            SweepstakeManager.Shutdown();
            Assert.DoesNotThrow(() => Player.CallAll("OnDrawGizmos"));
            Assert.That(gizmos.DrawnCount, Is.EqualTo(0));
            manager.enabled = false;
            manager.enabled = true;
            Assert.That(manager.Session, Is.Not.Null);
            Assert.DoesNotThrow(() => Player.CallAll("OnDrawGizmos"), "a session that has searched nothing yet");
        }

        [Test]
        public void WhatComesAndGoesWithoutASearchIsForgotten()
        {
            BoxCollider a = Tracked(Here);
            BoxCollider b = Tracked(Here);
            Frames(1);
            manager.enabled = false;
            Assert.That(tracker.Unregister(a) && tracker.Unregister(b), Is.True);
            for (int index = 0; index < 300; ++index)
            {
                BoxCollider box = Tracked(Here, 0, index % 2 == 0);
                Assert.That(tracker.Unregister(box), Is.True);
                Object.DestroyImmediate(box.gameObject);
            }
            Assert.That((ProxyCount(), ended.Count), Is.EqualTo((0, 0)));
            manager.enabled = true;
            Frames(1);
            Assert.That(ended, Is.EqualTo(new[] { ((Collider)a, (Collider)b) }), "the end of the pair is reported with the next frame");
        }

        [Test]
        public void WhatIsDestroyedWithoutASearchIsForgottenWhenMoreComes()
        {
            BoxCollider a = Tracked(Here);
            BoxCollider b = Tracked(Here);
            Frames(1);
            manager.enabled = false;
            Object.DestroyImmediate(a.gameObject);
            for (int index = 0; index < 3000; ++index)
                Object.DestroyImmediate(Tracked(Away, 0, index % 2 == 0).gameObject);
            Assert.That(new[] { tracker.Count, ProxyCount() }, Is.All.LessThan(130));
            Assert.That(tracker.IsTracked(b), Is.True);
            manager.enabled = true;
            Frames(1);
            Assert.That((tracker.Count, ProxyCount(), ended.Count), Is.EqualTo((1, 1, 1)));
        }

        private int ProxyCount() => tracker.Proxies!.MovingCount + tracker.Proxies.StaticCount;

        private void Change(Collider collider, bool isRefresh)
        {
            if (isRefresh)
                tracker.Refresh(collider);
            else
                tracker.Unregister(collider);
        }

        /// <summary>Adds the pairs of begin events to `open` and removes those of end events, in both orders.</summary>
        private void Follow(HashSet<(Collider, Collider)> open)
        {
            Assert.That(ended.All(pair => open.Remove(pair) && open.Remove((pair.Item2, pair.Item1))), Is.True);
            Assert.That(began.All(pair => open.Add(pair) && open.Add((pair.Item2, pair.Item1))), Is.True);
            ended.Clear();
            began.Clear();
        }

        private static IEnumerable<(Collider, Collider)> Overlapping(List<BoxCollider> boxes) => boxes.SelectMany(a => boxes
            .Where(b => a != b && Overlap(a, b) && !(IsStatic(a) && IsStatic(b))).Select(b => ((Collider)a, (Collider)b)));

        private static bool Overlap(Collider a, Collider b)
        {
            Vector3 apart = a.transform.position - b.transform.position;
            return Math.Abs(apart.x) <= 1 && Math.Abs(apart.y) <= 1 && Math.Abs(apart.z) <= 1;
        }

        /// <summary>A position on a grid of quarter units, where boxes touch exactly.</summary>
        private static Vector3 Place(System.Random random) =>
            new Vector3(random.Next(20) * 0.25f, random.Next(20) * 0.25f, random.Next(20) * 0.25f);

        private sealed class Mover : MonoBehaviour
        {
            private int frame;

            internal BoxCollider[] Boxes { get; set; }
            internal Action Query { get; set; }

            private void Update()
            {
                ++frame;
                for (int index = 0; index < Boxes.Length; ++index)
                    Boxes[index].transform.position = new Vector3(index % 10 + (index + frame) % 5, index / 10, frame % 2);
                Query();
            }
        }
    }
}
