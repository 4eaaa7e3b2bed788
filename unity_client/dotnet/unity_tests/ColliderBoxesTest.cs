using System;
using System.Collections.Generic;
using System.Linq;
using System.Reflection;
using System.Runtime.CompilerServices;
using NUnit.Framework;
using Sweepstake.Unity;
using Unity.Collections;
using UnityEngine;

namespace Sweepstake.Tests
{
    /// <summary>Tests the boxes that the job computes from shapes and transforms, and the boxes that games pass in native arrays.</summary>
    public sealed class ColliderBoxesTest : TrackerStage
    {
        private const float Tolerance = 1e-4f;
        private static readonly System.Random Random = new System.Random(7);

        [Test]
        public void ARotatedAndScaledBoxIsEnclosedTightly()
        {
            BoxCollider box = MakeBox(Here);
            Repeat(() =>
            {
                Place(box);
                box.center = Vector(2);
                box.size = new Vector3(Positive(), Positive(), Positive());
                AssertBox(box, Points(Corners().Select(c => box.center + 0.5f * new Vector3(c.x * box.size.x, c.y * box.size.y, c.z * box.size.z)), box, 0));
            });
        }

        [Test]
        public void AMeshIsEnclosedByItsBounds()
        {
            var mesh = MakeBox(Here).gameObject.AddComponent<MeshCollider>();
            tracker.Register(mesh);
            Frames(1);
            AssertNoBox(mesh);
            mesh.sharedMesh = new Mesh { bounds = new Bounds(new Vector3(1, 2, 3), new Vector3(2, 4, 6)) };
            Repeat(() =>
            {
                Place(mesh);
                AssertBox(mesh, Points(Corners().Select(c => new Vector3(1 + c.x, 2 + 2 * c.y, 3 + 3 * c.z)), mesh, 0));
            });
        }

        [Test]
        public void ASphereScalesWithTheLargestScale()
        {
            var sphere = MakeBox(Here).gameObject.AddComponent<SphereCollider>();
            Repeat(() =>
            {
                Place(sphere);
                sphere.center = Vector(2);
                sphere.radius = Positive();
                AssertBox(sphere, Points(new[] { sphere.center }, sphere, sphere.radius * Scales(sphere).Max()));
            });
        }

        [Test]
        public void ACapsuleIsTwoBallsAndWhatIsBetween([Values(0, 1, 2)] int direction)
        {
            var capsule = MakeBox(Here).gameObject.AddComponent<CapsuleCollider>();
            capsule.direction = direction;
            Repeat(() =>
            {
                Place(capsule);
                (capsule.center, capsule.radius, capsule.height) = (Vector(2), Positive(), 3 * Positive());
                AssertBox(capsule, CapsulePoints(capsule, capsule.center, capsule.radius, capsule.height, direction));
            });
        }

        [Test]
        public void ACharacterIsACapsule()
        {
            var character = MakeBox(Here).gameObject.AddComponent<CharacterController>();
            Repeat(() =>
            {
                Place(character);
                (character.center, character.radius, character.height) = (Vector(2), Positive(), 3 * Positive());
                AssertBox(character, CapsulePoints(character, character.center, character.radius, character.height, 1));
            });
        }

        [Test]
        public void AnUnknownColliderHasTheBoxOfPhysX()
        {
            Collider other = MakeBox(Here).gameObject.AddComponent<Collider>();
            other.transform.position = Away;
            Assert.That(tracker.Register(other), Is.True);
            other.transform.position = new Vector3(0, 5, 0);
            Frames(1);
            AssertBox(other, Corners().Select(c => new Vector3(0, 5, 0) + 0.5f * c));
            other.enabled = false;
            Frames(1);
            AssertNoBox(other);
            other.enabled = true;
            Frames(1);
            AssertBox(other, Corners().Select(c => new Vector3(0, 5, 0) + 0.5f * c));
        }

        [Test]
        public void AFrameNeitherSyncsTransformsNorReadsBounds()
        {
            var types = new[] { typeof(BoxCollider), typeof(SphereCollider), typeof(CapsuleCollider), typeof(CharacterController), typeof(Collider) };
            var made = types.Select(type => (Collider)new GameObject(type.Name).AddComponent(type)).ToList();
            made.ForEach(collider => tracker.Register(collider));
            made.Add(Tracked(Here, 0, true));
            Frames(1);
            int before = Physics.SlowCallCount;
            for (int frame = 0; frame < 10; ++frame)
            {
                made.ForEach(collider => collider.transform.position = new Vector3(frame % 2, 0, 0));
                Frames(1);
            }
            Assert.That(Physics.SlowCallCount, Is.EqualTo(before));
            Assert.That(began, Is.Not.Empty);
        }

        [Test]
        public void BurstCanCompileTheJobs()
        {
            Assert.That(RuntimeHelpers.IsReferenceOrContainsReferences<ColliderShape>(), Is.False);
            Type[] jobs = { typeof(ColliderBoxesJob), typeof(NativeBoxes).GetNestedType("ToAabbsJob", BindingFlags.NonPublic) };
            foreach (FieldInfo field in jobs.SelectMany(job => job.GetFields(BindingFlags.Instance | BindingFlags.NonPublic | BindingFlags.Public)))
                Assert.That(field.FieldType.GetGenericTypeDefinition(), Is.EqualTo(typeof(NativeArray<>)), field.Name);
        }

