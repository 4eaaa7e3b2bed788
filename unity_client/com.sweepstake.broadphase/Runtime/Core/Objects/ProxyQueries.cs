#nullable enable
using System;
using Sweepstake.LowLevel;

namespace Sweepstake
{
    /// <summary>
    /// Queries over the moving and static proxies of a set. A proxy is found if its filter and the query's filter match. After
    /// <see cref="Prepare"/> any number of threads may query at the same time, until the set changes. Nothing allocates.
    /// </summary>
    public sealed unsafe class ProxyQueries
    {
        private readonly ProxySet proxies;

        internal ProxyQueries(ProxySet proxies) => this.proxies = proxies;

        /// <summary>Prepares the queries after changes; O(1) if nothing has changed.</summary>
        public void Prepare() => proxies.Check(NativeMethods.swp_proxies_prepare_queries(proxies.Pointer));

        /// <summary>For each box, finds all proxies that overlap it, by ascending id.</summary>
        /// <param name="found">
        /// Receives the proxies. The proxies of box k begin at index ends[k - 1] (0 for the first box) and end before index ends[k].
        /// </param>
        /// <param name="ends">One entry per box; the last one is the number of proxies found.</param>
        /// <returns>False: `found` is too small and was not filled; the last entry of `ends` is the required size.</returns>
        public bool Boxes(ReadOnlySpan<Aabb> boxes, ProxyFilter filter, Span<ProxyHandle> found, Span<ulong> ends)
        {
            CheckLengths(boxes.Length, ends.Length);
            fixed (Aabb* box = boxes)
            fixed (ProxyHandle* handle = found)
            fixed (ulong* end = ends)
                return Fits(NativeMethods.swp_proxies_query_boxes(
                    proxies.Pointer, box, (uint)boxes.Length, &filter, handle, (ulong)found.Length, end));
        }

        /// <summary>Like <see cref="Boxes"/>, for the proxies that touch a sphere.</summary>
        public bool Spheres(ReadOnlySpan<SphereQuery> spheres, ProxyFilter filter, Span<ProxyHandle> found, Span<ulong> ends)
        {
            CheckLengths(spheres.Length, ends.Length);
            fixed (SphereQuery* sphere = spheres)
            fixed (ProxyHandle* handle = found)
            fixed (ulong* end = ends)
                return Fits(NativeMethods.swp_proxies_query_spheres(
                    proxies.Pointer, sphere, (uint)spheres.Length, &filter, handle, (ulong)found.Length, end));
        }

        /// <summary>Finds the nearest hit of each ray. If a ray hits nothing, the hit's proxy is None.</summary>
        public void Rays(ReadOnlySpan<RayQuery> rays, ProxyFilter filter, Span<QueryHit> hits)
        {
            CheckLengths(rays.Length, hits.Length);
            fixed (RayQuery* ray = rays)
            fixed (QueryHit* hit = hits)
                proxies.Check(NativeMethods.swp_proxies_cast_rays(proxies.Pointer, ray, (uint)rays.Length, &filter, hit));
        }

        /// <summary>Finds the nearest hit of each moving box. If a box hits nothing, the hit's proxy is None.</summary>
        public void Sweeps(ReadOnlySpan<BoxSweepQuery> sweeps, ProxyFilter filter, Span<QueryHit> hits)
        {
            CheckLengths(sweeps.Length, hits.Length);
            fixed (BoxSweepQuery* sweep = sweeps)
            fixed (QueryHit* hit = hits)
                proxies.Check(NativeMethods.swp_proxies_sweep_boxes(proxies.Pointer, sweep, (uint)sweeps.Length, &filter, hit));
        }

        /// <summary>Finds all hits of one ray by ascending distance.</summary>
        /// <param name="count">The number of hits.</param>
        /// <returns>False: `hits` is too small and was not filled.</returns>
        public bool AllHits(in RayQuery ray, ProxyFilter filter, Span<QueryHit> hits, out int count)
        {
            ulong found = 0;
            bool fits;
            fixed (RayQuery* start = &ray)
            fixed (QueryHit* hit = hits)
                fits = Fits(NativeMethods.swp_proxies_cast_ray(proxies.Pointer, start, &filter, hit, (ulong)hits.Length, &found));
            count = checked((int)found);
            return fits;
        }

        private bool Fits(ResultCode result)
        {
            if (result == ResultCode.ResourceExhausted)
                return false;
            proxies.Check(result);
            return true;
        }

        private static void CheckLengths(int queries, int results)
        {
            if (queries != results)
                throw new ArgumentException("Pass as many results as queries.");
        }
    }
}
