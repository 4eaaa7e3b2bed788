using System.Collections.Generic;
using System.Linq;
using NUnit.Framework;
using Sweepstake.Unity;
using UnityEngine;
using UnityEngine.SceneManagement;
using Object = UnityEngine.Object;

namespace Sweepstake.Tests
{
    /// <summary>Tests which colliders are tracked, which of them form pairs, and when a change takes effect.</summary>
    public sealed class TriggerRulesTest : TrackerStage
    {
        private readonly List<Collider> found = new List<Collider>();

        [Test]
        public void QueriesObeyOnlyTheLayersOfTheCaller()
        {
            for (int layer = 0; layer < 32; ++layer)
            {
                for (int other = 0; other < 32; ++other)
                    Physics.IgnoreLayerCollision(layer, other, true);
            }
            tracker.Layers = ~(1 << 5);
            tracker.StaticLayers = 0;
            var boxes = Enumerable.Range(0, 64).Select(index => Tracked(Here, index % 32)).ToList();
            Frames(1);
            Assert.That(began, Is.Empty, "no layer collides with any");
            var ray = new Ray(new Vector3(-5, 0, 0), new Vector3(1, 0, 0));
            for (int layer = 0; layer < 32; ++layer)
            {
                var expected = new[] { boxes[layer], boxes[layer + 32] };
                tracker.OverlapSphere(Here, 5, 1 << layer, found);
                Assert.That(found, Is.EquivalentTo(expected));
                tracker.OverlapBox(new Bounds(Here, Vector3.one), 1 << layer, found);
                Assert.That(found, Is.EquivalentTo(expected));
                Assert.That(tracker.Raycast(ray, 100, 1 << layer, out Collider hit, out _) && expected.Contains(hit), Is.True);
            }
            tracker.enabled = false;
            tracker.OverlapBox(new Bounds(Here, Vector3.one), ~0, found);
            Assert.That(found, Is.Empty, "a disabled tracker finds nothing");
        }

        [Test]
        public void ChangedLayersHoldAtOnce()
        {
            tracker.Layers = 1 << 8;
            BoxCollider eight = MakeBox(Here, 8), nine = MakeBox(Here, 9);
            tracker.Scan();
            Assert.That(tracker.IsTracked(eight) && !tracker.IsTracked(nine), Is.True);
            tracker.Layers = ~0;
            Assert.That(tracker.IsTracked(nine), Is.True);
            BoxCollider registered = Tracked(Here, 9);
            Frames(1);
            Assert.That(began, Has.Count.EqualTo(3));
            tracker.Layers = 1 << 8;
            Assert.That(tracker.IsTracked(eight) && !tracker.IsTracked(nine), Is.True, "a scan with these layers does not find layer 9");
            Assert.That(tracker.IsTracked(registered), Is.True, "the game has registered it");
            Frames(1);
            Assert.That(Counts, Is.EqualTo((3, 3)));
        }

        [Test]
        public void AFoundColliderThatIsRegisteredStaysTracked()
        {
            BoxCollider box = MakeBox(Here, 9);
            tracker.Scan();
            Assert.That(tracker.Register(box), Is.False);
            tracker.Layers = 1 << 8;
            Assert.That(tracker.IsTracked(box), Is.True);
        }

