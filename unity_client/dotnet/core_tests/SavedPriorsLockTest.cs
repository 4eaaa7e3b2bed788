#nullable disable
using System;
using System.Diagnostics;
using System.IO;
using System.Linq;
using NUnit.Framework;

namespace Sweepstake.Tests
{
    /// <summary>Tests that saved priors which another process uses are left to it. The other process is a program of the system.</summary>
    public sealed class SavedPriorsLockTest
    {
        // Holds a lock of the file until its standard input ends. {0} is the function of Python's module fcntl.
        private const string Holder = "import fcntl, sys; file = open(sys.argv[1], 'a+'); fcntl.{0}(file, fcntl.LOCK_EX); print(flush=True); sys.stdin.read()";
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

        /// <param name="function">flock is what .NET uses on Linux for FileShare.None, and lockf what Unity's runtimes use for FileStream.Lock.</param>
        [Test]
        public void AFileOfAnotherProcessIsLeftToIt([Values("flock", "lockf")] string function)
        {
            string used = Learn();
            using (Process holder = Hold(function, used + ".lock"))
            {
                string other = Learn();
                Assert.That(other, Is.Not.EqualTo(used));
                holder.StandardInput.Close();
                holder.WaitForExit();
            }
            Assert.That(new[] { Open().Path, Open().Path }, Is.EquivalentTo(Directory.GetFiles(folder, "*.json")), "both files are free again");
        }

        [Test]
        public void AFileInUseIsLockedForAnotherProcess()
        {
            Learn();
            SavedPriors saved = Open();
            using Process holder = Start("import fcntl, sys; fcntl.lockf(open(sys.argv[1], 'a+'), fcntl.LOCK_EX | fcntl.LOCK_NB)", saved.Path + ".lock");
            holder.WaitForExit();
            Assert.That(holder.ExitCode, Is.EqualTo(1));
        }

        [Test]
        public void ASessionThatHasADeciderGivesTheFileBack()
        {
            Learn();
            using var session = new BroadPhaseSession(new SessionOptions { Shadow = ShadowMode.Off });
            using var decider = new EmbeddedDecider(session, new DeciderOptions(), ownThread: false);
            SavedPriors saved = Open();
            Assert.Throws<SweepstakeException>(() => new EmbeddedDecider(session, new DeciderOptions { Saved = saved }, ownThread: false));
            Assert.That(Open(), Is.SameAs(saved));
        }

        private SavedPriors Open() => SavedPriors.Open(folder, "default", "default", "pc");

        /// <summary>Learns and saves. Returns the path of the file.</summary>
        private string Learn()
        {
            SavedPriors saved = Open();
            using var session = new BroadPhaseSession(new SessionOptions { SettlingNs = 1, Shadow = ShadowMode.Off });
            using var scene = Oracle.CrowdedScene("hurricane");
            using (var decider = new EmbeddedDecider(session, new DeciderOptions { Policy = "paper", TimeScale = 1000, Saved = saved }))
                Eventually.Is(() => decider.Status.Beliefs.ToArray().Sum(belief => belief.Alpha + belief.Beta) > 20, () => "learnt", () => Frame(session, scene));
            Assert.That(File.Exists(saved.Path), Is.True);
            return saved.Path;
        }

        private static void Frame(BroadPhaseSession session, MotionScene scene)
        {
            scene.Step();
            session.BeginFrame();
            session.FindPairs(scene.Boxes);
            session.EndFrame(16_666_667);
        }

        private static Process Hold(string function, string path)
        {
            Process holder = Start(Holder.Replace("{0}", function), path);
            Assert.That(holder.StandardOutput.ReadLine(), Is.EqualTo(""), "locked");
            return holder;
        }

        private static Process Start(string script, string path) => Process.Start(
            new ProcessStartInfo("python3", new[] { "-c", script, path }) { RedirectStandardInput = true, RedirectStandardOutput = true, RedirectStandardError = true });
    }
}
