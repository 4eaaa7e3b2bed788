#nullable enable
using System;
using System.Collections.Generic;
using UnityEngine;

namespace Sweepstake.Unity
{
    /// <summary>
    /// Queries over tracked colliders with Unity's types. Destroyed colliders are not returned. After its buffer has grown, nothing
    /// allocates.
    /// </summary>
    internal sealed class ColliderQueries
    {
        private readonly ColliderSet colliders;
        private readonly Aabb[] boxes = new Aabb[1];
        private readonly SphereQuery[] spheres = new SphereQuery[1];
        private readonly RayQuery[] rays = new RayQuery[1];
        private readonly QueryHit[] hits = new QueryHit[1];
        private readonly ulong[] ends = new ulong[1];
        private ProxyHandle[] found = new ProxyHandle[64];

        internal ColliderQueries(ColliderSet colliders)
        {
            this.colliders = colliders;
        }

        internal void Box(Bounds box, LayerMask layers, List<Collider> result)
        {
            Vector3 min = box.min;
            Vector3 max = box.max;
            boxes[0] = new Aabb(min.x, min.y, min.z, max.x, max.y, max.z);
            ProxyQueries queries = Prepared();
            while (!queries.Boxes(boxes, LayerFilters.Query(layers), found, ends))
                Grow();
            Copy(result);
        }

        internal void Sphere(Vector3 center, float radius, LayerMask layers, List<Collider> result)
        {
            spheres[0] = new SphereQuery { CenterX = center.x, CenterY = center.y, CenterZ = center.z, Radius = radius };
            ProxyQueries queries = Prepared();
            while (!queries.Spheres(spheres, LayerFilters.Query(layers), found, ends))
                Grow();
            Copy(result);
        }

        internal bool Ray(Ray ray, float maxDistance, LayerMask layers, out Collider? hit, out float distance)
        {
            Vector3 origin = ray.origin;
            Vector3 direction = ray.direction;
            rays[0] = new RayQuery
            {
                OriginX = origin.x, OriginY = origin.y, OriginZ = origin.z,
                DirectionX = direction.x, DirectionY = direction.y, DirectionZ = direction.z,
                MaxDistance = Math.Min(maxDistance, float.MaxValue),
            };
            // A hit that was destroyed since the latest frame must not hide a collider behind it.
            do
            {
                Prepared().Rays(rays, LayerFilters.Query(layers), hits);
                hit = hits[0].Proxy.IsNone ? null : colliders.OwnerOf(hits[0].Proxy);
            }
            while (!(hit is null) && hit == null && colliders.Remove(hit!));
            distance = hits[0].Distance;
            return !(hit is null);
        }

        private ProxyQueries Prepared()
        {
            ProxyQueries queries = colliders.Proxies.Queries;
            queries.Prepare();
            return queries;
        }

        private void Grow() => found = new ProxyHandle[Math.Max(found.Length * 2, (int)ends[0])];

        private void Copy(List<Collider> result)
        {
            for (int index = 0; index < (int)ends[0]; ++index)
            {
                Collider? owner = colliders.OwnerOf(found[index]);
                if (owner != null)
                    result.Add(owner!);
            }
        }
    }
}
