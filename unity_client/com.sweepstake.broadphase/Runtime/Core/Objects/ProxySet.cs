#nullable enable
using System;
using Sweepstake.LowLevel;

namespace Sweepstake
{
    /// <summary>
    /// Objects with handles, filters, static and sleeping states and pair events, on top of a world or a session. A frame is
    /// <see cref="SetBoxes"/>, <see cref="FindPairs(BroadPhaseSession)"/>, then <see cref="Pairs"/>, <see cref="Added"/> and
    /// <see cref="Removed"/>. One caller at a time, except for queries after <see cref="PrepareQueries"/>.
    /// </summary>
    /// <exception cref="SweepstakeException">Functions with handles throw this if one is invalid, and do not change the set.</exception>
    public sealed unsafe class ProxySet : NativeObject
    {
        /// <param name="options">Null for the defaults.</param>
        public ProxySet(ProxySetOptions? options = null)
            : base(Create(options ?? ProxySetOptions.Default), NativeMethods.swp_proxies_destroy)
        {
        }

        /// <summary>Adds a proxy for each box. A moving proxy costs O(1); static proxies are sorted at the next use.</summary>
        /// <param name="options">One entry per box; empty: moving, <see cref="ProxyFilter.All"/>, user 0.</param>
        /// <param name="added">Receives the handles; as long as `boxes`.</param>
        public void Add(ReadOnlySpan<Aabb> boxes, ReadOnlySpan<ProxyOptions> options, Span<ProxyHandle> added)
        {
            if (added.Length != boxes.Length || (options.Length != boxes.Length && options.Length != 0))
                throw new ArgumentException("Pass as many handles as boxes, and as many options or none.");
            fixed (Aabb* box = boxes)
            fixed (ProxyOptions* option = options)
            fixed (ProxyHandle* handle = added)
                Check(NativeMethods.swp_proxies_add_many(Pointer, box, option, (uint)boxes.Length, handle));
        }

        public ProxyHandle Add(in Aabb box, in ProxyOptions options)
        {
            ProxyHandle added;
            fixed (Aabb* start = &box)
            fixed (ProxyOptions* option = &options)
                Check(NativeMethods.swp_proxies_add_many(Pointer, start, option, 1, &added));
            return added;
        }

        /// <summary>Removes all of these proxies, or none of them if one handle is invalid.</summary>
        public void Remove(ReadOnlySpan<ProxyHandle> removed)
        {
            fixed (ProxyHandle* start = removed)
                Check(NativeMethods.swp_proxies_remove_many(Pointer, start, (uint)removed.Length));
        }

        public void Remove(ProxyHandle removed) => Check(NativeMethods.swp_proxies_remove_many(Pointer, &removed, 1));

        /// <summary>Sets the box of moved[k] to boxes[k] for all k, or for none if one handle is invalid.</summary>
        public void SetBoxes(ReadOnlySpan<ProxyHandle> moved, ReadOnlySpan<Aabb> boxes)
        {
            if (moved.Length != boxes.Length)
                throw new ArgumentException("Pass as many boxes as proxies.");
            fixed (ProxyHandle* handle = moved)
            fixed (Aabb* box = boxes)
                Check(NativeMethods.swp_proxies_set_boxes(Pointer, handle, box, (uint)boxes.Length));
        }

        /// <summary>Sets the filter of a proxy. It takes effect with the next search and the next query.</summary>
        public void SetFilter(ProxyHandle proxy, ProxyFilter filter) => Check(NativeMethods.swp_proxies_set_filter(Pointer, proxy.Value, &filter));

        public void SetUser(ProxyHandle proxy, ulong user) => Check(NativeMethods.swp_proxies_set_user(Pointer, proxy.Value, user));

        public void SetStatic(ProxyHandle proxy, bool isStatic) =>
            Check(NativeMethods.swp_proxies_set_static(Pointer, proxy.Value, isStatic ? 1u : 0u));

        /// <summary>Sets whether a proxy sleeps. It must not move then; a new box wakes it. Pairs and events do not depend on this.</summary>
        public void SetSleeping(ProxyHandle proxy, bool isSleeping) =>
            Check(NativeMethods.swp_proxies_set_sleeping(Pointer, proxy.Value, isSleeping ? 1u : 0u));

