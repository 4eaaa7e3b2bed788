#nullable disable
using NUnit.Framework;
using Sweepstake.Editor;

namespace Sweepstake.Tests
{
    public sealed class ChartScaleTest
    {
        [Test]
        public void AScaleIsRoundAndPassesOverGaps()
        {
            foreach ((float value, float max) in new[] { (0f, 1f), (0.04f, 0.05f), (1f, 1f), (1.01f, 2f), (16.7f, 20f), (60f, 100f), (2e9f, 2e9f) })
                Assert.That(ChartScale.Of(SeriesOf(float.NaN, value, float.PositiveInfinity, -5)).Max, Is.EqualTo(max).Within(max * 1e-5), $"{value}");
            Assert.That(ChartScale.Of(new Series()).IsEmpty, Is.True);
            Assert.That(ChartScale.Of(SeriesOf(float.NaN)).IsEmpty, Is.True);
            Assert.That(ChartScale.Of(SeriesOf(12)).Label("ms"), Is.EqualTo("20 ms"));
            Assert.That(
                ChartScale.Runs(SeriesOf(1, 2, float.NaN, 3, float.NaN, float.NaN, 4, 5)), Is.EqualTo(new[] { (0, 2), (3, 4), (6, 8) }));
            Assert.That(ChartScale.Runs(SeriesOf(float.NaN, float.NaN)), Is.Empty);
        }

        [Test]
        public void AFullSeriesForgetsTheOldest()
        {
            var series = new Series();
            for (int value = 0; value < Series.Capacity + 5; ++value)
                series.Add(value);
            Assert.That(series.Count, Is.EqualTo(Series.Capacity));
            Assert.That(series[0], Is.EqualTo(5));
            Assert.That(series[Series.Capacity - 1], Is.EqualTo(Series.Capacity + 4));
        }

        private static Series SeriesOf(params float[] values)
        {
            var series = new Series();
            foreach (float value in values)
                series.Add(value);
            return series;
        }
    }
}
