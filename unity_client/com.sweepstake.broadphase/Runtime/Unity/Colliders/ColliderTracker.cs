#nullable enable
using System;
using System.Collections.Generic;
using UnityEngine;
using UnityEngine.SceneManagement;

namespace Sweepstake.Unity
{
    /// <summary>Which colliders a <see cref="ColliderTracker"/> tracks automatically.</summary>
    public enum ColliderScope
    {
        /// <summary>Colliders of all scenes that are loaded now or later.</summary>
        LoadedScenes,
        /// <summary>Colliders of the tracker's game object and its children.</summary>
        Children,
        /// <summary>None: the game registers each collider.</summary>
        Registered,
    }

    /// <summary>
    /// Lets the manager on the same object search the boxes of colliders, for triggers without physics and for queries. It raises events when boxes
    /// begin or cease to overlap, for layers that collide in the collision matrix. Rigidbodies are not affected: PhysX has its own broad phase.
    /// Objects that are spawned later need a <see cref="SweepstakeBody"/>, or must be registered or found with <see cref="Scan()"/>.
    /// </summary>
    [AddComponentMenu("Sweepstake/Sweepstake Collider Tracker")]
    [RequireComponent(typeof(SweepstakeManager))]
    [DisallowMultipleComponent]
    [DocumentationPage("colliders.md")]
    public sealed class ColliderTracker : MonoBehaviour, IBroadPhaseSource
    {
        [Tooltip("Which colliders are tracked automatically, without being registered.")]
        [SerializeField] private ColliderScope scope = ColliderScope.LoadedScenes;
        [Tooltip("The layers whose colliders are tracked automatically and form pairs.")]
        [SerializeField] private LayerMask layers = ~0;
        [Tooltip("The layers whose colliders do not move. They form pairs with moving colliders only, and cost almost nothing per frame.")]
        [SerializeField] private LayerMask staticLayers = 0;
        [Tooltip("On: only layers that collide in the collision matrix of the physics settings form pairs. Off: all tracked layers do.")]
        [SerializeField] private bool usesCollisionMatrix = true;
        [Tooltip("Tracks only triggers automatically.")]
        [SerializeField] private bool findsTriggersOnly = false;

        private static readonly List<ColliderTracker> Trackers = new List<ColliderTracker>();
        private readonly LayerFilters filters = new LayerFilters();
        private readonly List<Collider> found = new List<Collider>();
        private readonly List<GameObject> roots = new List<GameObject>();
        private readonly Listeners<ColliderPair> beganListeners = new Listeners<ColliderPair>();
        private readonly Listeners<ColliderPair> endedListeners = new Listeners<ColliderPair>();
        private ColliderSet? colliders;
        private ProxyHandle[] hits = new ProxyHandle[64];
        private bool isEdited;

        /// <summary>Raised when two boxes begin to overlap. Use Physics.ComputePenetration to test the shapes.</summary>
        public event Action<ColliderPair>? PairBegan { add => beganListeners.Add(value); remove => beganListeners.Remove(value); }
        /// <summary>Raised when two boxes no longer overlap, or one of the colliders was disabled, removed or destroyed.</summary>
        public event Action<ColliderPair>? PairEnded { add => endedListeners.Add(value); remove => endedListeners.Remove(value); }

        /// <summary>The number of tracked colliders.</summary>
        public int Count => colliders?.Count ?? 0;
        /// <summary>
        /// The underlying proxy set, for many queries at once and for jobs. Null while the tracker is disabled, and after
        /// <see cref="SweepstakeManager.Shutdown"/> until the next frame of the manager.
        /// </summary>
        public ProxySet? Proxies => colliders == null || colliders.Proxies.IsDisposed ? null : colliders.Proxies;
        /// <summary>The layers whose colliders are tracked automatically and form pairs. A change takes effect at once.</summary>
        public LayerMask Layers { get => layers; set => Change(ref layers, value); }
        /// <summary>
        /// The layers whose colliders do not move. They form pairs with moving colliders only. After you have moved one, call
        /// <see cref="Refresh"/>. A change takes effect at once.
        /// </summary>
        public LayerMask StaticLayers { get => staticLayers; set => Change(ref staticLayers, value); }

        /// <summary>Tracks a collider, also one outside the tracker's scope and layers.</summary>
        /// <returns>False if it is already tracked or the tracker is disabled.</returns>
        public bool Register(Collider collider) => colliders != null && collider != null && colliders.Add(collider, null, false);

        /// <returns>False if it is not tracked.</returns>
        public bool Unregister(Collider collider) => colliders != null && !(collider is null) && colliders.Remove(collider);

        public bool IsTracked(Collider collider) => Find(collider) != null;

        /// <summary>The collider of a handle in <see cref="Proxies"/>; null if the collider was destroyed or is not tracked.</summary>
        public Collider? ColliderOf(ProxyHandle handle)
        {
            Collider? owner = colliders?.OwnerOf(handle);
            return owner == null ? null : owner;
        }

