#nullable enable
using System;
using System.Globalization;
using System.IO;
using System.Linq;
using System.Text.RegularExpressions;
using NUnit.Framework;

namespace Sweepstake.Tests
{
    /// <summary>Tests that learning continues over the ends of deciders, and that no file is lost.</summary>
    public sealed class SavedPriorsTest
    {
        private const ulong FrameNs = 16_666_667;
        private string folder = "";

        [SetUp]
        public void MakeFolder()
        {
            folder = Path.Combine(Path.GetTempPath(), "sweepstake_" + Guid.NewGuid().ToString("N"));
        }

        [TearDown]
        public void RemoveFolder()
        {
            if (Directory.Exists(folder))
                Directory.Delete(folder, true);
        }

        [Test]
        public void TheNextDeciderBeginsWithAllThatWasLearnt()
        {
            double learnt = Play(Open(), 1200);
            Assert.That(learnt, Is.GreaterThan(20));
            Assert.That(BeliefsOf(Open()), Is.EqualTo(learnt).Within(1e-6));
            double more = Play(Open(), 1200);
            Assert.That(more, Is.GreaterThan(learnt + 20), "one source grows from run to run");

            // This process has not used the other folder yet, so it is read as after a restart.
            string copy = folder + "/copy";
            Directory.CreateDirectory(copy);
            File.Copy(Files().Single(), Path.Combine(copy, Path.GetFileName(Files().Single())));
            Assert.That(BeliefsOf(SavedPriors.Open(copy, "p", "level 1", "pc")), Is.EqualTo(more).Within(1e-6));
            string text = File.ReadAllText(Files().Single());
            Assert.That(text, Does.Contain("\"format\":\"sweepstake-priors\"").And.Contain("\"version\":1"), "the format of `sweepstake priors`");
        }

        /// <summary>The default policy does not assume that a later run has the same level of costs, so its certainty is limited.</summary>
        [Test]
        public void AiDecidesIsMoreCertainWithWhatWasLearntAndTheFileKeepsAllEvidence()
        {
            double fresh = Play(Open(), 0, "adaptive");
            Play(Open(), 1200, "adaptive");
            double evidence = EvidenceIn(Files().Single());
            Assert.That(BeliefsOf(Open(), "adaptive"), Is.GreaterThan(2 * fresh));
            Play(Open(), 1200, "adaptive");
            Assert.That(EvidenceIn(Files().Single()), Is.GreaterThan(evidence));
        }

        [Test]
        public void ScenesAndDevicesHaveFilesOfTheirOwn()
        {
            double learnt = Play(Open(), 1200);
            foreach (SavedPriors other in new[] { SavedPriors.Open(folder, "p", "level 2", "pc"), SavedPriors.Open(folder, "p", "level 1", "phone"), SavedPriors.Open(folder, "q", "level 1", "pc") })
                Assert.That(BeliefsOf(other), Is.LessThan(learnt / 1.5), other.Path);
            Assert.That(BeliefsOf(Open()), Is.EqualTo(learnt).Within(1e-6));
        }

        [Test]
        public void TwoDecidersOfOneSceneDoNotReplaceEachOthersFile()
        {
            SavedPriors first = Open(), second = Open();
            Assert.That(second.Path, Is.Not.EqualTo(first.Path));
            double one = Play(first, 1200), two = Play(second, 1200);
            Assert.That(Files(), Is.EquivalentTo(new[] { first.Path, second.Path }));
            SavedPriors again = Open(), more = Open();
            Assert.That(new[] { again.Path, more.Path }, Is.EquivalentTo(Files()));
            Assert.That(BeliefsOf(again) + BeliefsOf(more), Is.EqualTo(one + two).Within(1e-6));
        }

        [Test]
        public void AFileThatIsLockedIsLeftToItsUser()
        {
            Play(Open(), 1200);
            string used = Files().Single();
            Lock(used).Dispose();
            using (Lock(used))
            {
                SavedPriors other = Open();
                Assert.That(other.Path, Is.Not.EqualTo(used));
                Play(other, 1200);
                Assert.That(Files(), Is.EquivalentTo(new[] { used, other.Path }));
            }
            foreach (SavedPriors saved in new[] { Open(), Open() })
            {
                Assert.That(Files(), Does.Contain(saved.Path));
                Assert.Throws<IOException>(() => Lock(saved.Path).Dispose());
            }
        }

        private static FileStream Lock(string path) => new FileStream(path + ".lock", FileMode.OpenOrCreate, FileAccess.ReadWrite, FileShare.None);

