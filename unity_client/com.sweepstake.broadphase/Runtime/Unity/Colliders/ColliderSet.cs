#nullable enable
using System;
using System.Collections.Generic;
using UnityEngine;

namespace Sweepstake.Unity
{
    /// <summary>Two colliders whose boxes overlap; which of them is A means nothing. One that was destroyed equals null.</summary>
    public readonly struct ColliderPair
    {
        public ColliderPair(Collider a, Collider b)
        {
            A = a;
            B = b;
        }

        public Collider A { get; }
        public Collider B { get; }
    }

    /// <summary>
    /// Colliders as proxies. Those of static game objects are read when they are added and when they become active or disabled; the boxes of all
    /// others in each frame. A collider that is disabled has no box and ends its pairs; one that was destroyed is dropped by itself. In steady
    /// state nothing allocates.
    /// </summary>
    internal sealed class ColliderSet : IDisposable
    {
        /// <summary>Layers and static colliders that are looked at per frame, in turn.</summary>
        private const int ChecksPerFrame = 64;
        private static readonly Aabb NoBox = new Aabb(1, 1, 1, -1, -1, -1);

        private readonly LayerFilters filters;
        private readonly Dictionary<Collider, int> slots = new Dictionary<Collider, int>();
        /// <summary>Whose handle it is; a removed one that was searched stays until the ends of its pairs were told.</summary>
        private readonly Dictionary<ulong, Collider> owners = new Dictionary<ulong, Collider>();
        private readonly List<ulong> removed = new List<ulong>();
        private readonly Stack<int> freePlaces = new Stack<int>();

        // Moving colliders come first, static ones behind them.
        private Collider?[] colliders = new Collider?[64];
        private ProxyHandle[] handles = new ProxyHandle[64];
        private Aabb[] boxes = new Aabb[64];
        private int[] layers = new int[64];
        /// <summary>Where a collider's box is in recordings, as long as it is tracked.</summary>
        private int[] places = new int[64];
        /// <summary>How many searches there were when a collider was added.</summary>
        private ulong[] births = new ulong[64];
        private int movingCount;
        private int count;
        private int nextCheck;
        private ulong searchCount;

        internal ColliderSet(LayerFilters filters)
        {
            this.filters = filters;
            ProxySetOptions options = ProxySetOptions.Default;
            options.HasPairEvents = true;
            Proxies = new ProxySet(options);
        }

        internal ProxySet Proxies { get; }
        internal int Count => count;
        /// <summary>Tracked, or removed since the latest search.</summary>
        internal int KnownCount => owners.Count;
        /// <summary>False: none were searched, or the pairs of the latest search have proxies that are gone.</summary>
        internal bool HasPairs { get; private set; }

        /// <returns>False: it is in already.</returns>
        internal bool Add(Collider collider)
        {
            if (slots.ContainsKey(collider))
                return false;
            if (count == colliders.Length)
                MakeRoom();
            bool isStatic = collider.gameObject.isStatic;
            int layer = collider.gameObject.layer;
            Aabb box = BoxOf(collider);
            ProxyHandle handle = Proxies.Add(box, new ProxyOptions(filters.Of(layer), isStatic ? ProxyFlags.Static : ProxyFlags.None));
            owners.Add(handle.Value, collider);
            int place = freePlaces.Count > 0 ? freePlaces.Pop() : count;
            int slot = count++;
            if (!isStatic)
            {
                Move(movingCount, slot);
                slot = movingCount++;
            }
            Put(slot, collider, handle, box, layer, place, searchCount);
            return true;
        }

        /// <returns>False: it is not in.</returns>
        internal bool Remove(Collider collider)
        {
            if (!slots.TryGetValue(collider, out int slot))
                return false;
            RemoveAt(slot);
            return true;
        }

        internal bool Contains(Collider collider) => slots.ContainsKey(collider);

        /// <summary>Reads layer, static flag and box again, now.</summary>
        internal void Refresh(Collider collider)
        {
            if (Remove(collider))
                Add(collider);
        }

        /// <summary>Gives each the filter of its layer, after a change of these.</summary>
        internal void RefreshFilters()
        {
            for (int slot = 0; slot < count; ++slot)
                Proxies.SetFilter(handles[slot], filters.Of(layers[slot]));
        }

