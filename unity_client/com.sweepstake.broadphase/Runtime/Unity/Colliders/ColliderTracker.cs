#nullable enable
using System;
using System.Collections.Generic;
using UnityEngine;
using UnityEngine.SceneManagement;

namespace Sweepstake.Unity
{
    /// <summary>Which colliders a <see cref="ColliderTracker"/> takes by itself.</summary>
    public enum ColliderScope
    {
        /// <summary>Those of all scenes that are loaded, or will be.</summary>
        LoadedScenes,
        /// <summary>Those of its own game object and below.</summary>
        Children,
        /// <summary>None: the game registers each.</summary>
        Registered,
    }

    /// <summary>
    /// Lets the manager beside it search in the boxes of colliders: triggers without physics, and queries. It tells which boxes begin and
    /// cease to overlap, for the layers that meet by the collision matrix. Rigidbodies go on as before: PhysX has its own broad phase. What
    /// is spawned later is to be registered, or found by <see cref="Scan()"/>.
    /// </summary>
    [AddComponentMenu("Sweepstake/Sweepstake Collider Tracker")]
    [RequireComponent(typeof(SweepstakeManager))]
    [DisallowMultipleComponent]
    [DocumentationPage("colliders.md")]
    public sealed class ColliderTracker : MonoBehaviour, IBroadPhaseSource
    {
        [SerializeField]
        [Tooltip("Which colliders are tracked without being registered.")]
        private ColliderScope scope = ColliderScope.LoadedScenes;
        [SerializeField]
        [Tooltip("The layers that are tracked.")]
        private LayerMask layers = ~0;
        [SerializeField]
        [Tooltip("On: layers meet by the collision matrix of the physics settings. Off: all tracked layers meet.")]
        private bool usesCollisionMatrix = true;
        [SerializeField]
        [Tooltip("Only colliders that are triggers are taken by themselves.")]
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

        /// <summary>Two boxes overlap since this frame. For their shapes ask Physics.ComputePenetration.</summary>
        public event Action<ColliderPair>? PairBegan { add => beganListeners.Add(value); remove => beganListeners.Remove(value); }
        /// <summary>Two boxes overlap no more, or one of the colliders was disabled, removed or destroyed.</summary>
        public event Action<ColliderPair>? PairEnded { add => endedListeners.Add(value); remove => endedListeners.Remove(value); }

        /// <summary>How many colliders are tracked.</summary>
        public int Count => colliders?.Count ?? 0;

        /// <summary>Null while it is not enabled. For queries of many at once, and from jobs.</summary>
        public ProxySet? Proxies => colliders?.Proxies;

        /// <summary>Changes hold at once.</summary>
        public LayerMask Layers
        {
            get => layers;
            set
            {
                layers = value;
                RefreshLayers();
            }
        }

        /// <summary>Tracks a collider, also one that its scope has not.</summary>
        /// <returns>False: it is tracked already, or this is not enabled.</returns>
        public bool Register(Collider collider) => colliders != null && collider != null && colliders.Add(collider);

        /// <returns>False: it is not tracked.</returns>
        public bool Unregister(Collider collider) => colliders != null && !(collider is null) && colliders.Remove(collider);

        public bool IsTracked(Collider collider) => colliders != null && colliders.Contains(collider);

        /// <summary>Reads a collider's layer, static flag and, if it is static, box again. Of a layer alone it takes notice by itself, if not at once.</summary>
        public void Refresh(Collider collider) => colliders?.Refresh(collider);

        /// <summary>Reads the collision matrix again, after Physics.IgnoreLayerCollision.</summary>
        public void RefreshLayers()
        {
            filters.Read(layers, usesCollisionMatrix);
            colliders?.RefreshFilters();
        }

        /// <summary>Registers what its scope has now.</summary>
        public void Scan()
        {
            if (scope == ColliderScope.Children)
                Scan(gameObject);
            for (int index = 0; scope == ColliderScope.LoadedScenes && index < SceneManager.sceneCount; ++index)
                Scan(SceneManager.GetSceneAt(index));
        }

        /// <summary>All tracked colliders whose boxes overlap this one, as of the latest frame. Replaces the list's content.</summary>
        public void OverlapBox(Bounds box, LayerMask layers, List<Collider> result) => queries?.Box(box, layers, result);

        /// <summary>All tracked colliders whose boxes the sphere touches.</summary>
        public void OverlapSphere(Vector3 center, float radius, LayerMask layers, List<Collider> result) => queries?.Sphere(center, radius, layers, result);

        /// <summary>The first tracked collider whose box the ray meets.</summary>
        /// <param name="distance">To its box; 0 if the ray starts inside.</param>
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
                Debug.LogError("Sweepstake: no colliders are tracked, because the manager has another source already.", this);
                return;
            }
            // The manager says so, with the remedy.
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
