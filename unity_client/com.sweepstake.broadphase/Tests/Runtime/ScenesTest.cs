#nullable enable
using NUnit.Framework;

namespace Sweepstake.Tests
{
    public sealed class ScenesTest
    {
        [Test]
        public void TheFiveScenariosComeFirst()
        {
            Assert.That(SweepstakeLibrary.Scenes[0], Is.EqualTo("brownian"));
            foreach (string scenario in new[] { "rotating-gravity", "hurricane", "free-fall", "random-gravity" })
                Assert.That(SweepstakeLibrary.Scenes, Does.Contain(scenario));
        }

        [Test]
        public void OneSeedGivesTheSameHashAndAnotherSeedAnotherOne()
        {
            Assert.That(HashOf(1), Is.EqualTo(HashOf(1)));
            Assert.That(HashOf(1), Is.Not.EqualTo(HashOf(2)));
        }

        [Test]
        public void OptionsReachTheScene()
        {
            SceneOptions options = SceneOptions.Default;
            Assert.That(options.FixedStepS, Is.EqualTo(1F / 60F));
            Assert.That(options.HalfExtentMax, Is.EqualTo(2.5F));
            options.ObjectCount = 17;
            options.WorldHalfExtent = 30;
            using var scene = new MotionScene("free-fall", options);
            Assert.That(scene.Boxes.Length, Is.EqualTo(17));
            Assert.That(scene.World.MinX, Is.EqualTo(-30));
            Assert.That(scene.World.MaxZ, Is.EqualTo(30));
            scene.Step();
            Assert.That(scene.FrameIndex, Is.EqualTo(1));
        }

        [Test]
        public void AnUnknownSceneAndAWrongValueAreRefused()
        {
            var unknown = Assert.Throws<SweepstakeException>(() => new MotionScene("huricane"));
            Assert.That(unknown!.Code, Is.EqualTo(ResultCode.NotFound));
            Assert.That(unknown.Message, Does.Contain("hurricane"));
            SceneOptions options = SceneOptions.Default;
            options.FixedStepS = -1;
            Assert.That(Assert.Throws<SweepstakeException>(() => new MotionScene("brownian", options))!.Code, Is.EqualTo(ResultCode.InvalidArgument));
        }

        private static ulong HashOf(ulong seed)
        {
            SceneOptions options = SceneOptions.Default;
            options.SpawnSeed = seed;
            options.ObjectCount = 500;
            using var scene = new MotionScene("hurricane", options);
            for (int step = 0; step < 100; ++step)
                scene.Step();
            return scene.Hash;
        }
    }
}
