#nullable enable
using UnityEngine;

namespace Sweepstake.Unity
{
    /// <summary>A collider of a <see cref="ColliderSet"/>. Its collider equals null once it is destroyed.</summary>
    internal sealed class TrackedCollider
    {
        internal TrackedCollider(Collider collider, SweepstakeBody? body, bool isFound)
        {
            Collider = collider;
            Object = collider.gameObject;
            Layer = Object.layer;
            Body = body;
            IsFound = isFound;
        }

        internal Collider Collider { get; }
        internal GameObject Object { get; }
        internal SweepstakeBody? Body { get; }
        /// <summary>Whether a scan found it, and the game did not register it.</summary>
        internal bool IsFound { get; set; }
        internal int Layer { get; set; }
        internal ProxyHandle Handle { get; set; }
        /// <summary>Index in the arrays of the set; it changes when other colliders come and go.</summary>
        internal int Slot { get; set; }
        /// <summary>Index in recordings, fixed while the collider is tracked.</summary>
        internal int Place { get; set; }
        internal TrackedPair? FirstPair { get; set; }
        internal int PairCount { get; set; }

        /// <summary>Whether both belong to one game object or one body.</summary>
        internal bool IsOfObjectOf(TrackedCollider other) => Object == other.Object || (!(Body is null) && ReferenceEquals(Body, other.Body));
    }

    /// <summary>
    /// Two colliders whose boxes overlap. It is an element of the lists of pairs of both colliders. A pair that is open has begun for the game.
    /// </summary>
    internal sealed class TrackedPair
    {
        private Links ofA;
        private Links ofB;

        internal TrackedCollider A { get; set; } = null!;
        internal TrackedCollider B { get; set; } = null!;
        internal int Index { get; set; }
        internal bool IsOpen { get; set; }
        internal bool IsDue { get; set; }

        internal TrackedPair? NextOf(TrackedCollider end) => LinksOf(end).Next;

        internal TrackedCollider Other(TrackedCollider end) => ReferenceEquals(end, A) ? B : A;

        /// <summary>Inserts the pair at the front of the list of one of its colliders.</summary>
        internal void Link(TrackedCollider end)
        {
            LinksOf(end) = new Links { Next = end.FirstPair };
            if (end.FirstPair != null)
                end.FirstPair.LinksOf(end).Previous = this;
            end.FirstPair = this;
            ++end.PairCount;
        }

        internal void Unlink(TrackedCollider end)
        {
            Links links = LinksOf(end);
            if (links.Previous == null)
                end.FirstPair = links.Next;
            else
                links.Previous.LinksOf(end).Next = links.Next;
            if (links.Next != null)
                links.Next.LinksOf(end).Previous = links.Previous;
            LinksOf(end) = default;
            --end.PairCount;
        }

        private ref Links LinksOf(TrackedCollider end) => ref ReferenceEquals(end, A) ? ref ofA : ref ofB;

        private struct Links
        {
            internal TrackedPair? Next;
            internal TrackedPair? Previous;
        }
    }
}