        [Test]
        public void EditsInTheInspectorHoldWhileTheGamePlays()
        {
            BoxCollider elsewhere = MakeBox(Here);
            BoxCollider below = MakeBox(Here, parent: tracker.transform);
            below.isTrigger = false;
            tracker.Scan();
            Frames(1);
            Assert.That(Counts, Is.EqualTo((1, 0)));
            Edit("scope", ColliderScope.Children);
            Assert.That(tracker.IsTracked(below) && !tracker.IsTracked(elsewhere), Is.True);
            Assert.That(Counts, Is.EqualTo((1, 1)));
            Edit("findsTriggersOnly", true);
            Assert.That(tracker.IsTracked(below), Is.False);
            Edit("scope", ColliderScope.LoadedScenes);
            Assert.That(tracker.IsTracked(elsewhere) && !tracker.IsTracked(below), Is.True);
            Edit("findsTriggersOnly", false);
            Assert.That(Counts, Is.EqualTo((2, 1)));
            Edit("layers", (LayerMask)(1 << 8));
            Assert.That(tracker.Count, Is.EqualTo(0));
            Edit("layers", (LayerMask)~0);
            Assert.That(Counts, Is.EqualTo((3, 2)));
            Physics.IgnoreLayerCollision(0, 0, true);
            Edit("usesCollisionMatrix", true);
            Assert.That(Counts, Is.EqualTo((3, 3)), "an edit reads the matrix again");
            Edit("usesCollisionMatrix", false);
            Assert.That(Counts, Is.EqualTo((4, 3)));
            Edit("staticLayers", (LayerMask)1);
            Assert.That(Counts, Is.EqualTo((4, 4)), "two static colliders form no pair");
        }

        [Test]
        public void ObjectsThatOutliveTheirSceneAreFound()
        {
            BoxCollider lasting = MakeBox(Here);
            Object.DontDestroyOnLoad(lasting.gameObject);
            tracker.Scan();
            Assert.That(tracker.IsTracked(lasting), Is.True);
            Scene next = SceneManager.Add("next level");
            BoxCollider late = MakeBox(Here);
            Object.DontDestroyOnLoad(late.gameObject);
            SceneManager.SayLoaded(next);
            Assert.That(tracker.IsTracked(late), Is.True, "a scene that is loaded may have made it");
            Frames(2);
            Assert.That(Object.Named("Sweepstake"), Is.Empty, "the scan leaves no object behind");
        }

        [Test]
        public void NoPairBeginsWithADestroyedCollider()
        {
            var walls = Enumerable.Range(0, 5000).Select(index => MakeBox(new Vector3(100 + 3 * index, 0, 0), 0, index % 2 == 0)).ToList();
            BoxCollider mover = MakeBox(Here);
            tracker.Scan();
            Frames(2);
            walls.ForEach(wall => Object.DestroyImmediate(wall.gameObject));
            for (int frame = 0; frame < 100; ++frame)
            {
                mover.transform.position = new Vector3(100 + 3 * frame, 0, 0);
                Frames(1);
            }
            Assert.That((began.Count, tracker.Count), Is.EqualTo((0, 1)));
        }

        [Test]
        public void APairEndsAtOnceWhenAColliderIsDestroyed([Values] bool isStatic)
        {
            for (int index = 0; index < 5000; ++index)
                Tracked(new Vector3(100 + 3 * index, 0, 0));
            BoxCollider a = Tracked(Here), b = Tracked(Here, 0, isStatic);
            Frames(1);
            Object.DestroyImmediate(b);
            Frames(1);
            Assert.That(Counts, Is.EqualTo((1, 1)));
            Assert.That(tracker.IsTracked(a) && !tracker.IsTracked(b), Is.True);
        }

        [Test]
        public void AListenerThatDestroysAColliderPreventsItsOtherPairs()
        {
            var boxes = Enumerable.Range(0, 10).Select(_ => Tracked(Here)).ToList();
            int wrong = 0;
            tracker.PairBegan += pair =>
            {
                wrong += pair.A == null || pair.B == null ? 1 : 0;
                Object.DestroyImmediate(boxes[0].gameObject);
            };
            Frames(1);
            Assert.That((wrong, began.Count), Is.EqualTo((0, 45 - 9 + 1)));
            Frames(1);
            Assert.That(ended, Has.Count.EqualTo(1), "only a pair that began ends");
        }

