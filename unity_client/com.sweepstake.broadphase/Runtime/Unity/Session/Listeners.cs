#nullable enable
using System;
using UnityEngine;

namespace Sweepstake.Unity
{
    /// <summary>
    /// Those who listen to an event. What one throws is logged, and the others are told all the same. Who comes or goes while it is told counts
    /// from the next time on. Only coming and going allocates.
    /// </summary>
    internal sealed class Listeners<T>
    {
        private Action<T>? combined;
        private Action<T>[] each = Array.Empty<Action<T>>();

        internal void Add(Action<T>? listener) => Set(combined + listener);

        internal void Remove(Action<T>? listener) => Set(combined - listener);

        internal void Tell(T told, UnityEngine.Object context)
        {
            foreach (Action<T> listener in each)
            {
                try
                {
                    listener(told);
                }
                catch (Exception problem)
                {
                    Debug.LogException(problem, context);
                }
            }
        }

        private void Set(Action<T>? listeners)
        {
            combined = listeners;
            Delegate[] parts = listeners?.GetInvocationList() ?? Array.Empty<Delegate>();
            each = Array.ConvertAll(parts, part => (Action<T>)part);
        }
    }
}