        [Test]
        public void NativeArraysOfBoundsAndOfBoxesGiveTheOraclesPairs()
        {
            const int Count = 300;
            using var bounds = new NativeArray<Bounds>(Count, Allocator.Persistent);
            using var boxes = new NativeArray<Aabb>(Count, Allocator.Persistent);
            using var few = new NativeArray<Aabb>(1, Allocator.Persistent);
            using var session = new BroadPhaseSession();
            var expected = new Aabb[Count];
            Span<Bounds> filled = bounds.AsSpan();
            for (int index = 0; index < Count; ++index)
            {
                (Vector3 center, Vector3 half) = (Vector(4), 0.5f * new Vector3(Positive(), Positive(), Positive()));
                filled[index] = new Bounds(center, 2 * half);
                expected[index] = new Aabb(center.x - half.x, center.y - half.y, center.z - half.z, center.x + half.x, center.y + half.y, center.z + half.z);
            }
            session.BeginFrame();
            session.FindPairs(bounds, boxes);
            Assert.That(session.Pairs.ToArray(), Is.EquivalentTo(Oracle.Pairs(expected)).And.Not.Empty);
            session.FindPairs(boxes);
            Assert.That(session.Pairs.ToArray(), Is.EquivalentTo(Oracle.Pairs(expected)));
            session.EndFrame(1);
            Assert.Throws<ArgumentException>(() => session.FindPairs(bounds, few));
        }

        private static void Repeat(Action once)
        {
            for (int round = 0; round < 50; ++round)
                once();
        }

        /// <summary>Gives a collider's object a random position, rotation and scale.</summary>
        private static void Place(Collider collider)
        {
            collider.transform.position = Vector(10);
            (double x, double y, double z, double w) = (Signed(), Signed(), Signed(), Signed());
            double length = Math.Sqrt(x * x + y * y + z * z + w * w);
            collider.transform.rotation = new Quaternion((float)(x / length), (float)(y / length), (float)(z / length), (float)(w / length));
            collider.transform.localScale = new Vector3(Positive(), Positive(), Positive());
        }

        /// <summary>Checks the box after a frame: the smallest one that contains these points.</summary>
        private void AssertBox(Collider collider, IEnumerable<Vector3> points)
        {
            tracker.Register(collider);
            Frames(1);
            Aabb box = tracker.Proxies!.Get(tracker.HandleOf(collider), out _);
            Vector3[] all = points.ToArray();
            Assert.That(box.MinX, Is.EqualTo(all.Min(point => point.x)).Within(Tolerance));
            Assert.That(box.MinY, Is.EqualTo(all.Min(point => point.y)).Within(Tolerance));
            Assert.That(box.MinZ, Is.EqualTo(all.Min(point => point.z)).Within(Tolerance));
            Assert.That(box.MaxX, Is.EqualTo(all.Max(point => point.x)).Within(Tolerance));
            Assert.That(box.MaxY, Is.EqualTo(all.Max(point => point.y)).Within(Tolerance));
            Assert.That(box.MaxZ, Is.EqualTo(all.Max(point => point.z)).Within(Tolerance));
        }

        private void AssertNoBox(Collider collider) => Assert.That(tracker.Proxies!.Get(tracker.HandleOf(collider), out _).IsValid, Is.False);

        /// <summary>The extremes of balls with a radius in the world around local points.</summary>
        private static IEnumerable<Vector3> Points(IEnumerable<Vector3> local, Collider collider, float radius) => local.SelectMany(point =>
        {
            Vector3 world = ToWorld(collider.transform, point);
            return new[] { world + radius * Vector3.one, world + -radius * Vector3.one };
        });

        /// <summary>The height scales along the axis, the radius with the larger of the other two scales; the height is at least a ball.</summary>
        private static IEnumerable<Vector3> CapsulePoints(Collider collider, Vector3 center, float radius, float height, int direction)
        {
            float[] scales = Scales(collider);
            float along = scales[direction];
            float ball = radius * scales.Where((_, axis) => axis != direction).Max();
            float segment = Math.Max(0, 0.5f * height * along - ball) / along;
            var axisVector = new Vector3(direction == 0 ? segment : 0, direction == 1 ? segment : 0, direction == 2 ? segment : 0);
            return Points(new[] { center + axisVector, center - axisVector }, collider, ball);
        }

        private static float[] Scales(Collider collider)
        {
            Vector3 scale = collider.transform.localScale;
            return new[] { scale.x, scale.y, scale.z };
        }

        /// <summary>Scales, rotates and moves a point: v + 2 q × (q × v + w v) rotates v.</summary>
        private static Vector3 ToWorld(Transform transform, Vector3 local)
        {
            var v = new Vector3(local.x * transform.localScale.x, local.y * transform.localScale.y, local.z * transform.localScale.z);
            Quaternion q = transform.rotation;
            var axis = new Vector3(q.x, q.y, q.z);
            return transform.position + v + 2 * Cross(axis, Cross(axis, v) + q.w * v);
        }

        private static Vector3 Cross(Vector3 a, Vector3 b) => new Vector3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);

        private static IEnumerable<Vector3> Corners() =>
            Enumerable.Range(0, 8).Select(bits => new Vector3((bits & 1) * 2 - 1, (bits >> 1 & 1) * 2 - 1, (bits >> 2) * 2 - 1));

        private static Vector3 Vector(float reach) => reach * new Vector3(Signed(), Signed(), Signed());

        private static float Signed() => (float)(2 * Random.NextDouble() - 1);

        private static float Positive() => 0.2f + (float)Random.NextDouble();
    }
}
