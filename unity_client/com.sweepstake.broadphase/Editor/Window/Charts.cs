#nullable enable
using System;
using System.Collections.Generic;
using System.Globalization;
using System.Linq;
using UnityEngine;
using UnityEngine.UIElements;

namespace Sweepstake.Editor
{
    /// <summary>A chart of one minute of a series, with the newest value at the right and labelled axes.</summary>
    internal abstract class Chart : VisualElement
    {
        private readonly Label empty = new Label("No values yet");

        protected Chart(string title)
        {
            var heading = new Label(title);
            heading.AddToClassList("sweepstake-title");
            Add(heading);
            Plot.AddToClassList("sweepstake-chart");
            Plot.generateVisualContent += Draw;
            empty.AddToClassList("sweepstake-empty");
            Plot.Add(empty);
            Plot.Add(Axis($"−{Series.Capacity / LiveHistory.RateHz} s … now", "bottom"));
            Add(Plot);
        }

        protected VisualElement Plot { get; } = new VisualElement();
        protected Series Shown { get; private set; } = new Series();

        internal void Show(Series series)
        {
            Shown = series;
            empty.style.display = IsEmpty() ? DisplayStyle.Flex : DisplayStyle.None;
            Plot.MarkDirtyRepaint();
        }

        protected abstract bool IsEmpty();
        protected abstract void Draw(MeshGenerationContext context);

        /// <summary>Horizontal position of a value. A full series fills the width of the chart, a shorter one only the right part.</summary>
        protected float XOf(int index) => Plot.contentRect.width * (index + Series.Capacity - Shown.Count) / (Series.Capacity - 1);

        protected static Label Axis(string text, string place)
        {
            var label = new Label(text);
            label.AddToClassList("sweepstake-axis");
            label.AddToClassList("sweepstake-axis--" + place);
            return label;
        }
    }

    internal sealed class LineChart : Chart
    {
        private static readonly Color Line = new Color(0.25f, 0.55f, 0.95f);
        private readonly string unit;
        private readonly Label top = Axis("", "top");
        private ChartScale scale;

        internal LineChart(string title, string unit)
            : base(unit.Length > 0 ? $"{title} ({unit})" : title)
        {
            this.unit = unit;
            Plot.Add(top);
        }

        protected override bool IsEmpty()
        {
            scale = ChartScale.Of(Shown);
            top.text = scale.IsEmpty ? "" : scale.Label(unit);
            return scale.IsEmpty;
        }

        protected override void Draw(MeshGenerationContext context)
        {
            Painter2D painter = context.painter2D;
            painter.strokeColor = Line;
            painter.lineWidth = 1.5f;
            foreach ((int begin, int end) in ChartScale.Runs(Shown))
            {
                painter.BeginPath();
                painter.MoveTo(PointOf(begin));
                // Draw a single value as a short line.
                painter.LineTo(PointOf(begin) + Vector2.right);
                for (int index = begin + 1; index < end; ++index)
                    painter.LineTo(PointOf(index));
                painter.Stroke();
            }
        }

        private Vector2 PointOf(int index) => new Vector2(XOf(index), Plot.contentRect.height * (1 - scale.HeightOf(Shown[index])));
    }

    /// <summary>The active backend over time: a colour for each backend, with a legend.</summary>
    internal sealed class BackendChart : Chart
    {
        private readonly VisualElement legend = new VisualElement();
        private string[] named = Array.Empty<string>();

        internal BackendChart()
            : base("Backend")
        {
            legend.AddToClassList("sweepstake-row");
            Add(legend);
        }

        internal void Name(IReadOnlyList<string> backends)
        {
            if (backends.SequenceEqual(named))
                return;
            named = backends.ToArray();
            legend.Clear();
            for (int index = 0; index < backends.Count; ++index)
            {
                var label = new Label("■ " + backends[index]);
                label.style.color = ColorOf(index);
                legend.Add(label);
            }
        }

        protected override bool IsEmpty() => Shown.Count == 0;

        protected override void Draw(MeshGenerationContext context)
        {
            Painter2D painter = context.painter2D;
            for (int begin = 0; begin < Shown.Count;)
            {
                int end = begin + 1;
                while (end < Shown.Count && Shown[end] == Shown[begin])
                    ++end;
                painter.fillColor = ColorOf((int)Shown[begin]);
                Fill(painter, XOf(begin), XOf(end));
                begin = end;
            }
        }

        private void Fill(Painter2D painter, float left, float right)
        {
            float bottom = Plot.contentRect.height;
            painter.BeginPath();
            painter.MoveTo(new Vector2(left, bottom * 0.3f));
            painter.LineTo(new Vector2(right, bottom * 0.3f));
            painter.LineTo(new Vector2(right, bottom * 0.7f));
            painter.LineTo(new Vector2(left, bottom * 0.7f));
            painter.ClosePath();
            painter.Fill();
        }

        /// <summary>A colour per backend, of medium brightness, so that it is visible in both themes.</summary>
        private static Color ColorOf(int index) => Color.HSVToRGB(index * 0.381966f % 1, 0.65f, 0.75f);
    }

    /// <summary>The scale of a chart: from 0 to a round number that is at least the maximum of the series.</summary>
    internal readonly struct ChartScale
    {
        private ChartScale(float max) => Max = max;

        /// <summary>The upper end of the scale; 0 if there are no values to show.</summary>
        internal float Max { get; }
        internal bool IsEmpty => Max <= 0;

        internal static ChartScale Of(Series series)
        {
            float max = -1;
            for (int index = 0; index < series.Count; ++index)
            {
                if (IsShown(series[index]))
                    max = Math.Max(max, series[index]);
            }
            return new ChartScale(max < 0 ? 0 : RoundUp(max));
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
