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
    /// Lets the manager on the same object search the boxes of colliders, for triggers without physics and for queries. It raises events
    /// when boxes begin or cease to overlap, for layers that collide in the collision matrix. Rigidbodies are not affected: PhysX has its
    /// own broad phase. Objects that are spawned later must be registered, or found with <see cref="Scan()"/>.
    /// </summary>
    [AddComponentMenu("Sweepstake/Sweepstake Collider Tracker")]
    [RequireComponent(typeof(SweepstakeManager))]
    [DisallowMultipleComponent]
    [DocumentationPage("colliders.md")]
    public sealed class ColliderTracker : MonoBehaviour, IBroadPhaseSource
    {
        [SerializeField]
        [Tooltip("Which colliders are tracked automatically, without being registered.")]
        private ColliderScope scope = ColliderScope.LoadedScenes;
        [SerializeField]
        [Tooltip("The layers that are tracked.")]
        private LayerMask layers = ~0;
        [SerializeField]
        [Tooltip("On: only layers that collide in the collision matrix of the physics settings form pairs. Off: all tracked layers do.")]
        private bool usesCollisionMatrix = true;
        [SerializeField]
        [Tooltip("Tracks only triggers automatically.")]
        private bool findsTriggersOnly = false;

        private readonly LayerFilters filters = new LayerFilters();
        private readonly PairList began = new PairList();
        private readonly PairList ended = new PairList();
        private readonly List<Collider> found = new List<Collider>();
        private readonly List<GameObject> roots = new List<GameObject>();
        private readonly Listeners<ColliderPair> beganListeners = new Listeners<ColliderPair>();
        private readonly Listeners<ColliderPair> endedListeners = new Listeners<ColliderPair>();
        private ColliderSet? colliders;
        private ColliderQueries? queries;

        /// <summary>Raised when two boxes begin to overlap. Use Physics.ComputePenetration to test the shapes.</summary>
        public event Action<ColliderPair>? PairBegan { add => beganListeners.Add(value); remove => beganListeners.Remove(value); }
        /// <summary>Raised when two boxes no longer overlap, or one of the colliders was disabled, removed or destroyed.</summary>
        public event Action<ColliderPair>? PairEnded { add => endedListeners.Add(value); remove => endedListeners.Remove(value); }

        /// <summary>The number of tracked colliders.</summary>
        public int Count => colliders?.Count ?? 0;

        /// <summary>The underlying proxy set, for many queries at once and for jobs. Null while the tracker is disabled.</summary>
        public ProxySet? Proxies => colliders?.Proxies;

        /// <summary>The tracked layers. A change takes effect at once.</summary>
        public LayerMask Layers
        {
            get => layers;
            set
            {
                layers = value;
                RefreshLayers();
            }
        }

        /// <summary>Tracks a collider, also one outside the tracker's scope.</summary>
        /// <returns>False if it is already tracked or the tracker is disabled.</returns>
        public bool Register(Collider collider) => colliders != null && collider != null && colliders.Add(collider);

        /// <returns>False if it is not tracked.</returns>
        public bool Unregister(Collider collider) => colliders != null && !(collider is null) && colliders.Remove(collider);

        public bool IsTracked(Collider collider) => colliders != null && colliders.Contains(collider);

        /// <summary>
        /// Reads a collider's layer and static flag again, and the box of a static collider. Changes of the layer are also noticed
        /// automatically after some frames.
        /// </summary>
        public void Refresh(Collider collider) => colliders?.Refresh(collider);

        /// <summary>Reads the collision matrix again; call it after Physics.IgnoreLayerCollision.</summary>
        public void RefreshLayers()
        {
            filters.Read(layers, usesCollisionMatrix);
            colliders?.RefreshFilters();
        }

        /// <summary>Registers all colliders in the tracker's scope.</summary>
        public void Scan()
        {
            if (scope == ColliderScope.Children)
                Scan(gameObject);
            for (int index = 0; scope == ColliderScope.LoadedScenes && index < SceneManager.sceneCount; ++index)
                Scan(SceneManager.GetSceneAt(index));
        }

        /// <summary>Finds all tracked colliders whose boxes overlapped this box in the latest frame. Replaces the list's content.</summary>
        public void OverlapBox(Bounds box, LayerMask layers, List<Collider> result) => queries?.Box(box, layers, result);

        /// <summary>Finds all tracked colliders whose boxes touch the sphere.</summary>
        public void OverlapSphere(Vector3 center, float radius, LayerMask layers, List<Collider> result) => queries?.Sphere(center, radius, layers, result);

        /// <summary>Finds the nearest tracked collider whose box the ray hits.</summary>
        /// <param name="distance">Distance to the box; 0 if the ray starts inside.</param>
        public bool Raycast(Ray ray, float maxDistance, LayerMask layers, out Collider? hit, out float distance)
        {
            hit = null;
            distance = 0;
            return queries != null && queries.Ray(ray, maxDistance, layers, out hit, out distance);
        }

        void IBroadPhaseSource.Search(BroadPhaseSession session)
        {
            using (SweepstakeProfiling.Boxes.Auto())
                colliders!.ReadBoxes();
            colliders.FindPairs(session);
        }

        void IBroadPhaseSource.Report()
        {
            if (colliders == null)
                return;
            began.Take(colliders, colliders.Proxies.Added);
            ended.Take(colliders, colliders.Proxies.Removed);
            colliders.ForgetRemoved();
            ended.Tell(endedListeners, this);
            began.Tell(beganListeners, this);
        }

        bool IBroadPhaseSource.TryGetPair(int index, out Aabb a, out Aabb b)
        {
            a = b = default;
            if (colliders == null || !colliders.HasPairs || index >= colliders.Proxies.Pairs.Length)
                return false;
            OverlapPair pair = colliders.Proxies.Pairs[index];
            a = colliders.Proxies.Get(colliders.Proxies.HandleOf(pair.A), out _);
            b = colliders.Proxies.Get(colliders.Proxies.HandleOf(pair.B), out _);
            return true;
        }

        void IBroadPhaseSource.CopyBoxes(List<Aabb> boxes) => colliders?.CopyBoxes(boxes);

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
            filters.Read(layers, usesCollisionMatrix);
            colliders = new ColliderSet(filters);
            queries = new ColliderQueries(colliders);
            Scan();
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
            queries = null;
        }

        private void OnSceneLoaded(Scene scene, LoadSceneMode how)
        {
            if (scope == ColliderScope.LoadedScenes)
                Scan(scene);
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
                bool isOfLayer = (layers.value & 1 << collider.gameObject.layer) != 0;
                if (isOfLayer && (collider.isTrigger || !findsTriggersOnly))
                    Register(collider);
            }
        }
    }
}
