#nullable enable
using System;
using System.Collections.Generic;
using UnityEngine;

namespace Sweepstake.Unity
{
    /// <summary>
    /// Tracks the colliders of its game object and of the objects below it while it is enabled, and raises the events of their pairs. Colliders
    /// of one body never form a pair. An object below with a body of its own is a separate body.
    /// </summary>
    [AddComponentMenu("Sweepstake/Sweepstake Body")]
    [DisallowMultipleComponent]
    [DocumentationPage("colliders.md")]
    public sealed class SweepstakeBody : MonoBehaviour
    {
        [Tooltip("The tracker that searches the colliders. None: the tracker that was enabled first.")]
        [SerializeField] private ColliderTracker? tracker;

        private readonly List<Collider> colliders = new List<Collider>();
        private ColliderTracker? user;

        /// <summary>Raised when the box of a collider of this body (A) begins to overlap that of another collider (B).</summary>
        public event Action<ColliderPair>? TriggerEnter { add => Enters.Add(value); remove => Enters.Remove(value); }
        /// <summary>Raised in each later frame in which the boxes overlap.</summary>
        public event Action<ColliderPair>? TriggerStay { add => Stays.Add(value); remove => Stays.Remove(value); }
        /// <summary>
        /// Raised when the boxes no longer overlap, and when one of the colliders or bodies was disabled or destroyed. Each pair that entered
        /// exits, unless the tracker was disabled before.
        /// </summary>
        public event Action<ColliderPair>? TriggerExit { add => Exits.Add(value); remove => Exits.Remove(value); }

        /// <summary>The tracker that searches this body; null while there is none.</summary>
        public ColliderTracker? Tracker
        {
            get => user;
            set
            {
                tracker = value;
                OnValidate();
            }
        }

        /// <summary>The colliders of the body when it was enabled or refreshed.</summary>
        public IReadOnlyList<Collider> Colliders => colliders;
        internal Listeners<ColliderPair> Enters { get; } = new Listeners<ColliderPair>();
        internal Listeners<ColliderPair> Stays { get; } = new Listeners<ColliderPair>();
        internal Listeners<ColliderPair> Exits { get; } = new Listeners<ColliderPair>();
        internal static HashSet<SweepstakeBody> Bodies { get; } = new HashSet<SweepstakeBody>();

        /// <summary>
        /// Replaces the content of the list with the pairs that have begun and not ended. Allocates nothing if the capacity of the list suffices.
        /// </summary>
        public void CopyPairs(List<ColliderPair> result)
        {
            result.Clear();
            foreach (Collider collider in colliders)
                user?.AddPairs(collider, result);
        }

        /// <summary>
        /// Reads the body again: colliders that were added or removed, layers, shapes, and the boxes of static layers. Pairs that last do not end.
        /// </summary>
        public void Refresh()
        {
            if (user == null)
                return;
            var current = new List<Collider>();
            GetComponentsInChildren(true, current);
            current.RemoveAll(collider => collider.GetComponentInParent<SweepstakeBody>(true) != this);
            foreach (Collider collider in colliders)
            {
                if (!current.Contains(collider))
                    user.Unregister(collider);
            }
            foreach (Collider collider in current)
                user.Register(collider, this);
            colliders.Clear();
            colliders.AddRange(current);
        }

        /// <summary>Moves the body to its tracker, if that tracker is enabled.</summary>
        internal void Bind()
        {
            ColliderTracker? next = ColliderTracker.EnabledOr(tracker);
            if (ReferenceEquals(next, user))
                return;
            Unbind();
            user = next;
            Refresh();
        }

        private void OnEnable()
        {
            Bodies.Add(this);
            Bind();
        }

        private void OnDisable()
        {
            Bodies.Remove(this);
            Unbind();
        }

        /// <summary>Applies another tracker, which may also be selected in the inspector during play.</summary>
        private void OnValidate()
        {
            if (Bodies.Contains(this))
                Bind();
        }

        private void Unbind()
        {
            foreach (Collider collider in colliders)
                user?.Unregister(collider);
            colliders.Clear();
            user = null;
        }
    }
}
