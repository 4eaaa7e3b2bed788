#nullable enable
using System;
using System.Collections.Generic;
using UnityEngine;

namespace Sweepstake.Unity
{
    /// <summary>
    /// Two colliders whose boxes overlap. In an event of a body and in a list of one collider's pairs, A is the collider of that body or that
    /// collider; otherwise they are in no particular order. A destroyed collider equals null.
    /// </summary>
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
    /// The pairs of overlapping boxes, and their events. A pair is open, that is, it has begun for the game, while both colliders exist, belong
    /// to different objects, and Physics.IgnoreCollision does not exclude them. In steady state nothing allocates.
    /// </summary>
    internal sealed class ColliderPairs
    {
        /// <summary>Pairs per frame that are compared with Physics.IgnoreCollision; they take turns.</summary>
        private const int ReviewsPerFrame = 1024;

        private readonly Func<TrackedPair, bool> mayBegin;
        private readonly Stack<TrackedPair> unused = new Stack<TrackedPair>();
        private readonly List<TrackedPair> lasting = new List<TrackedPair>();
        private List<TrackedPair> due = new List<TrackedPair>();
        private List<TrackedPair> beginning = new List<TrackedPair>();
        private List<(TrackedCollider, TrackedCollider)> ended = new List<(TrackedCollider, TrackedCollider)>();
        private List<(TrackedCollider, TrackedCollider)> ending = new List<(TrackedCollider, TrackedCollider)>();
        // Open pairs come first.
        private TrackedPair[] pairs = new TrackedPair[64];
        private int count;
        private int nextReview;

        /// <param name="mayBegin">Checks the state of both colliders, and whether their layers collide.</param>
        internal ColliderPairs(Func<TrackedPair, bool> mayBegin) => this.mayBegin = mayBegin;

        internal int OpenCount { get; private set; }

        internal TrackedPair Open(int index) => pairs[index];

        internal void Add(TrackedCollider a, TrackedCollider b)
        {
            TrackedPair pair = unused.Count > 0 ? unused.Pop() : new TrackedPair();
            pair.A = a;
            pair.B = b;
            pair.Link(a);
            pair.Link(b);
            if (count == pairs.Length)
                Array.Resize(ref pairs, 2 * count);
            pair.Index = count;
            pairs[count++] = pair;
            Review(pair);
        }

        internal void Remove(TrackedCollider a, TrackedCollider b)
        {
            (TrackedCollider few, TrackedCollider other) = a.PairCount < b.PairCount ? (a, b) : (b, a);
            TrackedPair? pair = few.FirstPair;
            while (pair != null && !ReferenceEquals(pair.Other(few), other))
                pair = pair.NextOf(few);
            if (pair != null)
                Remove(pair);
        }

        internal void RemoveAllOf(TrackedCollider collider)
        {
            while (collider.FirstPair != null)
                Remove(collider.FirstPair);
        }

        internal void RemoveAll()
        {
            while (count > 0)
                Remove(pairs[count - 1]);
        }

        /// <summary>Opens or closes pairs for which Physics.IgnoreCollision has changed.</summary>
        internal void ReviewSome()
        {
            for (int review = Math.Min(ReviewsPerFrame, count); review > 0; --review)
            {
                if (nextReview >= count)
                    nextReview = 0;
                // A pair that closes moves behind the open ones, and another one takes its place.
                if (!Review(pairs[nextReview]))
                    ++nextReview;
            }
        }

        internal void ReviewAllOf(TrackedCollider collider)
        {
            for (TrackedPair? pair = collider.FirstPair; pair != null; pair = pair.NextOf(collider))
                Review(pair);
        }

        /// <summary>Raises the events of a frame: ends, beginnings, then lasting pairs. A listener may change and destroy colliders.</summary>
        internal void Raise(Listeners<ColliderPair> endListeners, Listeners<ColliderPair> beginListeners, UnityEngine.Object context)
        {
            (ended, ending) = (ending, ended);
            (due, beginning) = (beginning, due);
            for (int index = 0; index < OpenCount; ++index)
            {
                if (pairs[index].A.Body?.Stays.IsEmpty == false || pairs[index].B.Body?.Stays.IsEmpty == false)
                    lasting.Add(pairs[index]);
            }
            foreach ((TrackedCollider a, TrackedCollider b) in ending)
            {
                endListeners.Raise(new ColliderPair(a.Collider, b.Collider), context);
                a.Body?.Exits.Raise(new ColliderPair(a.Collider, b.Collider), a.Body);
                b.Body?.Exits.Raise(new ColliderPair(b.Collider, a.Collider), b.Body);
            }
            foreach (TrackedPair pair in beginning)
                Begin(pair, beginListeners, context);
            foreach (TrackedPair pair in lasting)
                RaiseOfBodies(pair, body => body.Stays);
            ending.Clear();
            beginning.Clear();
            lasting.Clear();
        }

        private void Begin(TrackedPair pair, Listeners<ColliderPair> beginListeners, UnityEngine.Object context)
        {
            bool isDue = pair.IsDue;
            pair.IsDue = false;
            if (!isDue || !Exist(pair))
                return;
            Swap(pair, pairs[OpenCount++]);
            pair.IsOpen = true;
            beginListeners.Raise(new ColliderPair(pair.A.Collider, pair.B.Collider), context);
            RaiseOfBodies(pair, body => body.Enters);
        }

        private static void RaiseOfBodies(TrackedPair pair, Func<SweepstakeBody, Listeners<ColliderPair>> listeners)
        {
            (TrackedCollider a, TrackedCollider b) = (pair.A, pair.B);
            // A listener may have destroyed a collider of the pair.
            if (pair.IsOpen && Exist(pair) && !(a.Body is null))
                listeners(a.Body).Raise(new ColliderPair(a.Collider, b.Collider), a.Body);
            if (pair.IsOpen && Exist(pair) && !(b.Body is null))
                listeners(b.Body).Raise(new ColliderPair(b.Collider, a.Collider), b.Body);
        }

        /// <returns>True if the pair was closed.</returns>
        private bool Review(TrackedPair pair)
        {
            bool isAllowed = Exist(pair) && !pair.A.IsOfObjectOf(pair.B) && !Physics.GetIgnoreCollision(pair.A.Collider, pair.B.Collider);
            if (pair.IsOpen && !isAllowed)
            {
                Close(pair);
                return true;
            }
            if (!pair.IsOpen && isAllowed != pair.IsDue)
            {
                pair.IsDue = isAllowed && mayBegin(pair);
                if (pair.IsDue)
                    due.Add(pair);
            }
            return false;
        }

        private void Remove(TrackedPair pair)
        {
            if (pair.IsOpen)
                Close(pair);
            pair.IsDue = false;
            pair.Unlink(pair.A);
            pair.Unlink(pair.B);
            Swap(pair, pairs[--count]);
            pairs[count] = null!;
            unused.Push(pair);
        }

        private void Close(TrackedPair pair)
        {
            ended.Add((pair.A, pair.B));
            pair.IsOpen = false;
            Swap(pair, pairs[--OpenCount]);
        }

        private void Swap(TrackedPair pair, TrackedPair other)
        {
            (pairs[pair.Index], pairs[other.Index]) = (other, pair);
            (pair.Index, other.Index) = (other.Index, pair.Index);
        }

        private static bool Exist(TrackedPair pair) => pair.A.Collider != null && pair.B.Collider != null;
    }
}