        [Test]
        public void NoPairBeginsWithADisabledCollider([Values] bool isInactive)
        {
            var walls = Enumerable.Range(0, 5000).Select(index => MakeBox(new Vector3(100 + 3 * index, 0, 0), 0, index % 2 == 0)).ToList();
            BoxCollider mover = MakeBox(Here);
            tracker.Scan();
            Frames(2);
            foreach (BoxCollider wall in walls)
            {
                wall.enabled = isInactive;
                wall.gameObject.SetActive(!isInactive);
            }
            for (int frame = 0; frame < 50; ++frame)
            {
                mover.transform.position = new Vector3(100 + 3 * (100 * frame % 5000), 0, 0);
                Frames(1);
            }
            Assert.That(Counts, Is.EqualTo((0, 0)));
            walls[0].enabled = true;
            walls[0].gameObject.SetActive(true);
            tracker.Refresh(walls[0]);
            mover.transform.position = walls[0].transform.position;
            Frames(1);
            Assert.That(Counts, Is.EqualTo((1, 0)), "Refresh reads the state at once");
        }

        [Test]
        public void RefreshKeepsAPairThatLasts([Values] bool isStatic)
        {
            BoxCollider a = Tracked(Here), b = Tracked(Here, 0, isStatic);
            Frames(1);
            tracker.Refresh(b);
            Frames(1);
            Assert.That(Counts, Is.EqualTo((1, 0)));
            b.transform.position = Away;
            tracker.Refresh(b);
            tracker.OverlapSphere(Away, 1, ~0, found);
            Assert.That(found, Is.EqualTo(new[] { b }), "queries use the box at once");
            Frames(1);
            Assert.That(Counts, Is.EqualTo((1, 1)));
            Object.DestroyImmediate(a.gameObject);
            Assert.DoesNotThrow(() => tracker.Refresh(a));
            Assert.That(tracker.IsTracked(a), Is.False);
        }

        [Test]
        public void AColliderBecomesStaticWhereItIsAndMovingAgain()
        {
            BoxCollider a = Tracked(Here), b = Tracked(Away);
            Frames(1);
            b.transform.position = Here;
            b.gameObject.layer = 16;
            Frames(1);
            Assert.That(Counts, Is.EqualTo((1, 0)));
            b.transform.position = Away;
            Frames(2);
            Assert.That(Counts, Is.EqualTo((1, 0)), "a static collider is not read again");
            a.gameObject.layer = 17;
            Frames(1);
            Assert.That(Counts, Is.EqualTo((1, 1)), "two static colliders form no pair");
            a.gameObject.layer = 0;
            b.gameObject.layer = 0;
            Frames(1);
            Assert.That(Counts, Is.EqualTo((1, 1)), "both are where they are drawn");
            b.transform.position = Here;
            Frames(1);
            Assert.That(Counts, Is.EqualTo((2, 1)));
        }

        [Test]
        public void CollidersOfOneObjectFormNoPair()
        {
            BoxCollider a = MakeBox(Here);
            a.gameObject.AddComponent<SphereCollider>();
            MakeBox(Here);
            tracker.Scan();
            Frames(2);
            Assert.That(Counts, Is.EqualTo((2, 0)));
        }

        [Test]
        public void IgnoredCollisionsFormNoPair()
        {
            BoxCollider a = Tracked(Here), b = Tracked(Here), c = Tracked(Here);
            Physics.IgnoreCollision(a, b, true);
            Frames(1);
            Assert.That(Counts, Is.EqualTo((2, 0)));
            Physics.IgnoreCollision(a, c, true);
            Frames(1);
            Assert.That(Counts, Is.EqualTo((2, 1)));
            Physics.IgnoreCollision(a, b, false);
            Frames(1);
            Assert.That(Counts, Is.EqualTo((3, 1)));
            tracker.OverlapSphere(Here, 1, ~0, found);
            Assert.That(found, Has.Count.EqualTo(3), "queries do not obey it");
        }

