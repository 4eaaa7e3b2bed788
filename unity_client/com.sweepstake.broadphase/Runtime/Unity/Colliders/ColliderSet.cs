#nullable enable
using System;
using System.Collections.Generic;
using UnityEngine;

namespace Sweepstake.Unity
{
    /// <summary>Two colliders whose boxes overlap, in no particular order. A destroyed collider equals null.</summary>
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
    /// Colliders as proxies. The boxes of colliders of static game objects are read when the colliders are added, enabled or disabled. The
    /// boxes of all other colliders are read in each frame. A disabled collider has no box, which ends its pairs. A destroyed collider is
    /// removed automatically. In steady state nothing allocates.
    /// </summary>
    internal sealed class ColliderSet : IDisposable
    {
        /// <summary>
        /// The number of colliders per frame whose layer and static state are checked. The colliders take turns, so the cost per frame is
        /// bounded.
        /// </summary>
        private const int ChecksPerFrame = 64;
        private static readonly Aabb NoBox = new Aabb(1, 1, 1, -1, -1, -1);

        private readonly LayerFilters filters;
        private readonly Dictionary<Collider, int> slots = new Dictionary<Collider, int>();
        /// <summary>
        /// The collider of each handle. The entry of a removed collider stays until the end events of its pairs were raised.
        /// </summary>
        private readonly Dictionary<ulong, Collider> owners = new Dictionary<ulong, Collider>();
        private readonly List<ulong> removed = new List<ulong>();
        private readonly Stack<int> freePlaces = new Stack<int>();

        // Moving colliders come first, then static ones.
        private Collider?[] colliders = new Collider?[64];
        private ProxyHandle[] handles = new ProxyHandle[64];
        private Aabb[] boxes = new Aabb[64];
        private int[] layers = new int[64];
        /// <summary>Index of a collider's box in recordings, fixed while it is tracked.</summary>
        private int[] places = new int[64];
        /// <summary>The value of searchCount when the collider was added.</summary>
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
        /// <summary>Number of colliders that are tracked or were removed since the latest search.</summary>
        internal int KnownCount => owners.Count;
        /// <summary>
        /// Whether the pairs may be read. False before the first search, and after a collider was removed until the next search.
        /// </summary>
        internal bool HasPairs { get; private set; }

        /// <returns>False if it is already tracked.</returns>
        internal bool Add(Collider collider)
        {
            if (slots.ContainsKey(collider))
                return false;
            if (count == colliders.Length)
                MakeRoom();
#if UNITY_EDITOR
            bool isStatic = collider.gameObject.isStatic;
#else
            const bool isStatic = false;
#endif
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

        /// <returns>False if it is not tracked.</returns>
        internal bool Remove(Collider collider)
        {
            if (!slots.TryGetValue(collider, out int slot))
                return false;
            RemoveAt(slot);
            return true;
        }

        internal bool Contains(Collider collider) => slots.ContainsKey(collider);

        /// <summary>Reads the collider's layer, static flag and box again.</summary>
        internal void Refresh(Collider collider)
        {
            if (Remove(collider))
                Add(collider);
        }

        /// <summary>Sets the filter of each collider again after the layers' filters have changed.</summary>
        internal void RefreshFilters()
        {
            for (int slot = 0; slot < count; ++slot)
                Proxies.SetFilter(handles[slot], filters.Of(layers[slot]));
        }

        /// <summary>
        /// Reads the boxes of this frame. It first sends the transforms to PhysX; otherwise the boxes would be those of PhysX's latest
        /// step.
        /// </summary>
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

        /// <summary>The collider of a handle in the pairs of the latest search.</summary>
        internal Collider OwnerOf(ProxyHandle handle) => owners[handle.Value];

        /// <summary>Forgets the removed colliders; called after the end events of their pairs were raised.</summary>
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

        /// <summary>
        /// Moves the content of slot `from` to slot `to`. REQUIRES: the content of `to` has been moved or removed before.
        /// </summary>
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

        /// <summary>Removes destroyed colliders, and doubles the arrays if they are still more than half full.</summary>
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

        /// <summary>
        /// Returns the collider's box. Returns NoBox if Unity's box has size zero: the collider is disabled, or its game object is
        /// inactive.
        /// </summary>
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
