#nullable enable
using System;
using UnityEngine;

namespace Sweepstake.Unity
{
    /// <summary>
    /// The listeners of an event. An exception of one listener is logged, and the others are still called. Adding or removing a listener during
    /// the event takes effect at the next one. Only adding and removing allocate.
    /// </summary>
    internal sealed class Listeners<T>
    {
        private Action<T>? combined;
        private Action<T>[] each = Array.Empty<Action<T>>();

        internal bool IsEmpty => each.Length == 0;

        internal void Add(Action<T>? listener) => Set(combined + listener);

        internal void Remove(Action<T>? listener) => Set(combined - listener);

        internal void Raise(T value, UnityEngine.Object context)
        {
            foreach (Action<T> listener in each)
            {
                try
                {
                    listener(value);
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