        [TestCase("")]
        [TestCase("not JSON")]
        [TestCase("{\"format\":\"something-else\",\"version\":1,\"records\":[]}")]
        [TestCase("{\"format\":\"sweepstake-priors\",\"version\":2,\"records\":[]}")]
        public void AFileThatCannotBeReadIsKeptUnderAnotherNameAndReported(string content)
        {
            Play(Open(), 1200);
            string damaged = Files().Single();
            File.WriteAllText(damaged, content);
            SavedPriors saved = Open();
            Assert.That(saved.Path, Is.EqualTo(damaged));
            double learnt = Play(saved, 1200);
            Assert.That(saved.Problem, Does.Contain(damaged).And.Contain("learns from the start"));
            Assert.That(File.ReadAllText(damaged + ".unreadable"), Is.EqualTo(content));
            Assert.That(saved.Path, Is.Not.EqualTo(damaged), "a new file has a new source");
            SavedPriors next = Open();
            Assert.That((next.Path, next.Problem), Is.EqualTo((saved.Path, "")));
            Assert.That(BeliefsOf(next), Is.EqualTo(learnt).Within(1e-6));
        }

        [Test]
        public void AFailedWriteLeavesTheFileAndKeepsWhatIsNewInMemory()
        {
            Play(Open(), 1200);
            byte[] before = File.ReadAllBytes(Files().Single());
            Directory.CreateDirectory(Files().Single() + ".tmp");
            SavedPriors saved = Open();
            double learnt = Play(saved, 1200);
            Assert.That(saved.Problem, Does.Contain("could not be saved"));
            Assert.That(File.ReadAllBytes(saved.Path), Is.EqualTo(before));
            Assert.That(BeliefsOf(Open()), Is.EqualTo(learnt).Within(1e-6), "the next decider continues from memory");
            Directory.Delete(saved.Path + ".tmp");
            Assert.That(Play(Open(), 1200), Is.GreaterThan(learnt));
            Assert.That(File.ReadAllBytes(saved.Path), Is.Not.EqualTo(before));
        }

        [Test]
        public void NothingIsWrittenUnlessSomethingWasLearnt()
        {
            BeliefsOf(Open());
            Assert.That(Directory.Exists(folder), Is.False);
        }

        [Test]
        public void WrongPriorsOfTheGameAreNoReasonToSetAFileAside()
        {
            Play(Open(), 1200);
            byte[] before = File.ReadAllBytes(Files().Single());
            using var session = new BroadPhaseSession();
            var options = new DeciderOptions { Project = "p", Scene = "level 1", Saved = Open(), PriorsData = new byte[] { 1 } };
            Assert.That(Assert.Throws<SweepstakeException>(() => new EmbeddedDecider(session, options))!.Code, Is.EqualTo(ResultCode.DataLoss));
            Assert.That(File.ReadAllBytes(Files().Single()), Is.EqualTo(before));
            Assert.That(Open().Path, Is.EqualTo(Files().Single()), "the failed decider has given it back");
        }

        private SavedPriors Open() => SavedPriors.Open(folder, "p", "level 1", "pc");

        private string[] Files() => Directory.GetFiles(folder, "*.json");

        private static double BeliefsOf(SavedPriors saved, string policy = "paper") => Play(saved, 0, policy);

        private static double EvidenceIn(string file) =>
            Regex.Matches(File.ReadAllText(file), "\"(?:alpha|beta)_increment\":([-+.e0-9]+)").Sum(found => double.Parse(found.Groups[1].Value, CultureInfo.InvariantCulture));

        /// <summary>Plays with a decider that continues `saved`. Returns the sum of its posteriors' parameters.</summary>
        private static double Play(SavedPriors saved, int frames, string policy = "paper")
        {
            using var scene = Oracle.CrowdedScene("hurricane");
            using var session = new BroadPhaseSession(new SessionOptions { SettlingNs = 1, Shadow = ShadowMode.Off });
            var options = new DeciderOptions { Policy = policy, TimeScale = 100, Project = "p", Scene = "level 1", Build = "1", Saved = saved };
            using var decider = new EmbeddedDecider(session, options, ownThread: false);
            for (int frame = 0; frame < frames; ++frame)
            {
                scene.Step();
                session.BeginFrame();
                session.FindPairs(scene.Boxes);
                session.EndFrame(FrameNs);
                decider.Poll(SteadyClock.NowNs + (ulong)frame * FrameNs);
            }
            return decider.Status.Beliefs.ToArray().Sum(belief => belief.Alpha + belief.Beta);
        }
    }
}