        [Test]
        public void RefreshReadsIgnoredCollisionsAtOnceAmongManyPairs()
        {
            var many = Enumerable.Range(0, 100).Select(_ => Tracked(Here)).ToList();
            Frames(1);
            Assert.That(began, Has.Count.EqualTo(4950));
            Physics.IgnoreCollision(many[98], many[99], true);
            tracker.Refresh(many[99]);
            Frames(1);
            Assert.That(ended, Is.EquivalentTo(new[] { began.Find(pair => pair.Item1 == many[98] && pair.Item2 == many[99]) }));
            Physics.IgnoreCollision(many[0], many[1], true);
            Frames(5);
            Assert.That(ended, Has.Count.EqualTo(2), "the pairs take turns");
        }

        [Test]
        public void PairsEndAndBeginAgainAroundAShutdown()
        {
            Tracked(Here);
            Tracked(Here);
            Frames(1);
            SweepstakeManager.Shutdown();
            Assert.That(tracker.Proxies, Is.Null);
            tracker.OverlapSphere(Here, 1, ~0, found);
            Assert.That(found, Is.Empty);
            BoxCollider late = Tracked(Here);
            Assert.That(tracker.Unregister(Tracked(Here)), Is.True);
            manager.enabled = false;
            manager.enabled = true;
            Frames(2);
            Assert.That((manager.State, manager.Problem), Is.EqualTo((SweepstakeState.Embedded, "")));
            Assert.That(Counts, Is.EqualTo((4, 1)));
            tracker.OverlapSphere(Here, 1, ~0, found);
            Assert.That(found, Has.Count.EqualTo(3).And.Contains(late));
        }

        [Test]
        public void AHandleLeadsToItsCollider()
        {
            BoxCollider a = Tracked(Here), b = Tracked(Away, 0, true);
            Frames(1);
            var hits = new QueryHit[1];
            tracker.Proxies!.PrepareQueries();
            tracker.Proxies.CastRays(new[] { new RayQuery { OriginX = 20, DirectionX = -1, MaxDistance = 100 } }, ProxyFilter.All, hits);
            Assert.That(tracker.ColliderOf(hits[0].Proxy), Is.SameAs(b));
            Assert.That(tracker.ColliderOf(tracker.HandleOf(a)), Is.SameAs(a));
            Assert.That(tracker.ColliderOf(ProxyHandle.None), Is.Null);
            ProxyHandle gone = tracker.HandleOf(a);
            Object.DestroyImmediate(a.gameObject);
            Assert.That(tracker.ColliderOf(gone) is null, Is.True);
            Assert.That(tracker.Unregister(b), Is.True);
            Assert.That(tracker.HandleOf(b).IsNone, Is.True);
            Assert.That(tracker.ColliderOf(hits[0].Proxy), Is.Null, "it is not tracked any longer");
        }

        [Test]
        public void AColliderListsItsPairs()
        {
            var list = new List<ColliderPair> { default };
            BoxCollider a = Tracked(Here), b = Tracked(Here), c = Tracked(Here), d = Tracked(Here, 0, true);
            tracker.CopyPairs(a, list);
            Assert.That(list, Is.Empty, "nothing was searched");
            Physics.IgnoreCollision(a, b, true);
            Frames(1);
            tracker.CopyPairs(a, list);
            Assert.That(list.Select(pair => (pair.A, pair.B)), Is.EquivalentTo(new[] { (a, c), ((Collider)a, (Collider)d) }));
            c.transform.position = Away;
            Frames(1);
            tracker.CopyPairs(a, list);
            Assert.That(list.Select(pair => pair.B), Is.EqualTo(new[] { d }));
            tracker.Unregister(d);
            tracker.CopyPairs(a, list);
            Assert.That(list, Is.Empty, "a removal ends the pair at once");
        }

        /// <summary>Changes a field as the inspector does, and runs a frame.</summary>
        private void Edit(string field, object value)
        {
            Set(tracker, field, value);
            Player.CallAll("OnValidate");
            Frames(1);
        }
    }
}
