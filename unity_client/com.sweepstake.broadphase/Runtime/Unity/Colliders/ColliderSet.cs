#nullable enable
using System;
using System.Collections.Generic;
using Unity.Collections;
using UnityEngine;
using UnityEngine.Jobs;

namespace Sweepstake.Unity
{
    /// <summary>
    /// Colliders as proxies. A job computes the boxes of moving colliders in each frame; the box of a static collider is computed when it is
    /// added, enabled or refreshed. A disabled or inactive collider has no box, which ends its pairs. In steady state nothing allocates.
    /// </summary>
    internal sealed class ColliderSet : IDisposable
    {
        /// <summary>
        /// Colliders per frame whose layer, shape and state are read again. They take turns, so that the cost of a frame is bounded.
        /// </summary>
        private const int ChecksPerFrame = 1024;
        /// <summary>Transforms of one hierarchy that a worker takes at a time.</summary>
        private const int BatchSize = 64;
        private const int StartSize = 64;

        private readonly LayerFilters filters;
        private readonly Dictionary<Collider, TrackedCollider> tracked = new Dictionary<Collider, TrackedCollider>();
        private readonly Dictionary<ulong, TrackedCollider> byHandle = new Dictionary<ulong, TrackedCollider>();
        private readonly Stack<int> freePlaces = new Stack<int>();

        // Moving colliders come first, then static ones.
        private TrackedCollider[] colliders = new TrackedCollider[StartSize];
        private ProxyHandle[] handles = new ProxyHandle[StartSize];
        private NativeArray<ColliderShape> shapes = new NativeArray<ColliderShape>(StartSize, Allocator.Persistent);
        private NativeArray<Aabb> boxes = new NativeArray<Aabb>(StartSize, Allocator.Persistent);
        /// <summary>The transforms of the moving colliders, by slot.</summary>
        private TransformAccessArray transforms = new TransformAccessArray(StartSize);
        private int movingCount;
        private int nextCheck;

        internal ColliderSet(LayerFilters filters)
        {
            this.filters = filters;
            Proxies = MakeProxies();
            Pairs = new ColliderPairs(MayBegin);
        }

        /// <summary>The native set. SweepstakeLibrary.Shutdown ends it, until <see cref="Restore"/>.</summary>
        internal ProxySet Proxies { get; private set; }
        internal ColliderPairs Pairs { get; }
        internal int Count { get; private set; }

        internal TrackedCollider? Find(Collider collider) => tracked.TryGetValue(collider, out TrackedCollider? found) ? found : null;

        internal Collider? OwnerOf(ProxyHandle handle) => byHandle.TryGetValue(handle.Value, out TrackedCollider? found) ? found.Collider : null;

        internal Aabb BoxOf(TrackedCollider collider) => boxes[collider.Slot];

        /// <summary>Adds a collider. If its body has added it before, refreshes it; a body replaces another owner.</summary>
        /// <param name="isFound">Whether a scan found it, and the game did not register it.</param>
        /// <returns>False if it is already tracked.</returns>
        internal bool Add(Collider collider, SweepstakeBody? body, bool isFound)
        {
            if (Find(collider) is TrackedCollider former)
            {
                // A change of the scope does not end the tracking of a registered collider.
                former.IsFound &= isFound;
                if (body is null)
                    return false;
                if (ReferenceEquals(former.Body, body))
                {
                    Refresh(former);
                    return false;
                }
                Remove(former);
            }
            if (Count == colliders.Length)
                MakeRoom();
            var added = new TrackedCollider(collider, body, isFound) { Slot = Count, Place = freePlaces.Count > 0 ? freePlaces.Pop() : Count };
            tracked.Add(collider, added);
            colliders[Count] = added;
            shapes[Count++] = ColliderShape.Of(collider, default);
            if (!filters.IsStatic(added.Layer))
                JoinMoving(added);
            ReadBox(added);
            AddProxy(added);
            return true;
        }

        internal bool Remove(Collider collider)
        {
            TrackedCollider? found = Find(collider);
            if (found != null)
                Remove(found);
            return found != null;
        }