        /// <summary>The collider's handle in <see cref="Proxies"/>; None if it is not tracked.</summary>
        public ProxyHandle HandleOf(Collider collider) => Find(collider)?.Handle ?? ProxyHandle.None;

        /// <summary>
        /// Replaces the content of the list with the collider's pairs that have begun and not ended. A of each pair is this collider. Allocates
        /// nothing if the capacity of the list suffices.
        /// </summary>
        public void CopyPairs(Collider collider, List<ColliderPair> result)
        {
            result.Clear();
            AddPairs(collider, result);
        }

        /// <summary>
        /// Reads a collider's layer, shape and state again at once, the box of a static layer, and Physics.IgnoreCollision for its pairs.
        /// Pairs that last do not end. Without this call, such changes are noticed in the next frame, or, if there are more than 1,024 colliders
        /// or pairs, within some frames.
        /// </summary>
        public void Refresh(Collider collider)
        {
            if (Find(collider) is TrackedCollider tracked)
                colliders!.Refresh(tracked);
        }

        /// <summary>Reads the collision matrix again; call it after Physics.IgnoreLayerCollision.</summary>
        public void RefreshLayers()
        {
            filters.Read(layers, staticLayers, usesCollisionMatrix);
            colliders?.RefreshFilters();
        }

        /// <summary>
        /// Tracks all colliders in the tracker's scope, also those of DontDestroyOnLoad objects. Colliders below a
        /// <see cref="SweepstakeBody"/> are left to that body.
        /// </summary>
        public void Scan()
        {
            if (scope == ColliderScope.Children)
                Scan(gameObject);
            if (scope != ColliderScope.LoadedScenes)
                return;
            for (int index = 0; index < SceneManager.sceneCount; ++index)
                Scan(SceneManager.GetSceneAt(index));
            // The scene of DontDestroyOnLoad objects is not among the others. Only an object in it leads to it.
            var probe = new GameObject("Sweepstake");
            DontDestroyOnLoad(probe);
            Scan(probe.scene);
            Destroy(probe);
        }

        /// <summary>Finds all tracked colliders whose boxes overlapped this box in the latest frame. Replaces the list's content.</summary>
        public void OverlapBox(Bounds box, LayerMask layers, List<Collider> result)
        {
            Vector3 min = box.min;
            Vector3 max = box.max;
            ReadOnlySpan<Aabb> boxes = stackalloc[] { new Aabb(min.x, min.y, min.z, max.x, max.y, max.z) };
            Span<ulong> ends = stackalloc ulong[1];
            result.Clear();
            while (PreparedProxies() is ProxySet proxies && !proxies.QueryBoxes(boxes, LayerFilters.Query(layers), hits, ends))
                hits = new ProxyHandle[2 * ends[0]];
            AddOwners(ends[0], result);
        }

        /// <summary>Finds all tracked colliders whose boxes touch the sphere. Replaces the list's content.</summary>
        public void OverlapSphere(Vector3 center, float radius, LayerMask layers, List<Collider> result)
        {
            var sphere = new SphereQuery { CenterX = center.x, CenterY = center.y, CenterZ = center.z, Radius = radius };
            ReadOnlySpan<SphereQuery> spheres = stackalloc[] { sphere };
            Span<ulong> ends = stackalloc ulong[1];
            result.Clear();
            while (PreparedProxies() is ProxySet proxies && !proxies.QuerySpheres(spheres, LayerFilters.Query(layers), hits, ends))
                hits = new ProxyHandle[2 * ends[0]];
            AddOwners(ends[0], result);
        }

        /// <summary>Finds the nearest tracked collider whose box the ray hits.</summary>
        /// <param name="distance">Distance to the box; 0 if the ray starts inside.</param>
        public bool Raycast(Ray ray, float maxDistance, LayerMask layers, out Collider? hit, out float distance)
        {
            (Vector3 origin, Vector3 direction) = (ray.origin, ray.direction);
            var query = new RayQuery
            {
                OriginX = origin.x, OriginY = origin.y, OriginZ = origin.z,
                DirectionX = direction.x, DirectionY = direction.y, DirectionZ = direction.z,
                MaxDistance = Math.Min(maxDistance, float.MaxValue),
            };
            ReadOnlySpan<RayQuery> rays = stackalloc[] { query };
            Span<QueryHit> nearest = stackalloc QueryHit[1];
            // A hit that was destroyed since the latest frame must not hide a collider behind it.
            do
            {
                PreparedProxies()?.CastRays(rays, LayerFilters.Query(layers), nearest);
                hit = nearest[0].Proxy.IsNone ? null : colliders!.OwnerOf(nearest[0].Proxy);
            }
            while (!(hit is null) && hit == null && colliders!.Remove(hit!));
            distance = nearest[0].Distance;
            return !(hit is null);
        }

        private ProxySet? PreparedProxies()
        {
            ProxySet? proxies = Proxies;
            proxies?.PrepareQueries();
            return proxies;
        }

