#nullable enable
using System;
using System.Collections.Generic;
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
}
