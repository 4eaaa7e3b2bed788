#nullable enable
using Unity.Collections;
using UnityEngine;
using UnityEngine.Jobs;
#if SWEEPSTAKE_BURST
using Unity.Burst;
#endif

namespace Sweepstake.Unity
{
    /// <summary>
    /// A collider's shape in the coordinates of its transform. It contains only numbers, so that a job that Burst compiles can use it. The
    /// default value is the shape of a collider that is disabled or inactive: it has no box.
    /// </summary>
    internal struct ColliderShape
    {
        private enum Kind
        {
            None,
            Box,
            Sphere,
            Capsule,
            /// <summary>A box that neither rotates nor scales with the transform.</summary>
            Upright,
        }

        private Kind kind;
        /// <summary>The axis of a capsule: 0 for x, 1 for y, 2 for z.</summary>
        private int axis;
        private float radius;
        private Vector3 center;
        /// <summary>For a capsule, half of its height in x.</summary>
        private Vector3 halfSize;

        internal static Aabb NoBox => new Aabb(1, 1, 1, -1, -1, -1);
        internal readonly bool HasBox => kind != Kind.None;

        /// <summary>
        /// Reads the shape on the main thread. `former` is the shape that was read before: the box of another collider type
        /// comes from PhysX, and is read only if `former` has no box.
        /// </summary>
        internal static ColliderShape Of(Collider collider, in ColliderShape former)
        {
            if (!collider.enabled || !collider.gameObject.activeInHierarchy)
                return default;
            return collider switch
            {
                BoxCollider box => new ColliderShape { kind = Kind.Box, center = box.center, halfSize = 0.5f * box.size },
                SphereCollider sphere => new ColliderShape { kind = Kind.Sphere, center = sphere.center, radius = sphere.radius },
                CapsuleCollider capsule => OfCapsule(capsule.center, capsule.radius, capsule.height, capsule.direction),
                CharacterController character => OfCapsule(character.center, character.radius, character.height, 1),
                MeshCollider mesh => mesh.sharedMesh == null ? default : OfBounds(mesh.sharedMesh.bounds),
                _ => former.kind == Kind.Upright ? former : OfPhysX(collider),
            };
        }

        internal readonly bool Equals(in ColliderShape other) =>
            kind == other.kind && axis == other.axis && radius == other.radius && Same(center, other.center) && Same(halfSize, other.halfSize);

        /// <summary>The smallest box in the world that contains the shape of a transform with this matrix.</summary>
        internal readonly Aabb BoxOf(in Matrix4x4 toWorld)
        {
            if (kind == Kind.None)
                return NoBox;
            if (kind == Kind.Upright)
                return Around(toWorld.m03 + center.x, toWorld.m13 + center.y, toWorld.m23 + center.z, halfSize);
            float x = toWorld.m00 * center.x + toWorld.m01 * center.y + toWorld.m02 * center.z + toWorld.m03;
            float y = toWorld.m10 * center.x + toWorld.m11 * center.y + toWorld.m12 * center.z + toWorld.m13;
            float z = toWorld.m20 * center.x + toWorld.m21 * center.y + toWorld.m22 * center.z + toWorld.m23;
            return Around(x, y, z, HalfSizeOf(toWorld));
        }

        private readonly Vector3 HalfSizeOf(in Matrix4x4 toWorld)
        {
            if (kind == Kind.Box)
            {
                return new Vector3(
                    Extent(toWorld.m00, toWorld.m01, toWorld.m02), Extent(toWorld.m10, toWorld.m11, toWorld.m12), Extent(toWorld.m20, toWorld.m21, toWorld.m22));
            }
            // PhysX scales the radius of a sphere by the largest scale of the three axes, and that of a capsule by the two across its axis.
            var x = new Vector3(toWorld.m00, toWorld.m10, toWorld.m20);
            var y = new Vector3(toWorld.m01, toWorld.m11, toWorld.m21);
            var z = new Vector3(toWorld.m02, toWorld.m12, toWorld.m22);
            if (kind == Kind.Sphere)
                return radius * Mathf.Max(x.magnitude, Mathf.Max(y.magnitude, z.magnitude)) * Vector3.one;
            return axis == 0 ? HalfSizeOfCapsule(x, y, z) : axis == 1 ? HalfSizeOfCapsule(y, x, z) : HalfSizeOfCapsule(z, x, y);
        }

        /// <summary>Half the size of a box along a row of the matrix.</summary>
        private readonly float Extent(float a, float b, float c) => Mathf.Abs(a * halfSize.x) + Mathf.Abs(b * halfSize.y) + Mathf.Abs(c * halfSize.z);

        /// <summary>A capsule is the balls around the points of a segment along its axis.</summary>
        private readonly Vector3 HalfSizeOfCapsule(Vector3 along, Vector3 across, Vector3 otherAcross)
        {
            float length = along.magnitude;
            float ball = radius * Mathf.Max(across.magnitude, otherAcross.magnitude);
            float segment = length > 0 ? Mathf.Max(0, halfSize.x - ball / length) : 0;
            return new Vector3(Mathf.Abs(along.x) * segment + ball, Mathf.Abs(along.y) * segment + ball, Mathf.Abs(along.z) * segment + ball);
        }

        private static ColliderShape OfCapsule(Vector3 center, float radius, float height, int axis) =>
            new ColliderShape { kind = Kind.Capsule, center = center, radius = radius, halfSize = new Vector3(0.5f * height, 0, 0), axis = axis };

        private static ColliderShape OfBounds(Bounds bounds) => new ColliderShape { kind = Kind.Box, center = bounds.center, halfSize = bounds.extents };

        /// <summary>Reads the box of a terrain, a wheel or another type from PhysX, which needs the current transforms first.</summary>
        private static ColliderShape OfPhysX(Collider collider)
        {
            Physics.SyncTransforms();
            Bounds bounds = collider.bounds;
            return new ColliderShape { kind = Kind.Upright, center = bounds.center - collider.transform.position, halfSize = bounds.extents };
        }

        private static Aabb Around(float x, float y, float z, Vector3 half) => Aabb.Around(x, y, z, half.x, half.y, half.z);

        /// <summary>Compares exactly; Vector3's own operator ignores small differences.</summary>
        private static bool Same(Vector3 a, Vector3 b) => a.x == b.x && a.y == b.y && a.z == b.z;
    }

    /// <summary>Computes the boxes of moving colliders from their shapes and transforms, on worker threads.</summary>
#if SWEEPSTAKE_BURST
    [BurstCompile]
#endif
    internal struct ColliderBoxesJob : IJobParallelForTransform
    {
        [ReadOnly] internal NativeArray<ColliderShape> Shapes;
        [WriteOnly] internal NativeArray<Aabb> Boxes;

        public void Execute(int index, TransformAccess transform) =>
            Boxes[index] = transform.isValid ? Shapes[index].BoxOf(transform.localToWorldMatrix) : ColliderShape.NoBox;
    }
}
