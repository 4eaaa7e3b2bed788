#nullable enable
using System;

namespace Sweepstake.Unity
{
    /// <summary>
    /// A copy of the pairs that began or ended in a frame, because a listener may change the tracked colliders during the events.
    /// </summary>
    internal sealed class PairList
    {
        private ColliderPair[] pairs = new ColliderPair[64];
        private int count;

        internal void Take(ColliderSet colliders, ReadOnlySpan<ProxyPair> taken)
        {
            Array.Clear(pairs, 0, count);
            count = taken.Length;
            if (count > pairs.Length)
                pairs = new ColliderPair[Math.Max(count, pairs.Length * 2)];
            for (int index = 0; index < count; ++index)
                pairs[index] = new ColliderPair(colliders.OwnerOf(taken[index].A), colliders.OwnerOf(taken[index].B));
        }

        internal void Tell(Listeners<ColliderPair> listeners, UnityEngine.Object context)
        {
            for (int index = 0; index < count; ++index)
                listeners.Tell(pairs[index], context);
        }
    }
}
