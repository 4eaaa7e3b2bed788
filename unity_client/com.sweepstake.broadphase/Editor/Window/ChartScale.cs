#nullable enable
using System;
using System.Collections.Generic;
using System.Globalization;

namespace Sweepstake.Editor
{
    /// <summary>The scale of a chart: from 0 to a round number that is at least the maximum of the series.</summary>
    internal readonly struct ChartScale
    {
        private ChartScale(float max) => Max = max;

        /// <summary>The upper end of the scale; 0 if there are no values to show.</summary>
        internal float Max { get; }
        internal bool IsEmpty => Max <= 0;

        internal static ChartScale Of(Series series)
        {
            float max = 0;
            bool hasValue = false;
            for (int index = 0; index < series.Count; ++index)
            {
                float value = series[index];
                if (!IsShown(value))
                    continue;
                hasValue = true;
                max = Math.Max(max, value);
            }
            return new ChartScale(hasValue ? RoundUp(max) : 0);
        }

        /// <summary>Whether a value is drawn: it is finite and not negative.</summary>
        internal static bool IsShown(float value) => value >= 0 && value < float.PositiveInfinity;

        /// <summary>The height of a value in the chart: 0 at the bottom, 1 at the top.</summary>
        internal float HeightOf(float value) => IsEmpty ? 0 : Math.Min(value / Max, 1);

        internal string Label(string unit) => Max.ToString("0.###", CultureInfo.InvariantCulture) + (unit.Length > 0 ? " " + unit : "");

        /// <summary>The ranges of values between gaps: [begin, end).</summary>
        internal static IEnumerable<(int Begin, int End)> Runs(Series series)
        {
            int begin = -1;
            for (int index = 0; index <= series.Count; ++index)
            {
                bool isShown = index < series.Count && IsShown(series[index]);
                if (isShown && begin < 0)
                    begin = index;
                if (isShown || begin < 0)
                    continue;
                yield return (begin, index);
                begin = -1;
            }
        }

        /// <summary>The smallest of 1, 2 or 5 times a power of ten that is at least the value.</summary>
        private static float RoundUp(float value)
        {
            if (value <= 0)
                return 1;
            double power = Math.Pow(10, Math.Floor(Math.Log10(value)));
            foreach (int factor in new[] { 1, 2, 5 })
            {
                if (factor * power >= value * (1 - 1e-6))
                    return (float)(factor * power);
            }
            return (float)(10 * power);
        }
    }
}