        /// <summary>Adds the colliders of the first hits to a list, without destroyed ones.</summary>
        private void AddOwners(ulong count, List<Collider> result)
        {
            for (int index = 0; index < (int)count; ++index)
            {
                if (ColliderOf(hits[index]) is Collider owner)
                    result.Add(owner);
            }
        }

        void IBroadPhaseSource.Search(BroadPhaseSession session)
        {
            if (colliders!.Proxies.IsDisposed)
                colliders.Restore();
            if (isEdited)
                ApplySettings();
            using (SweepstakeProfiling.Boxes.Auto())
                colliders.ReadBoxes();
            colliders.FindPairs(session);
        }

        void IBroadPhaseSource.Report() => colliders?.Pairs.Raise(endedListeners, beganListeners, this);

        bool IBroadPhaseSource.TryGetPair(int index, out Aabb a, out Aabb b)
        {
            a = b = default;
            if (colliders == null || index >= colliders.Pairs.OpenCount)
                return false;
            a = colliders.BoxOf(colliders.Pairs.Open(index).A);
            b = colliders.BoxOf(colliders.Pairs.Open(index).B);
            return true;
        }

        void IBroadPhaseSource.CopyBoxes(List<Aabb> boxes) => colliders?.CopyBoxes(boxes);

        /// <summary>Returns the tracker, or the first enabled one if it is null. Returns null if that tracker is not enabled.</summary>
        internal static ColliderTracker? EnabledOr(ColliderTracker? tracker)
        {
            if (tracker == null)
                return Trackers.Count > 0 ? Trackers[0] : null;
            return Trackers.Contains(tracker) ? tracker : null;
        }

        internal void Register(Collider collider, SweepstakeBody body) => colliders?.Add(collider, body, false);

        internal void AddPairs(Collider collider, List<ColliderPair> result)
        {
            TrackedCollider? end = Find(collider);
            for (TrackedPair? pair = end?.FirstPair; pair != null; pair = pair.NextOf(end!))
            {
                if (pair.IsOpen)
                    result.Add(new ColliderPair(collider, pair.Other(end!).Collider));
            }
        }

        private TrackedCollider? Find(Collider collider) => collider is null ? null : colliders?.Find(collider);

        private void OnEnable()
        {
            var manager = GetComponent<SweepstakeManager>();
            if (manager.Source != null)
            {
                Debug.LogError("Sweepstake: no colliders are tracked, because the manager already has another source.", this);
                return;
            }
            // The manager logs the problem and its remedy.
            if (SweepstakeLibrary.FindProblem() != null)
                return;
            filters.Read(layers, staticLayers, usesCollisionMatrix);
            colliders = new ColliderSet(filters);
            Trackers.Add(this);
            Scan();
            BindBodies();
            SceneManager.sceneLoaded += OnSceneLoaded;
            manager.Source = this;
        }

        private void OnDisable()
        {
            SceneManager.sceneLoaded -= OnSceneLoaded;
            var manager = GetComponent<SweepstakeManager>();
            if (manager != null && ReferenceEquals(manager.Source, this))
                manager.Source = null;
            colliders?.Dispose();
            colliders = null;
            if (Trackers.Remove(this))
                BindBodies();
        }

        /// <summary>Lets the next frame apply what was changed in the inspector during play.</summary>
        private void OnValidate() => isEdited = colliders != null;

        private void OnSceneLoaded(Scene scene, LoadSceneMode how)
        {
            if (scope == ColliderScope.LoadedScenes)
                Scan();
        }

        private static void BindBodies()
        {
            foreach (SweepstakeBody body in SweepstakeBody.Bodies)
                body.Bind();
        }

        private void Change(ref LayerMask field, LayerMask value)
        {
            field = value;
            ApplySettings();
        }

        private void ApplySettings()
        {
            isEdited = false;
            RefreshLayers();
            if (colliders == null)
                return;
            colliders.RemoveFound(IsWanted);
            Scan();
        }

        private void Scan(Scene scene)
        {
            if (!scene.isLoaded)
                return;
            scene.GetRootGameObjects(roots);
            foreach (GameObject root in roots)
                Scan(root);
        }

        private void Scan(GameObject root)
        {
            root.GetComponentsInChildren(true, found);
            foreach (Collider collider in found)
            {
                if (IsWanted(collider) && collider.GetComponentInParent<SweepstakeBody>(true) == null)
                    colliders?.Add(collider, null, true);
            }
        }

        /// <summary>Whether a scan tracks the collider, if no body does.</summary>
        private bool IsWanted(Collider collider)
        {
            bool isInScope = scope == ColliderScope.LoadedScenes || (scope == ColliderScope.Children && collider.transform.IsChildOf(transform));
            return isInScope && (layers.value & 1 << collider.gameObject.layer) != 0 && (collider.isTrigger || !findsTriggersOnly);
        }

        /// <summary>Resets the statics, which outlive play mode if domain reload is switched off.</summary>
        [RuntimeInitializeOnLoadMethod(RuntimeInitializeLoadType.SubsystemRegistration)]
        private static void BeginPlay()
        {
            Trackers.Clear();
            SweepstakeBody.Bodies.Clear();
        }
    }
}