        /// <summary>Subtracts an offset from all coordinates. No pair ends because of it.</summary>
        public void ShiftOrigin(float x, float y, float z)
        {
            float* offset = stackalloc float[3] { x, y, z };
            Check(NativeMethods.swp_proxies_shift_origin(Pointer, offset));
        }

        /// <summary>The current box and options of a proxy.</summary>
        public Aabb Get(ProxyHandle proxy, out ProxyOptions options)
        {
            Aabb box;
            fixed (ProxyOptions* option = &options)
                Check(NativeMethods.swp_proxies_get(Pointer, proxy.Value, &box, option));
            return box;
        }

        /// <summary>The handle of the proxy that currently has this id, for example an id from a pair.</summary>
        public ProxyHandle HandleOf(uint id)
        {
            ProxyHandle proxy;
            Check(NativeMethods.swp_proxies_handle(Pointer, id, &proxy));
            return proxy;
        }

        public int MovingCount => (int)Read<uint>((self, count) => NativeMethods.swp_proxies_counts(self, count, null, null));
        public int StaticCount => (int)Read<uint>((self, count) => NativeMethods.swp_proxies_counts(self, null, count, null));

        /// <summary>Searches with a session, during its frame, and resolves the pairs.</summary>
        public void FindPairs(BroadPhaseSession session)
        {
            session.FindPairs(MovingBoxes());
            Resolve(session.Pairs);
        }

        /// <summary>Searches with a world and resolves the pairs. The world does not need a build before.</summary>
        public void FindPairs(BroadPhaseWorld world)
        {
            ReadOnlySpan<Aabb> boxes = MovingBoxes();
            fixed (Aabb* start = boxes)
            {
                if (NativeMethods.swp_world_update(world.Pointer, start, (uint)boxes.Length) == ResultCode.FailedPrecondition)
                    world.Build(boxes);
            }
            world.FindPairs();
            Resolve(world.Pairs);
        }

        /// <summary>The pairs of the latest search by id; valid until the next search.</summary>
        public ReadOnlySpan<OverlapPair> Pairs => ReadArray<OverlapPair>((self, pairs, count) => NativeMethods.swp_proxies_pairs(self, pairs, count));
        /// <summary>The pairs that began with the latest search, ascending; empty without <see cref="ProxySetOptions.HasPairEvents"/>.</summary>
        public ReadOnlySpan<ProxyPair> Added => ReadArray<ProxyPair>((self, pairs, count) => NativeMethods.swp_proxies_added(self, pairs, count));
        /// <summary>The pairs that ended with the latest search, including those of removed proxies.</summary>
        public ReadOnlySpan<ProxyPair> Removed => ReadArray<ProxyPair>((self, pairs, count) => NativeMethods.swp_proxies_removed(self, pairs, count));

        /// <summary>Returns the complete state without pointers, for games that roll back to an earlier frame.</summary>
        public byte[] Save()
        {
            var snapshot = new byte[Read<ulong>((self, bytes) => NativeMethods.swp_proxies_snapshot_bytes(self, bytes))];
            fixed (byte* start = snapshot)
                Check(NativeMethods.swp_proxies_save(Pointer, start, (ulong)snapshot.Length));
            return snapshot;
        }

        /// <summary>Restores a saved state. Do not restore snapshots from untrusted sources.</summary>
        public void Restore(ReadOnlySpan<byte> snapshot)
        {
            fixed (byte* start = snapshot)
                Check(NativeMethods.swp_proxies_restore(Pointer, start, (ulong)snapshot.Length));
        }

        /// <summary>
        /// Prepares queries over moving and static proxies after changes; O(1) if nothing has changed. A proxy is found if its filter and the
        /// query's filter match. Until the set changes, any number of threads may then query at the same time. Nothing allocates.
        /// </summary>
        public void PrepareQueries() => Check(NativeMethods.swp_proxies_prepare_queries(Pointer));

