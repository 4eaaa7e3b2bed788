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

        [SerializeField]
        private float[] values = new float[Capacity];
        [SerializeField]
        private int next;
        [SerializeField]
        private int count;

        internal int Count => count;

        internal float this[int index] => values[(next - count + index + Capacity) % Capacity];

        internal void Add(float value)
        {
            values[next] = value;
            next = (next + 1) % Capacity;
            count = Math.Min(count + 1, Capacity);
        }
    }

    /// <summary>
    /// One minute of a game, with ten values a second. The values stay after play mode ends, until play mode begins again.
    /// </summary>
    [Serializable]
    internal sealed class LiveHistory
    {
        internal const int RateHz = 10;

        [SerializeField]
        private Series fps = new Series();
        [SerializeField]
        private Series detectionMs = new Series();
        [SerializeField]
        private Series pairs = new Series();
        [SerializeField]
        private Series roundTripMs = new Series();
        [SerializeField]
        private Series backend = new Series();
        [SerializeField]
        private string[] backends = Array.Empty<string>();

        internal Series Fps => fps;
        internal Series DetectionMs => detectionMs;
        internal Series Pairs => pairs;
        internal Series RoundTripMs => roundTripMs;
        /// <summary>The active backend, as an index in <see cref="Backends"/>.</summary>
        internal Series Backend => backend;
        internal string[] Backends => backends;

        /// <param name="named">The names of the backends.</param>
        internal void Add(float framesPerSecond, in FrameSample sample, float roundTrip, string[] named)
        {
            backends = named;
            fps.Add(framesPerSecond);
            detectionMs.Add(sample.ObjectCount == 0 ? float.NaN : sample.DetectionTimeNs / 1e6f);
            pairs.Add(sample.PairCount);
            roundTripMs.Add(roundTrip);
            backend.Add(sample.Arm);
        }
    }
}