        /// <summary>Reads the boxes of this frame. PhysX learns first where the transforms are: otherwise boxes are those of its latest step.</summary>
        internal void ReadBoxes()
        {
            Physics.SyncTransforms();
            for (int slot = 0; slot < movingCount;)
            {
                Collider collider = colliders[slot]!;
                if (collider == null)
                {
                    RemoveAt(slot);
                    continue;
                }
                boxes[slot] = BoxOf(collider);
                ++slot;
            }
            CheckSome();
            Proxies.SetBoxes(handles.AsSpan(0, movingCount), boxes.AsSpan(0, movingCount));
        }

        internal void FindPairs(BroadPhaseSession session)
        {
            ++searchCount;
            Proxies.FindPairs(session);
            HasPairs = true;
        }

        /// <summary>The collider of a handle of the latest search's pairs.</summary>
        internal Collider OwnerOf(ProxyHandle handle) => owners[handle.Value];

        /// <summary>After the pairs that ended were taken.</summary>
        internal void ForgetRemoved()
        {
            foreach (ulong handle in removed)
                owners.Remove(handle);
            removed.Clear();
        }

        internal void CopyBoxes(List<Aabb> copy)
        {
            copy.Clear();
            for (int place = count + freePlaces.Count; place > 0; --place)
                copy.Add(NoBox);
            for (int slot = 0; slot < count; ++slot)
                copy[places[slot]] = boxes[slot];
        }

        public void Dispose() => Proxies.Dispose();

        private void CheckSome()
        {
            for (int check = Math.Min(ChecksPerFrame, count); check > 0 && count > 0; --check)
            {
                int slot = nextCheck = nextCheck + 1 < count ? nextCheck + 1 : 0;
                Collider collider = colliders[slot]!;
                if (collider == null)
                    RemoveAt(slot);
                else
                    Check(slot, collider);
            }
        }

        private void Check(int slot, Collider collider)
        {
            if (collider.gameObject.layer != layers[slot])
                Proxies.SetFilter(handles[slot], filters.Of(layers[slot] = collider.gameObject.layer));
            if (slot < movingCount || boxes[slot].IsValid == (collider.enabled && collider.gameObject.activeInHierarchy))
                return;
            boxes[slot] = BoxOf(collider);
            Proxies.SetBoxes(handles.AsSpan(slot, 1), boxes.AsSpan(slot, 1));
        }

        private void RemoveAt(int slot)
        {
            HasPairs = false;
            freePlaces.Push(places[slot]);
            if (births[slot] == searchCount)
                owners.Remove(handles[slot].Value);
            else
                removed.Add(handles[slot].Value);
            slots.Remove(colliders[slot]!);
            Proxies.Remove(handles[slot]);
            if (slot < movingCount)
            {
                Move(--movingCount, slot);
                slot = movingCount;
            }
            Move(--count, slot);
            colliders[count] = null;
        }

        /// <summary>Puts what is in one slot into another, whose content was moved or is gone.</summary>
        private void Move(int from, int to)
        {
            if (from != to)
                Put(to, colliders[from]!, handles[from], boxes[from], layers[from], places[from], births[from]);
        }

        private void Put(int slot, Collider collider, ProxyHandle handle, in Aabb box, int layer, int place, ulong birth)
        {
            colliders[slot] = collider;
            handles[slot] = handle;
            boxes[slot] = box;
            layers[slot] = layer;
            places[slot] = place;
            births[slot] = birth;
            slots[collider] = slot;
        }

        /// <summary>That of colliders that were destroyed while nothing was searched, or else more.</summary>
        private void MakeRoom()
        {
            for (int slot = count - 1; slot >= 0; --slot)
            {
                if (colliders[slot] == null)
                    RemoveAt(slot);
            }
            if (count <= colliders.Length / 2)
                return;
            int size = colliders.Length * 2;
            Array.Resize(ref colliders, size);
            Array.Resize(ref handles, size);
            Array.Resize(ref boxes, size);
            Array.Resize(ref layers, size);
            Array.Resize(ref places, size);
            Array.Resize(ref births, size);
        }

        /// <summary>Unity gives a collider that is disabled, or whose game object is not active, a box of no size.</summary>
        private static Aabb BoxOf(Collider collider)
        {
            Bounds bounds = collider.bounds;
            if (bounds.extents == Vector3.zero)
                return NoBox;
            Vector3 min = bounds.min;
            Vector3 max = bounds.max;
            return new Aabb(min.x, min.y, min.z, max.x, max.y, max.z);
        }
    }
}
