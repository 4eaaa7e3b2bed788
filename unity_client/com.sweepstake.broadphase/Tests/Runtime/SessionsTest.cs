#nullable enable
using System;
using NUnit.Framework;

namespace Sweepstake.Tests
{
    public sealed class SessionsTest
    {
        private const ulong FrameNs = 16_666_667;

        [Test]
        public void EachArmCanBeSelectedWhileTheGameRunsAndFindsTheSamePairs()
        {
            using var session = new BroadPhaseSession(new SessionOptions { Mode = SessionMode.Manual, InitialArm = "BruteForce" });
            using var scene = Oracle.CrowdedScene("hurricane");
            Assert.That(session.Arms, Is.EqualTo(SweepstakeLibrary.Backends));
            for (int arm = session.Arms.Count - 1; arm >= 0; --arm)
            {
                session.SelectArm(arm);
                for (int frame = 0; frame < 5; ++frame)
                {
                    scene.Step();
                    Play(session, scene);
                    Assert.That(Oracle.Sorted(session.Pairs), Is.EqualTo(Oracle.Pairs(scene.Boxes)));
                    Assert.That(session.ActiveArm, Is.EqualTo(arm));
                    Assert.That(session.LastSample.Arm, Is.EqualTo(arm));
                    Assert.That(session.LastSample.ObjectCount, Is.EqualTo(300));
                    Assert.That(session.LastSample.FrameTimeNs, Is.EqualTo(FrameNs));
                }
            }
            Assert.That(session.SwitchEpoch, Is.EqualTo((uint)session.Arms.Count), "one switch for each arm up to the last, then one back to the first");
        }

        [Test]
        public void ArmsModeAndShadowAreAsAskedFor()
        {
            var options = new SessionOptions { Arms = "DBVT,SAP", InitialArm = "SAP", Mode = SessionMode.Manual };
            Assert.That(options.BailOutNs, Is.EqualTo(5_000_000_000));
            Assert.That(options.SettlingNs, Is.EqualTo(2_000_000_000));
            Assert.That(options.QueueFrames, Is.EqualTo(4096));
            Assert.That(options.Shadow, Is.EqualTo(ShadowMode.Auto));
            options.Shadow = ShadowMode.Off;
            using var session = new BroadPhaseSession(options);
            Assert.That(session.Arms, Is.EqualTo(new[] { "DBVT", "SAP" }));
            Assert.That(session.ActiveArm, Is.EqualTo(1));
            Assert.That(session.Mode, Is.EqualTo(SessionMode.Manual));
            session.Mode = SessionMode.Ai;
            Assert.That(session.Mode, Is.EqualTo(SessionMode.Ai));
            Assert.That(session.ShadowStats.State, Is.EqualTo(ShadowState.Off));
            Assert.That(session.VersionOf(0), Is.GreaterThan(0));
            Assert.Throws<ArgumentOutOfRangeException>(() => session.SelectArm(2));
            Assert.That(Assert.Throws<SweepstakeException>(() => session.SelectArm("KDTree"))!.Message, Does.Contain("DBVT"));
        }

        [Test]
        public void WrongOptionsAreRefusedWithTheReason()
        {
            Assert.Throws<SweepstakeException>(() => new BroadPhaseSession(new SessionOptions { Arms = "SAP,Quadtree" }));
            var refused = Assert.Throws<SweepstakeException>(() => new BroadPhaseSession(new SessionOptions { QueueFrames = 3 }));
            Assert.That(refused!.Code, Is.EqualTo(ResultCode.InvalidArgument));
            Assert.That(refused.Message, Is.Not.Empty);
        }

        [Test]
        public void ManualIsNeverOverruledByTheDecider()
        {
            using var session = new BroadPhaseSession(new SessionOptions { Mode = SessionMode.Manual, InitialArm = "BruteForce" });
            using var decider = new EmbeddedDecider(session, new DeciderOptions { TimeScale = 100 }, ownThread: false);
            using var scene = Oracle.CrowdedScene("hurricane");
            PlayAndPoll(session, decider, scene, 600);
            Assert.That(decider.Status.DecisionCount, Is.GreaterThan(0));
            Assert.That(session.SwitchEpoch, Is.EqualTo(0));
            Assert.That(session.Arms[session.ActiveArm], Is.EqualTo("BruteForce"));
            Assert.That(session.LastDecision.Outcome, Is.EqualTo(DecisionOutcome.Manual));
        }

