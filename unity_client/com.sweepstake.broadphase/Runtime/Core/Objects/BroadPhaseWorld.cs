#nullable enable
using System;
using Sweepstake.LowLevel;

namespace Sweepstake
{
    /// <summary>
    /// One backend that the game drives itself. A frame is <see cref="Update(ReadOnlySpan{Aabb})"/> (the first time
    /// <see cref="Build(ReadOnlySpan{Aabb})"/>), <see cref="FindPairs"/>, <see cref="Pairs"/>. In steady state nothing allocates.
    /// </summary>
    public sealed unsafe class BroadPhaseWorld : NativeObject
    {
        /// <param name="backend">One of <see cref="SweepstakeLibrary.Backends"/>.</param>
        /// <param name="options">Null for the defaults.</param>
        /// <exception cref="SweepstakeException">The backend is unknown (the message lists them), or no thread is left.</exception>
        public BroadPhaseWorld(string backend, WorldOptions? options = null)
            : base(Create(backend, options ?? WorldOptions.Default), NativeMethods.swp_world_destroy)
        {
        }

        /// <summary>The pairs of the latest search, each once, in the library's memory: valid until the next build or update.</summary>
        public ReadOnlySpan<OverlapPair> Pairs => ReadArray<OverlapPair>((self, pairs, count) => NativeMethods.swp_world_pairs(self, pairs, count));

        /// <summary>The cost of the latest build or update and search, and the memory of the world.</summary>
        public WorldCounters Counters =>
            Read((self, counters) => NativeMethods.swp_world_counters(self, counters), new WorldCounters { StructSize = (uint)sizeof(WorldCounters) });

        /// <summary>Discards all state and builds the structure from these boxes, which are read during the call only.</summary>
        public void Build(ReadOnlySpan<Aabb> boxes)
        {
            fixed (Aabb* start = boxes)
                Check(NativeMethods.swp_world_build(Pointer, start, (uint)boxes.Length));
        }

        /// <summary>Replaces the boxes for the next frame. A larger count adds objects at the end, a smaller count removes the last ones.</summary>
        public void Update(ReadOnlySpan<Aabb> boxes)
        {
            fixed (Aabb* start = boxes)
                Check(NativeMethods.swp_world_update(Pointer, start, (uint)boxes.Length));
        }

        /// <summary>Finds each overlapping pair once per build or update; a second call does nothing.</summary>
        /// <exception cref="SweepstakeException">There are more pairs than <see cref="WorldOptions.MaxPairs"/>.</exception>
        public void FindPairs() => Check(NativeMethods.swp_world_find_pairs(Pointer));

        private static IntPtr Create(string backend, WorldOptions options)
        {
            SweepstakeLibrary.EnsureLoaded();
            using var memory = new CallMemory();
            IntPtr world;
            Native.Check(NativeMethods.swp_world_create(memory.Text(backend ?? throw new ArgumentNullException(nameof(backend))), &options, &world));
            return world;
        }
    }
}
