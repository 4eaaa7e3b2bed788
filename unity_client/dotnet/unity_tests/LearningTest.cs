using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using System.Reflection;
using NUnit.Framework;
using Sweepstake.Samples;
using Sweepstake.Unity;
using UnityEngine;
using Object = UnityEngine.Object;

namespace Sweepstake.Tests
{
    /// <summary>Tests that what a game has learnt outlives its managers, scenes and runs.</summary>
    public sealed class LearningTest : Stage
    {
        // More than any decider knows that starts without evidence.
        private const double Learnt = 40;

        [Test]
        public void ADisabledManagerKeepsItsSessionAndAllThatItHasLearnt([Values("paper", "")] string policy)
        {
            SweepstakeManager manager = MakeGame(config => config.decisions.policy = policy);
            double fresh = SumOf(manager);
            FramesUntil(() => SumOf(manager) > fresh + Learnt, "learnt");
            BroadPhaseSession session = manager.Session;
            int raised = 0;
            manager.Decided += _ => ++raised;
            manager.gameObject.SetActive(false);
            Assert.That((manager.State, manager.Session), Is.EqualTo((SweepstakeState.Stopped, (BroadPhaseSession)null)));
            double kept = SumOf(session);
            Eventually.Is(() => Files().Length == 1, () => "saved, in case the game ends now");
            manager.gameObject.SetActive(true);
            Assert.That(manager.Session, Is.SameAs(session));
            Assert.That(SumOf(manager), Is.EqualTo(kept));
            Assert.That(raised, Is.EqualTo(0), "an old decision is not raised again");
            ulong decisions = manager.Decider.Status.DecisionCount;
            FramesUntil(() => manager.Decider.Status.DecisionCount > decisions, "deciding again");
        }

        [Test]
        public void AChangedConfigAndAShutdownBeginANewSessionThatContinuesTheFile()
        {
            SweepstakeManager manager = MakeGame();
            FramesUntil(() => SumOf(manager) > Learnt, "learnt");
            BroadPhaseSession session = manager.Session;
            manager.enabled = false;
            manager.Config.decisions.fpsFloor = 20;
            manager.enabled = true;
            Assert.That(manager.Session, Is.Not.SameAs(session));
            Assert.That((SumOf(manager) > Learnt, manager.Decider.Status.PriorSourceCount), Is.EqualTo((true, 1UL)));
            manager.enabled = false;
            SweepstakeManager.Shutdown();
            Assert.That(SweepstakeLibrary.LiveCount(), Is.EqualTo(0), "the session of the disabled manager has ended too");
            manager.enabled = true;
            Assert.That((manager.State, SumOf(manager) > Learnt), Is.EqualTo((SweepstakeState.Embedded, true)));
        }

        [Test]
        public void TheNextSceneAndTheNextRunContinueTheFile()
        {
            SweepstakeManager manager = MakeGame();
            FramesUntil(() => SumOf(manager) > Learnt, "learnt");
            Object.DestroyImmediate(manager.gameObject);
            Assert.That(SweepstakeLibrary.LiveCount(), Is.EqualTo(0));
            byte[] saved = File.ReadAllBytes(WrittenFile());

            SweepstakeManager next = MakeGame();
            double continued = SumOf(next);
            Assert.That((continued > Learnt, next.Decider.Status.PriorSourceCount), Is.EqualTo((true, 1UL)));
            SweepstakeManager other = MakeGame(config => config.sceneName = "another level");
            Assert.That(SumOf(other), Is.LessThan(Learnt));
            Application.SayQuitting();

            // This process has not used the other folder yet, so only the file counts.
            string name = Path.Combine(Application.persistentDataPath, "next run", "Sweepstake", Path.GetFileName(Files().First(path => path.Contains("level-"))));
            Directory.CreateDirectory(Path.GetDirectoryName(name)!);
            File.WriteAllBytes(name, saved);
            string here = Application.persistentDataPath;
            Application.persistentDataPath = Path.Combine(here, "next run");
            try
            {
                Assert.That(SumOf(MakeGame()), Is.EqualTo(continued).Within(1e-6));
            }
            finally
            {
                Player.Stop();
                Application.persistentDataPath = here;
            }
        }