        [Test]
        public void AiDecidesAndSaysWhy()
        {
            // The policy "paper" samples from posteriors without evidence at first, so it tries other arms, whatever they cost on this
            // machine.
            using var session = new BroadPhaseSession(new SessionOptions { InitialArm = "BruteForce", SettlingNs = 1 });
            using var decider = new EmbeddedDecider(session, new DeciderOptions { TimeScale = 100, Policy = "paper" }, ownThread: false);
            using var scene = Oracle.CrowdedScene("hurricane");
            PlayAndPoll(session, decider, scene, 1200);
            Assert.That(session.SwitchEpoch, Is.GreaterThan(0));
            Assert.That(decider.Status.DecisionCount, Is.GreaterThan(10));
            Decision decision = session.LastDecision;
            Assert.That(decision.Outcome, Is.Not.EqualTo(DecisionOutcome.None));
            Assert.That(decision.DecisionId, Is.EqualTo(decider.Status.DecisionCount));
            Assert.That(session.LastOutcome.IsExecuted, Is.True);
            double sum = 0;
            for (int arm = 0; arm < session.Arms.Count; ++arm)
                sum += decision.ProbabilityOf(arm);
            Assert.That(sum, Is.EqualTo(1).Within(1e-6));
            Assert.That(decider.Status.Beliefs.Length, Is.EqualTo(session.Arms.Count));
            foreach (Belief belief in decider.Status.Beliefs.ToArray())
                Assert.That(belief.Mean, Is.InRange(0, 1));
        }

        [Test]
        public void WhatIsLearntGoesOnInTheNextRun()
        {
            using var scene = Oracle.CrowdedScene("hurricane");
            byte[] priors;
            using (var session = new BroadPhaseSession(new SessionOptions { SettlingNs = 1 }))
            using (var decider = new EmbeddedDecider(session, new DeciderOptions { TimeScale = 100, SourceId = "a", Build = "1.1" }, ownThread: false))
            {
                Assert.That(decider.Status.PriorSourceCount, Is.EqualTo(0));
                PlayAndPoll(session, decider, scene, 1200);
                priors = decider.ExportPriors();
            }
            Assert.That(System.Text.Encoding.UTF8.GetString(priors), Does.Contain("\"build\":\"1.1\""));
            using var next = new BroadPhaseSession();
            using var started = new EmbeddedDecider(next, new DeciderOptions { PriorsData = priors }, ownThread: false);
            Assert.That(started.Status.PriorSourceCount, Is.EqualTo(1));
            using var third = new BroadPhaseSession();
            priors[priors.Length / 2] = 0;
            Assert.That(
                Assert.Throws<SweepstakeException>(() => new EmbeddedDecider(third, new DeciderOptions { PriorsData = priors }))!.Code,
                Is.EqualTo(ResultCode.DataLoss));
        }

        [Test]
        public void AFrozenSessionTakesTheArmOfItsPriorsAndReadsNoClock()
        {
            using var scene = Oracle.CrowdedScene("hurricane");
            byte[] priors;
            using (var session = new BroadPhaseSession(new SessionOptions { SettlingNs = 1 }))
            using (var decider = new EmbeddedDecider(session, new DeciderOptions { TimeScale = 100, SourceId = "a" }, ownThread: false))
            {
                PlayAndPoll(session, decider, scene, 1200);
                priors = decider.ExportPriors();
            }
            string chosen = FrozenArm(priors, "SAP", scene);
            foreach (string initial in SweepstakeLibrary.Backends)
                Assert.That(FrozenArm(priors, initial, scene), Is.EqualTo(chosen), "the same priors give the same arm");
        }

