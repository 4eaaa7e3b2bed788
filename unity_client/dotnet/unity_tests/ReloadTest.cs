using System.Threading;
using NUnit.Framework;
using Sweepstake.Samples;
using Sweepstake.Unity;
using UnityEditor;
using UnityEngine;

namespace Sweepstake.Tests
{
    /// <summary>Tests all orders in which Unity can end and begin play mode, scenes and domains.</summary>
    public sealed class ReloadTest : Stage
    {
        [Test]
        public void TwentyTimesIntoPlayModeWithoutADomainReloadLeavesNothing()
        {
            int threads = 0;
            for (int play = 0; play < 20; ++play)
            {
                Player.Begin(typeof(Stage).Assembly);
                SweepstakeManager manager = MakeManager();
                manager.gameObject.AddComponent<ScenarioPlayer>().ObjectCount = 50;
                Frames(3);
                Assert.That(manager.LastSample.ObjectCount, Is.EqualTo(50));
                Assert.That(SweepstakeManager.Enabled, Has.Count.EqualTo(1));
                Player.Stop();
                EditorApplication.Say(PlayModeStateChange.EnteredEditMode);
                Assert.That(SweepstakeLibrary.LiveCount(), Is.EqualTo(0));
                Assert.That(SweepstakeManager.Enabled, Is.Empty);
                if (play == 2)
                    threads = Eventually.ThreadCount();
            }
            Eventually.HasAtMostThreads(threads);
            Assert.That(Debug.Lines, Is.Empty);
        }

        [Test]
        public void WhatAScriptHasForgottenEndsWithPlayMode()
        {
            System.Runtime.CompilerServices.RuntimeHelpers.RunClassConstructor(typeof(Editor.EditorLifetime).TypeHandle);
            var forgotten = new BroadPhaseSession();
            EditorApplication.Say(PlayModeStateChange.EnteredEditMode);
            Assert.That(SweepstakeLibrary.LiveCount(), Is.EqualTo(0));
            Assert.Throws<SweepstakeException>(forgotten.BeginFrame);
        }

        [Test]
        public void ARecompilationWhileItPlaysEndsWhatIsNative()
        {
            SweepstakeManager manager = MakeManager();
            var tracker = manager.gameObject.AddComponent<ColliderTracker>();
            MakeBox(Vector3.zero);
            tracker.Scan();
            Frames(3);
            System.Runtime.CompilerServices.RuntimeHelpers.RunClassConstructor(typeof(Editor.EditorLifetime).TypeHandle);
            AssemblyReloadEvents.SayReload();
            Assert.That(SweepstakeLibrary.LiveCount(), Is.EqualTo(0));
            Assert.That(SessionWork.RunningCount, Is.EqualTo(0));
            Assert.That(manager.Session, Is.Null);
            Frames(3);
            Assert.That(Debug.Lines, Is.Empty, "leftover objects log nothing until the domain is reloaded");
        }

        [Test]
        public void TheEndOfThePlayerEndsEverythingOnce()
        {
            SweepstakeManager manager = MakeManager();
            Application.SayQuitting();
            Assert.That(SweepstakeLibrary.LiveCount(), Is.EqualTo(0));
            Assert.That(manager.State, Is.EqualTo(SweepstakeState.Stopped));
            SweepstakeManager.Shutdown();
        }

        [Test]
        public void WhatSomeoneElseHasEndedIsAFailureThatIsToldOnce()
        {
            SweepstakeManager manager = MakeManager();
            manager.gameObject.AddComponent<ScenarioPlayer>().ObjectCount = 10;
            Frames(2);
            Eventually.ShutsDown();
            Frames(5);
            Assert.That(manager.State, Is.EqualTo(SweepstakeState.Failed));
            Assert.That(Logged("error: "), Has.Exactly(1).Items);
        }

        [Test]
        public void AManagerThatIsEnabledAgainPlaysOn()
        {
            SweepstakeManager manager = MakeManager();
            manager.gameObject.AddComponent<ColliderTracker>();
            MakeBox(Vector3.zero);
            MakeBox(Vector3.zero);
            manager.GetComponent<ColliderTracker>().Scan();
            Frames(2);
            Assert.That(manager.LastSample.PairCount, Is.EqualTo(1));
            manager.enabled = false;
            Assert.That(manager.State, Is.EqualTo(SweepstakeState.Stopped));
            Frames(2);
            manager.enabled = true;
            Frames(2);
            Assert.That(manager.State, Is.EqualTo(SweepstakeState.Embedded));
            Assert.That(manager.LastSample.PairCount, Is.EqualTo(1));
        }

        [Test]
        public void TwoManagersAreIndependent()
        {
            SweepstakeManager first = MakeManager(mode: SessionMode.Manual, backend: "SAP");
            SweepstakeManager second = MakeManager(mode: SessionMode.Manual, backend: "KDTree");
            first.gameObject.AddComponent<ScenarioPlayer>().ObjectCount = 20;
            second.gameObject.AddComponent<ScenarioPlayer>().ObjectCount = 30;
            Frames(3);
            Assert.That((first.ActiveBackend, first.LastSample.ObjectCount), Is.EqualTo(("SAP", 20u)));
            Assert.That((second.ActiveBackend, second.LastSample.ObjectCount), Is.EqualTo(("KDTree", 30u)));
            Object.DestroyImmediate(first.gameObject);
            Frames(3);
            Assert.That(SweepstakeManager.Enabled, Is.EqualTo(new[] { second }));
        }
    }
}
