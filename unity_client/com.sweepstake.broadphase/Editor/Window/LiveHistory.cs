#nullable enable
using System;
using UnityEngine;

namespace Sweepstake.Editor
{
    /// <summary>The latest values of one quantity, oldest first; NaN is a gap. Unity keeps it over a domain reload.</summary>
    [Serializable]
    internal sealed class Series
    {
        internal const int Capacity = 600;

        [SerializeField] private float[] values = new float[Capacity];
        [SerializeField] private int next;

        [field: SerializeField] internal int Count { get; private set; }

        internal float this[int index] => values[(next - Count + index + Capacity) % Capacity];

        internal void Add(float value)
        {
            values[next] = value;
            next = (next + 1) % Capacity;
            Count = Math.Min(Count + 1, Capacity);
        }
    }

    /// <summary>One minute of a game, with ten values a second. The values stay after play mode ends, until play mode begins again.</summary>
    [Serializable]
    internal sealed class LiveHistory
    {
        internal const int RateHz = 10;

        [field: SerializeField] internal Series Fps { get; private set; } = new Series();
        [field: SerializeField] internal Series DetectionMs { get; private set; } = new Series();
        [field: SerializeField] internal Series Pairs { get; private set; } = new Series();
        [field: SerializeField] internal Series RoundTripMs { get; private set; } = new Series();
        /// <summary>The active backend, as an index in <see cref="Backends"/>.</summary>
        [field: SerializeField] internal Series Backend { get; private set; } = new Series();
        [field: SerializeField] internal string[] Backends { get; private set; } = Array.Empty<string>();

        internal void Add(float framesPerSecond, in FrameSample sample, float roundTrip, string[] backends)
        {
            Backends = backends;
            Fps.Add(framesPerSecond);
            DetectionMs.Add(sample.ObjectCount == 0 ? float.NaN : sample.DetectionTimeNs / 1e6f);
            Pairs.Add(sample.PairCount);
            RoundTripMs.Add(roundTrip);
            Backend.Add(sample.Arm);
        }
    }
}