        /// <summary>For each box, finds all proxies that overlap it, by ascending id.</summary>
        /// <param name="found">
        /// Receives the proxies. The proxies of box k begin at index ends[k - 1] (0 for the first box) and end before index ends[k].
        /// </param>
        /// <param name="ends">One entry per box; the last one is the number of proxies found.</param>
        /// <returns>False: `found` is too small and was not filled; the last entry of `ends` is the required size.</returns>
        public bool QueryBoxes(ReadOnlySpan<Aabb> boxes, ProxyFilter filter, Span<ProxyHandle> found, Span<ulong> ends)
        {
            CheckLengths(boxes.Length, ends.Length);
            fixed (Aabb* box = boxes)
            fixed (ProxyHandle* handle = found)
            fixed (ulong* end = ends)
                return Fits(NativeMethods.swp_proxies_query_boxes(
                    Pointer, box, (uint)boxes.Length, &filter, handle, (ulong)found.Length, end));
        }

        /// <summary>Like <see cref="QueryBoxes"/>, for the proxies that touch a sphere.</summary>
        public bool QuerySpheres(ReadOnlySpan<SphereQuery> spheres, ProxyFilter filter, Span<ProxyHandle> found, Span<ulong> ends)
        {
            CheckLengths(spheres.Length, ends.Length);
            fixed (SphereQuery* sphere = spheres)
            fixed (ProxyHandle* handle = found)
            fixed (ulong* end = ends)
                return Fits(NativeMethods.swp_proxies_query_spheres(
                    Pointer, sphere, (uint)spheres.Length, &filter, handle, (ulong)found.Length, end));
        }

        /// <summary>Finds the nearest hit of each ray. If a ray hits nothing, the hit's proxy is None.</summary>
        public void CastRays(ReadOnlySpan<RayQuery> rays, ProxyFilter filter, Span<QueryHit> hits)
        {
            CheckLengths(rays.Length, hits.Length);
            fixed (RayQuery* ray = rays)
            fixed (QueryHit* hit = hits)
                Check(NativeMethods.swp_proxies_cast_rays(Pointer, ray, (uint)rays.Length, &filter, hit));
        }

        /// <summary>Finds the nearest hit of each moving box. If a box hits nothing, the hit's proxy is None.</summary>
        public void SweepBoxes(ReadOnlySpan<BoxSweepQuery> sweeps, ProxyFilter filter, Span<QueryHit> hits)
        {
            CheckLengths(sweeps.Length, hits.Length);
            fixed (BoxSweepQuery* sweep = sweeps)
            fixed (QueryHit* hit = hits)
                Check(NativeMethods.swp_proxies_sweep_boxes(Pointer, sweep, (uint)sweeps.Length, &filter, hit));
        }

        /// <summary>Finds all hits of one ray by ascending distance.</summary>
        /// <param name="count">The number of hits.</param>
        /// <returns>False: `hits` is too small and was not filled.</returns>
        public bool CastRay(in RayQuery ray, ProxyFilter filter, Span<QueryHit> hits, out int count)
        {
            ulong found = 0;
            bool fits;
            fixed (RayQuery* start = &ray)
            fixed (QueryHit* hit = hits)
                fits = Fits(NativeMethods.swp_proxies_cast_ray(Pointer, start, &filter, hit, (ulong)hits.Length, &found));
            count = checked((int)found);
            return fits;
        }

        private bool Fits(ResultCode result)
        {
            if (result == ResultCode.ResourceExhausted)
                return false;
            Check(result);
            return true;
        }

        private static void CheckLengths(int queries, int results)
        {
            if (queries != results)
                throw new ArgumentException("Pass as many results as queries.");
        }

        private ReadOnlySpan<Aabb> MovingBoxes()
        {
            Aabb* boxes;
            uint count;
            Check(NativeMethods.swp_proxies_moving_boxes(Pointer, &boxes, &count));
            return new ReadOnlySpan<Aabb>(boxes, (int)count);
        }

        private void Resolve(ReadOnlySpan<OverlapPair> found)
        {
            fixed (OverlapPair* start = found)
                Check(NativeMethods.swp_proxies_resolve(Pointer, start, (ulong)found.Length));
        }

        private static IntPtr Create(ProxySetOptions options)
        {
            SweepstakeLibrary.EnsureLoaded();
            IntPtr proxies;
            Native.Check(NativeMethods.swp_proxies_create(&options, &proxies));
            return proxies;
        }
    }
}