        /// <summary>Removes the colliders that a scan found and that do not belong to the tracker any longer.</summary>
        internal void RemoveFound(Predicate<Collider> isWanted)
        {
            for (int slot = Count - 1; slot >= 0; --slot)
            {
                if (colliders[slot].IsFound && (colliders[slot].Collider == null || !isWanted(colliders[slot].Collider)))
                    Remove(colliders[slot]);
            }
        }

        /// <summary>Reads the collider's layer, shape, state and box, and whether Physics.IgnoreCollision excludes its pairs.</summary>
        internal void Refresh(TrackedCollider collider)
        {
            if (collider.Collider == null)
            {
                Remove(collider);
                return;
            }
            shapes[collider.Slot] = default;
            Check(collider);
            ReadBox(collider);
            Pairs.ReviewAllOf(collider);
        }

        internal void RefreshFilters()
        {
            foreach (TrackedCollider collider in tracked.Values)
                ApplyLayer(collider);
        }

        /// <summary>
        /// Creates the native set again after SweepstakeLibrary.Shutdown has ended it. All pairs end, and those that still overlap begin again.
        /// </summary>
        internal void Restore()
        {
            Proxies = MakeProxies();
            Pairs.RemoveAll();
            byHandle.Clear();
            for (int slot = 0; slot < Count; ++slot)
                AddProxy(colliders[slot]);
        }

        /// <summary>Removes destroyed colliders and computes the boxes of this frame.</summary>
        internal void ReadBoxes()
        {
            RemoveDestroyed();
            for (int check = Math.Min(ChecksPerFrame, Count); check > 0; --check)
            {
                nextCheck = nextCheck + 1 < Count ? nextCheck + 1 : 0;
                Check(colliders[nextCheck]);
            }
            new ColliderBoxesJob { Shapes = shapes, Boxes = boxes }.ScheduleReadOnly(transforms, BatchSize).Complete();
            Proxies.SetBoxes(handles.AsSpan(0, movingCount), boxes.AsReadOnlySpan().Slice(0, movingCount));
        }

        internal void FindPairs(BroadPhaseSession session)
        {
            Proxies.FindPairs(session);
            foreach (ProxyPair pair in Proxies.Removed)
            {
                // The pairs of a removed collider have already ended.
                if (byHandle.TryGetValue(pair.A.Value, out TrackedCollider? a) && byHandle.TryGetValue(pair.B.Value, out TrackedCollider? b))
                    Pairs.Remove(a, b);
            }
            foreach (ProxyPair pair in Proxies.Added)
                Pairs.Add(byHandle[pair.A.Value], byHandle[pair.B.Value]);
            Pairs.ReviewSome();
        }

        internal void CopyBoxes(List<Aabb> copy)
        {
            copy.Clear();
            for (int place = Count + freePlaces.Count; place > 0; --place)
                copy.Add(ColliderShape.NoBox);
            for (int slot = 0; slot < Count; ++slot)
                copy[colliders[slot].Place] = boxes[slot];
        }

        public void Dispose()
        {
            Pairs.RemoveAll();
            Proxies.Dispose();
            shapes.Dispose();
            boxes.Dispose();
            transforms.Dispose();
        }

        private static ProxySet MakeProxies()
        {
            ProxySetOptions options = ProxySetOptions.Default;
            options.HasPairEvents = true;
            return new ProxySet(options);
        }

        /// <summary>Adds a collider to the native set. After SweepstakeLibrary.Shutdown, <see cref="Restore"/> adds it.</summary>
        private void AddProxy(TrackedCollider collider)
        {
            if (Proxies.IsDisposed)
                return;
            ProxyFlags flags = collider.Slot < movingCount ? ProxyFlags.None : ProxyFlags.Static;
            collider.Handle = Proxies.Add(boxes[collider.Slot], new ProxyOptions(filters.Of(collider.Layer), flags));
            handles[collider.Slot] = collider.Handle;
            byHandle.Add(collider.Handle.Value, collider);
        }

        private bool MayBegin(TrackedPair pair)
        {
            Check(pair.A);
            Check(pair.B);
            return shapes[pair.A.Slot].HasBox && shapes[pair.B.Slot].HasBox && filters.Collide(pair.A.Layer, pair.B.Layer);
        }