        private static string FrozenArm(byte[] priors, string initial, MotionScene scene)
        {
            using var frozen = new BroadPhaseSession(new SessionOptions { InitialArm = initial });
            frozen.Freeze(new DeciderOptions { PriorsData = priors });
            Play(frozen, scene);
            string chosen = frozen.Arms[frozen.ActiveArm];
            Assert.That(frozen.Mode, Is.EqualTo(SessionMode.Manual));
            Assert.That(frozen.LastSample.DetectionTimeNs, Is.EqualTo(0), "no clock is read");
            frozen.SelectArm(initial);
            Play(frozen, scene);
            Assert.That(frozen.Arms[frozen.ActiveArm], Is.EqualTo(initial), "the game can still select an arm");
            frozen.Mode = SessionMode.Ai;
            Play(frozen, scene);
            Assert.That(frozen.LastSample.DetectionTimeNs, Is.GreaterThan(0));
            return chosen;
        }

        [Test]
        public void ASessionWithoutPriorsFreezesAtItsArmAndRefusesThoseOfAnotherProject()
        {
            using var scene = Oracle.CrowdedScene("brownian");
            using var session = new BroadPhaseSession(new SessionOptions { InitialArm = "DBVT" });
            var strange = new DeciderOptions { Project = "nowhere" };
            Assert.That(Assert.Throws<SweepstakeException>(() => session.Freeze(strange))!.Code, Is.EqualTo(ResultCode.NotFound));
            Play(session, scene);
            Assert.That(session.LastSample.DetectionTimeNs, Is.GreaterThan(0), "the session is unchanged");
            session.Freeze();
            Play(session, scene);
            Assert.That(session.LastSample.DetectionTimeNs, Is.EqualTo(0));
            Assert.That(session.Arms[session.ActiveArm], Is.EqualTo("DBVT"));
        }

        [Test]
        public void ADeciderUsesTheWeightsOfItsOptions()
        {
            using var scene = Oracle.CrowdedScene("brownian");
            using var session = new BroadPhaseSession(new SessionOptions { Shadow = ShadowMode.Off, SettlingNs = 0 });
            var options = new DeciderOptions { TimeScale = 100, Policy = "paper", Weights = new RewardWeights(0, 0, 1, 0) };
            using var decider = new EmbeddedDecider(session, options, ownThread: false);
            PlayAndPoll(session, decider, scene, 200);
            string priors = System.Text.Encoding.UTF8.GetString(decider.ExportPriors());
            Assert.That(priors, Does.Match("\"reward_version\":1\\d{9}"), "evidence of own weights has a version of its own");
            using var second = new BroadPhaseSession();
            Exception wrong = Assert.Throws<SweepstakeException>(() => new EmbeddedDecider(second, new DeciderOptions { Weights = new RewardWeights(1, 1, 0, 0) }))!;
            Assert.That(wrong.Message, Does.Contain("the reward weights sum to 2"));
        }

        [Test]
        public void TheDecidersThreadEndsWithItsSession()
        {
            var session = new BroadPhaseSession();
            var decider = new EmbeddedDecider(session);
            Assert.That(SessionWork.RunningCount, Is.EqualTo(1));
            Assert.Throws<SweepstakeException>(() => new EmbeddedDecider(session));
            session.Dispose();
            Assert.That(SessionWork.RunningCount, Is.EqualTo(0));
            Assert.That(decider.Failure, Is.Null);
            Assert.That(decider.Poll(SteadyClock.NowNs), Is.False);
            Assert.Throws<SweepstakeException>(() => decider.ExportPriors());
            decider.Dispose();
        }

        private static void PlayAndPoll(BroadPhaseSession session, EmbeddedDecider decider, MotionScene scene, int frames)
        {
            ulong nowNs = SteadyClock.NowNs;
            for (int frame = 0; frame < frames; ++frame)
            {
                scene.Step();
                Play(session, scene);
                nowNs += FrameNs;
                decider.Poll(nowNs);
            }
        }

        private static void Play(BroadPhaseSession session, MotionScene scene)
        {
            session.BeginFrame();
            session.FindPairs(scene.Boxes);
            session.EndFrame(FrameNs);
        }
    }
}
