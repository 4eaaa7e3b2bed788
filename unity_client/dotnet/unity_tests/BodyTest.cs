using System.Collections.Generic;
using System.Linq;
using NUnit.Framework;
using Sweepstake.Unity;
using UnityEngine;
using Object = UnityEngine.Object;

namespace Sweepstake.Tests
{
    public sealed class BodyTest : TrackerStage
    {
        private readonly List<string> log = new List<string>();
        private readonly List<ColliderPair> list = new List<ColliderPair>();

        [SetUp]
        public void ClearLog() => log.Clear();

        [Test]
        public void ABodyEntersStaysAndExits()
        {
            SweepstakeBody a = MakeBody("a", Here), b = MakeBody("b", Away);
            Frames(1);
            Assert.That(log, Is.Empty);
            b.transform.position = Here;
            Frames(1);
            Assert.That(Taken(), Is.EqualTo(new[] { "a enters b", "b enters a" }));
            Frames(2);
            Assert.That(Taken(), Is.EqualTo(new[] { "a stays b", "b stays a", "a stays b", "b stays a" }));
            a.CopyPairs(list);
            Assert.That(list.Select(pair => (pair.A, pair.B)), Is.EqualTo(new[] { (a.Colliders[0], b.Colliders[0]) }));
            b.transform.position = Away;
            Frames(1);
            Assert.That(Taken(), Is.EqualTo(new[] { "a exits b", "b exits a" }));
            a.CopyPairs(list);
            Assert.That(list, Is.Empty);
        }

        [Test]
        public void ABodyIsOneObjectWithTheObjectsBelowIt()
        {
            SweepstakeBody a = MakeBody("a", Here);
            BoxCollider arm = MakeBox(Here, parent: a.transform);
            arm.gameObject.name = "arm";
            a.Refresh();
            SweepstakeBody rider = MakeBody("rider", Away, a.transform);
            MakeBox(Here, parent: rider.transform).gameObject.name = "saddle";
            rider.Refresh();
            Assert.That((a.Colliders.Count, rider.Colliders.Count, tracker.Count), Is.EqualTo((2, 2, 4)));
            Frames(1);
            Assert.That(Taken(), Is.EquivalentTo(new[] { "a enters saddle", "rider enters a", "a enters saddle", "rider enters arm" }));
            Assert.That(began, Has.Count.EqualTo(2), "colliders of one body form no pair");
            Frames(1);
            Taken();
            Object.DestroyImmediate(arm.gameObject);
            a.Refresh();
            Frames(1);
            Assert.That(Taken(), Is.EquivalentTo(new[] { "a exits saddle", "rider exits ", "a stays saddle", "rider stays a" }));
            Assert.That(a.Colliders, Has.Count.EqualTo(1));
        }

        [Test]
        public void AnObjectThatLeavesItsBodyIsNotTrackedAnyLonger()
        {
            SweepstakeBody a = MakeBody("a", Here);
            BoxCollider arm = MakeBox(Here, parent: a.transform);
            a.Refresh();
            Assert.That(tracker.IsTracked(arm), Is.True);
            arm.transform.SetParent(null, false);
            a.Refresh();
            Assert.That((tracker.IsTracked(arm), tracker.Count), Is.EqualTo((false, 1)));
        }

        [Test]
        public void ADisabledBodyIsNotTracked()
        {
            SweepstakeBody a = MakeBody("a", Here), b = MakeBody("b", Here);
            Frames(1);
            Taken();
            b.enabled = false;
            Assert.That(tracker.Count, Is.EqualTo(1));
            tracker.Scan();
            Assert.That(tracker.Count, Is.EqualTo(1), "a scan leaves colliders to their body");
            Frames(1);
            Assert.That(Taken(), Is.EqualTo(new[] { "a exits b", "b exits a" }));
            b.enabled = true;
            Frames(1);
            Assert.That(Taken(), Is.EquivalentTo(new[] { "a enters b", "b enters a" }));
            Object.DestroyImmediate(b.gameObject);
            Frames(1);
            Assert.That(Taken(), Is.EqualTo(new[] { "a exits ", "b exits a" }));
            Assert.That((tracker.Count, Debug.Lines.Count), Is.EqualTo((1, 0)));
        }

        [Test]
        public void ABodyThatIsAddedToAFoundColliderHasItsEvents()
        {
            BoxCollider box = MakeBox(Here);
            tracker.Scan();
            MakeBody("a", Here);
            Frames(1);
            Assert.That(Taken(), Is.EqualTo(new[] { "a enters box" }));
            Listen(box.gameObject.AddComponent<SweepstakeBody>());
            Frames(1);
            Assert.That(Taken(), Is.EquivalentTo(new[] { "a exits box", "a enters box", "box enters a" }));
        }