        /// <summary>Reads layer, shape and state. The box of a static collider follows at once, that of a moving one with the next job.</summary>
        private void Check(TrackedCollider collider)
        {
            int layer = collider.Object.layer;
            if (layer != collider.Layer)
            {
                collider.Layer = layer;
                ApplyLayer(collider);
            }
            ColliderShape shape = ColliderShape.Of(collider.Collider, shapes[collider.Slot]);
            if (shape.Equals(shapes[collider.Slot]))
                return;
            shapes[collider.Slot] = shape;
            if (collider.Slot >= movingCount)
                ReadBox(collider);
        }

        private void ApplyLayer(TrackedCollider collider)
        {
            bool isStatic = filters.IsStatic(collider.Layer);
            if (isStatic != collider.Slot >= movingCount)
                SetStatic(collider, isStatic);
            if (!Proxies.IsDisposed)
                Proxies.SetFilter(collider.Handle, filters.Of(collider.Layer));
        }

        private void SetStatic(TrackedCollider collider, bool isStatic)
        {
            if (isStatic)
                LeaveMoving(collider);
            else
                JoinMoving(collider);
            ReadBox(collider);
            if (!Proxies.IsDisposed)
                Proxies.SetStatic(collider.Handle, isStatic);
        }

        private void ReadBox(TrackedCollider collider)
        {
            int slot = collider.Slot;
            boxes[slot] = shapes[slot].BoxOf(collider.Collider.transform.localToWorldMatrix);
            if (!Proxies.IsDisposed && !collider.Handle.IsNone)
                Proxies.SetBoxes(handles.AsSpan(slot, 1), boxes.AsReadOnlySpan().Slice(slot, 1));
        }

        private void Remove(TrackedCollider collider)
        {
            Pairs.RemoveAllOf(collider);
            freePlaces.Push(collider.Place);
            tracked.Remove(collider.Collider);
            if (!Proxies.IsDisposed)
            {
                byHandle.Remove(collider.Handle.Value);
                Proxies.Remove(collider.Handle);
            }
            if (collider.Slot < movingCount)
                LeaveMoving(collider);
            Swap(collider, colliders[--Count]);
            colliders[Count] = null!;
        }

        private void JoinMoving(TrackedCollider collider)
        {
            Swap(collider, colliders[movingCount++]);
            transforms.Add(collider.Collider.transform);
        }

        private void LeaveMoving(TrackedCollider collider)
        {
            transforms.RemoveAtSwapBack(collider.Slot);
            Swap(collider, colliders[--movingCount]);
        }

        private void Swap(TrackedCollider collider, TrackedCollider other)
        {
            (int slot, int otherSlot) = (collider.Slot, other.Slot);
            (colliders[slot], colliders[otherSlot]) = (other, collider);
            (handles[slot], handles[otherSlot]) = (handles[otherSlot], handles[slot]);
            (shapes[slot], shapes[otherSlot]) = (shapes[otherSlot], shapes[slot]);
            (boxes[slot], boxes[otherSlot]) = (boxes[otherSlot], boxes[slot]);
            (collider.Slot, other.Slot) = (otherSlot, slot);
        }

        /// <summary>Removes destroyed colliders, and doubles the arrays if they are still more than half full.</summary>
        private void MakeRoom()
        {
            RemoveDestroyed();
            if (Count <= colliders.Length / 2)
                return;
            int size = colliders.Length * 2;
            Array.Resize(ref colliders, size);
            Array.Resize(ref handles, size);
            Resize(ref shapes, size);
            Resize(ref boxes, size);
        }

        private void RemoveDestroyed()
        {
            for (int slot = Count - 1; slot >= 0; --slot)
            {
                if (colliders[slot].Collider == null)
                    Remove(colliders[slot]);
            }
        }

        private static void Resize<T>(ref NativeArray<T> array, int size)
            where T : struct
        {
            var larger = new NativeArray<T>(size, Allocator.Persistent);
            NativeArray<T>.Copy(array, larger, array.Length);
            array.Dispose();
            array = larger;
        }
    }
}