        [Test]
        public void APausedGameSavesBecauseTheSystemMayEndIt()
        {
            SweepstakeManager manager = MakeGame();
            FramesUntil(() => SumOf(manager) > Learnt, "learnt");
            Player.Send("OnApplicationPause", true);
            Eventually.Is(() => Files().Length == 1, () => "saved");
            Assert.That(manager.State, Is.EqualTo(SweepstakeState.Embedded));
        }

        [Test]
        public void OneSwitchOfTheConfigTurnsSavingOff()
        {
            SweepstakeManager manager = MakeGame(config => config.decisions.savesPriors = false);
            FramesUntil(() => SumOf(manager) > Learnt, "learnt");
            Object.DestroyImmediate(manager.gameObject);
            Assert.That(Directory.GetFileSystemEntries(Application.persistentDataPath), Is.Empty);
        }

        [Test]
        public void ADamagedFileIsAProblemAndTheGamePlaysOn()
        {
            SweepstakeManager manager = MakeGame();
            FramesUntil(() => SumOf(manager) > Learnt, "learnt");
            Object.DestroyImmediate(manager.gameObject);
            string damaged = WrittenFile();
            File.WriteAllText(damaged, "{");
            manager = MakeGame();
            Frames(2);
            Assert.That(manager.State, Is.EqualTo(SweepstakeState.Embedded));
            Assert.That(manager.Problem, Does.Contain(damaged).And.Contain("learns from the start"));
            Assert.That(Logged("learns from the start"), Has.Exactly(1).Items);
            Assert.That(File.ReadAllText(damaged + ".unreadable"), Is.EqualTo("{"));
        }

        [Test]
        public void ADiskThatCannotBeWrittenIsAProblem()
        {
            File.WriteAllText(Path.Combine(Application.persistentDataPath, "Sweepstake"), "a file in the place of the folder");
            SweepstakeManager manager = MakeGame();
            FramesUntil(() => SumOf(manager) > Learnt, "learnt");
            Player.Send("OnApplicationPause", true);
            FramesUntil(() => manager.Problem.Contains("could not be saved"), "reported");
            Assert.That(Logged("could not be saved"), Has.Exactly(1).Items);
        }

        private static SweepstakeManager MakeGame(Action<SweepstakeConfig> change = null)
        {
            SweepstakeManager manager = MakeManager(config =>
            {
                config.decisions.policy = "paper";
                config.decisions.intervalSeconds = 0.1f;
                config.decisions.settlingSeconds = 0;
                change?.Invoke(config);
            });
            manager.gameObject.AddComponent<ScenarioPlayer>().ObjectCount = 50;
            return manager;
        }

        private static string[] Files() => Directory.GetFiles(Application.persistentDataPath, "*.json", SearchOption.AllDirectories);

        /// <summary>The only file, after it was written. A manager waits for a limited time when it ends, and a disk may be slower.</summary>
        private static string WrittenFile()
        {
            const BindingFlags Hidden = BindingFlags.Static | BindingFlags.Instance | BindingFlags.NonPublic;
            var known = (Dictionary<string, SavedPriors>)typeof(SavedPriors).GetField("Known", Hidden)!.GetValue(null);
            PropertyInfo unwritten = typeof(SavedPriors).GetProperty("Unwritten", Hidden);
            Eventually.Is(
                () => Files().Length == 1 && known![Files()[0]] is SavedPriors saved && unwritten!.GetValue(saved) == null, () => "written");
            return Files()[0];
        }

        private static double SumOf(SweepstakeManager manager) => SumOf(manager.Decider);

        private static double SumOf(BroadPhaseSession session) => SumOf((EmbeddedDecider)typeof(BroadPhaseSession)
            .GetProperty("Work", BindingFlags.Instance | BindingFlags.NonPublic)!.GetValue(session));

        private static double SumOf(EmbeddedDecider decider) => decider.Status.Beliefs.ToArray().Sum(belief => belief.Alpha + belief.Beta);
    }
}