        [Test]
        public void ABodyFollowsItsTracker()
        {
            SweepstakeBody a = MakeBody("a", Here);
            Assert.That(a.Tracker, Is.SameAs(tracker), "the first tracker");
            var other = MakeManager().gameObject.AddComponent<ColliderTracker>();
            Set(other, "scope", ColliderScope.Registered);
            SweepstakeBody b = MakeBody("b", Here);
            b.Tracker = other;
            Assert.That((tracker.Count, other.Count), Is.EqualTo((1, 1)));
            Frames(1);
            Assert.That(Taken(), Is.Empty);
            Set(b, "tracker", tracker);
            Player.CallAll("OnValidate");
            Frames(1);
            Assert.That(Taken(), Is.EquivalentTo(new[] { "a enters b", "b enters a" }));
            tracker.enabled = false;
            Assert.That(a.Tracker, Is.SameAs(other));
            Assert.That(b.Tracker, Is.Null, "its own tracker is disabled");
            a.CopyPairs(list);
            Assert.That(list, Is.Empty);
            tracker.enabled = true;
            Assert.That(b.Tracker, Is.SameAs(tracker));
            other.enabled = false;
            Assert.That(a.Tracker, Is.SameAs(tracker));
            Frames(2);
            Assert.That(Taken(), Is.EquivalentTo(new[] { "a enters b", "b enters a", "a stays b", "b stays a" }));
        }

        [Test]
        public void ABodyWaitsForATracker()
        {
            tracker.enabled = false;
            SweepstakeBody a = MakeBody("a", Here);
            MakeBody("b", Here);
            Assert.That(a.Tracker, Is.Null);
            Assert.DoesNotThrow(a.Refresh);
            tracker.enabled = true;
            Frames(1);
            Assert.That(Taken(), Is.EquivalentTo(new[] { "a enters b", "b enters a" }));
        }

        [Test]
        public void AListenerMayDestroyTheOtherObject()
        {
            SweepstakeBody a = MakeBody("a", Here), b = MakeBody("b", Here);
            MakeBody("c", Here);
            a.TriggerEnter += pair => Object.DestroyImmediate(pair.B.gameObject);
            Frames(1);
            Assert.That(Taken(), Has.Exactly(2).StartsWith("a enters").And.None.StartsWith("b enters").And.None.StartsWith("c enters"));
            Frames(1);
            Assert.That(b == null, Is.True);
            Assert.That(Taken(), Has.Exactly(2).EqualTo("a exits "));
            Assert.That(tracker.Count, Is.EqualTo(1));
        }

        [Test]
        public void AFrameWithBodiesAllocatesNothing()
        {
            var bodies = Enumerable.Range(0, 100).Select(index => MakeBox(new Vector3(index % 10, index / 10, 0)).gameObject.AddComponent<SweepstakeBody>()).ToArray();
            int calls = 0;
            foreach (SweepstakeBody body in bodies)
            {
                body.TriggerEnter += _ => ++calls;
                body.TriggerStay += _ => ++calls;
                body.TriggerExit += _ => ++calls;
            }
            began.Capacity = ended.Capacity = 1 << 16;
            list.Capacity = 256;
            manager.gameObject.AddComponent<Mover>().Move = frame =>
            {
                for (int index = 0; index < bodies.Length; ++index)
                    bodies[index].transform.position = new Vector3(index % 10 + (index + frame) % 5, index / 10, frame % 2);
                bodies[frame % 100].CopyPairs(list);
            };
            Assert.That(AllocatedBy(200), Is.EqualTo(0));
            Assert.That((calls > 0, began.Count > 0, ended.Count > 0), Is.EqualTo((true, true, true)));
        }

        private SweepstakeBody MakeBody(string name, Vector3 position, Transform parent = null)
        {
            BoxCollider box = MakeBox(position, parent: parent);
            box.gameObject.name = name;
            var body = box.gameObject.AddComponent<SweepstakeBody>();
            Listen(body);
            return body;
        }

        private void Listen(SweepstakeBody body)
        {
            string name = body.gameObject.name;
            body.TriggerEnter += pair => log.Add($"{name} enters {NameOf(pair.B)}");
            body.TriggerStay += pair => log.Add($"{name} stays {NameOf(pair.B)}");
            body.TriggerExit += pair => log.Add($"{name} exits {NameOf(pair.B)}");
        }

        /// <summary>The name of a collider's object; "" if it was destroyed.</summary>
        private static string NameOf(Collider collider) => collider == null ? "" : collider.gameObject.name;

        private string[] Taken()
        {
            string[] taken = log.ToArray();
            log.Clear();
            return taken;
        }

        private sealed class Mover : MonoBehaviour
        {
            private int frame;

            internal System.Action<int> Move { get; set; }

            private void Update() => Move(++frame);
        }
    }
}
