#nullable enable
using System;
using UnityEngine;

namespace Sweepstake.Unity
{
    /// <summary>The pairs that began or ended in a frame, kept while they are told: who is told may change what is tracked.</summary>
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

        /// <summary>What a listener throws is logged, and the others are told all the same.</summary>
        internal void Raise(Action<ColliderPair>? listeners, UnityEngine.Object context)
        {
            if (listeners == null)
                return;
            for (int index = 0; index < count; ++index)
            {
                try
                {
                    listeners(pairs[index]);
                }
                catch (Exception problem)
                {
                    Debug.LogException(problem, context);
                }
            }
        }
    }
}
