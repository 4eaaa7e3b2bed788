#nullable disable
using System;
using System.Diagnostics;
using System.IO;
using System.Linq;
using NUnit.Framework;

namespace Sweepstake.Tests
{
    /// <summary>Tests that the end of a decider does not wait for a disk that does not answer, and that nothing is lost.</summary>
    public sealed class SlowDiskTest
    {
        private const ulong FrameNs = 16_666_667;
        private string folder;

        [SetUp]
        public void MakeFolder()
        {
            folder = Directory.CreateTempSubdirectory("sweepstake").FullName;
        }

        [TearDown]
        public void RemoveFolder()
        {
            Directory.Delete(folder, true);
        }

        [Test]
        public void AnEndDoesNotWaitForTheDiskAndTheNextDeciderContinuesFromMemory()
        {
            SavedPriors saved = Open();
            // Opening a pipe for writing blocks until there is a reader.
            string pipe = saved.Path + ".tmp";
            Start("mkfifo", pipe).WaitForExit();
            using var session = new BroadPhaseSession(new SessionOptions { SettlingNs = 1, Shadow = ShadowMode.Off });
            using var scene = Oracle.CrowdedScene("hurricane");
            var decider = new EmbeddedDecider(session, Options(saved));
            Eventually.Is(() => Sum(decider) > 20, () => "learnt", () => Play(session, scene));
            decider.BeginSave();
            Eventually.Is(() => saved.Unwritten != null, () => "writing");
            Play(session, scene);
            Assert.That(decider.Stop(0), Is.False, "the thread still waits for the disk");
            byte[] kept = saved.Unwritten;

            using (var next = new BroadPhaseSession(new SessionOptions { Shadow = ShadowMode.Off }))
            using (var continued = new EmbeddedDecider(next, Options(Open()), ownThread: false))
                Assert.That(Sum(continued), Is.GreaterThan(20));
            using Process reader = Start("cat", pipe);
            using var read = new MemoryStream();
            reader.StandardOutput.BaseStream.CopyTo(read);
            Assert.That(read.ToArray(), Is.EqualTo(kept));
            Eventually.Is(() => saved.Unwritten == null, () => "written");
            Assert.That(File.Exists(saved.Path), Is.True);
        }

        private SavedPriors Open() => SavedPriors.Open(folder, "default", "default", "pc");

        private static DeciderOptions Options(SavedPriors saved) => new DeciderOptions { Policy = "paper", TimeScale = 1000, Saved = saved };

        private static double Sum(EmbeddedDecider decider) => decider.Status.Beliefs.ToArray().Sum(belief => belief.Alpha + belief.Beta);

        private static void Play(BroadPhaseSession session, MotionScene scene)
        {
            scene.Step();
            session.BeginFrame();
            session.FindPairs(scene.Boxes);
            session.EndFrame(FrameNs);
        }

        private static Process Start(string program, string path) =>
            Process.Start(new ProcessStartInfo(program, new[] { path }) { RedirectStandardOutput = true });
    }
}
