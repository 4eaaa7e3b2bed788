#nullable enable
using System;
using Sweepstake.LowLevel;

namespace Sweepstake
{
    /// <summary>
    /// Objects with handles, filters, static and sleeping states and pair events, on top of a world or a session. A frame is
    /// <see cref="SetBoxes"/>, <see cref="FindPairs(BroadPhaseSession)"/>, then <see cref="Pairs"/>, <see cref="Added"/> and
    /// <see cref="Removed"/>. One caller at a time. Queries are in <see cref="ProxyQueries"/>.
    /// </summary>
    /// <exception cref="SweepstakeException">
    /// Each function that takes handles throws this if one of them is invalid; the set is then unchanged.
    /// </exception>
    public sealed unsafe class ProxySet : NativeObject
    {
        /// <param name="options">Null for the defaults.</param>
        public ProxySet(ProxySetOptions? options = null)
            : base(Create(options ?? ProxySetOptions.Default), NativeMethods.swp_proxies_destroy)
        {
            Queries = new ProxyQueries(this);
        }

        public ProxyQueries Queries { get; }

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

        public void SetStatic(ProxyHandle proxy, bool isStatic) => Check(NativeMethods.swp_proxies_set_static(Pointer, proxy.Value, isStatic ? 1u : 0u));

        /// <summary>
        /// Sets whether a proxy sleeps. The caller promises that a sleeping proxy does not move; a new box wakes it. Pairs and events do
        /// not depend on this state.
        /// </summary>
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

        public int MovingCount => (int)Read<uint>((set, count) => NativeMethods.swp_proxies_counts(set, count, null, null));
        public int StaticCount => (int)Read<uint>((set, count) => NativeMethods.swp_proxies_counts(set, null, count, null));

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
        public ReadOnlySpan<OverlapPair> Pairs => ReadArray<OverlapPair>((set, pairs, count) => NativeMethods.swp_proxies_pairs(set, pairs, count));
        /// <summary>The pairs that began with the latest search, ascending; empty without <see cref="ProxySetOptions.HasPairEvents"/>.</summary>
        public ReadOnlySpan<ProxyPair> Added => ReadArray<ProxyPair>((set, pairs, count) => NativeMethods.swp_proxies_added(set, pairs, count));
        /// <summary>The pairs that ended with the latest search, including those of removed proxies.</summary>
        public ReadOnlySpan<ProxyPair> Removed => ReadArray<ProxyPair>((set, pairs, count) => NativeMethods.swp_proxies_removed(set, pairs, count));

        /// <summary>Returns the complete state without pointers, for games that roll back to an earlier frame.</summary>
        public byte[] Save()
        {
            var snapshot = new byte[Read<ulong>((set, bytes) => NativeMethods.swp_proxies_snapshot_bytes(set, bytes))];
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
