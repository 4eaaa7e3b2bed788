#nullable enable
using System;
using Sweepstake.LowLevel;

namespace Sweepstake
{
    /// <summary>
    /// Queries over the moving and static proxies of a set whose filter and the query's filter pass. After <see cref="Prepare"/> any number of
    /// threads may query at the same time until something changes. Nothing allocates.
    /// </summary>
    public sealed unsafe class ProxyQueries
    {
        private readonly ProxySet proxies;

        internal ProxyQueries(ProxySet proxies)
        {
            this.proxies = proxies;
        }

        /// <summary>Makes the queries ready, after changes: O(1) if nothing has changed.</summary>
        public void Prepare()
        {
            proxies.CheckCall(NativeMethods.swp_proxies_prepare_queries(proxies.Pointer));
        }

        /// <summary>For each box, gives all proxies that overlap it, by ascending id.</summary>
        /// <param name="found">Takes them: those of box k from ends[k - 1] (0 for the first) to ends[k].</param>
        /// <param name="ends">One for each box. Its last says how many were found.</param>
        /// <returns>False: `found` is too small and holds nothing; the last of `ends` says what it takes.</returns>
        public bool Boxes(ReadOnlySpan<Aabb> boxes, ProxyFilter filter, Span<ProxyHandle> found, Span<ulong> ends)
        {
            CheckLengths(boxes.Length, ends.Length);
            fixed (Aabb* box = boxes)
            fixed (ProxyHandle* handle = found)
            fixed (ulong* end = ends)
                return Fits(NativeMethods.swp_proxies_query_boxes(
                    proxies.Pointer, box, (uint)boxes.Length, &filter, handle, (ulong)found.Length, end));
        }

        /// <summary>The same for the proxies that spheres touch.</summary>
        public bool Spheres(ReadOnlySpan<SphereQuery> spheres, ProxyFilter filter, Span<ProxyHandle> found, Span<ulong> ends)
        {
            CheckLengths(spheres.Length, ends.Length);
            fixed (SphereQuery* sphere = spheres)
            fixed (ProxyHandle* handle = found)
            fixed (ulong* end = ends)
                return Fits(NativeMethods.swp_proxies_query_spheres(
                    proxies.Pointer, sphere, (uint)spheres.Length, &filter, handle, (ulong)found.Length, end));
        }

        /// <summary>For each ray, gives the nearest hit; without one, its proxy is none.</summary>
        public void Rays(ReadOnlySpan<RayQuery> rays, ProxyFilter filter, Span<QueryHit> hits)
        {
            CheckLengths(rays.Length, hits.Length);
            fixed (RayQuery* ray = rays)
            fixed (QueryHit* hit = hits)
                proxies.CheckCall(NativeMethods.swp_proxies_cast_rays(proxies.Pointer, ray, (uint)rays.Length, &filter, hit));
        }

        /// <summary>For each box on its way, gives the nearest hit; without one, its proxy is none.</summary>
        public void Sweeps(ReadOnlySpan<BoxSweepQuery> sweeps, ProxyFilter filter, Span<QueryHit> hits)
        {
            CheckLengths(sweeps.Length, hits.Length);
            fixed (BoxSweepQuery* sweep = sweeps)
            fixed (QueryHit* hit = hits)
                proxies.CheckCall(NativeMethods.swp_proxies_sweep_boxes(proxies.Pointer, sweep, (uint)sweeps.Length, &filter, hit));
        }

        /// <summary>Gives all hits of one ray by ascending distance.</summary>
        /// <param name="count">How many there are.</param>
        /// <returns>False: `hits` is too small and holds nothing.</returns>
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
            proxies.CheckCall(result);
            return true;
        }

        private static void CheckLengths(int queries, int results)
        {
            if (queries != results)
                throw new ArgumentException("There is one result for each query.");
        }
    }
}
