using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using NUnit.Framework;
using Sweepstake.Samples;
using Sweepstake.Unity;
using UnityEngine;

namespace Sweepstake.Tests
{
    public sealed class ManagerTest : Stage
    {
        [Test]
        public void AiDecidesAndSaysWhyAndNeverOverrulesManual()
        {
            SweepstakeManager manager = MakeManager(config =>
            {
                config.decisions.intervalSeconds = 0.1f;
                config.decisions.cooldownSeconds = 0;
                config.decisions.settlingSeconds = 0;
                config.decisions.policy = "paper";
            });
            manager.gameObject.AddComponent<ScenarioPlayer>().ObjectCount = 100;
            var decisions = new List<Decision>();
            var verdicts = new List<Verdict>();
            manager.Decided += decisions.Add;
            manager.VerdictChanged += verdicts.Add;
            FramesUntil(() => manager.Session.SwitchEpoch > 1 && decisions.Count > 3, "decided");
            Assert.That(decisions.Select(decision => decision.DecisionId), Is.Ordered.And.Unique);
            FramesUntil(() => SaysWhoIsTheBest(manager), "sure of a backend");

            manager.Mode = SessionMode.Manual;
            manager.SelectBackend("BruteForce");
            Frames(2);
            uint epoch = manager.Session.SwitchEpoch;
            ulong id = manager.LastDecision.DecisionId;
            FramesUntil(() => manager.LastDecision.DecisionId > id + 2, "decided in Manual");
            Assert.That(manager.ActiveBackend, Is.EqualTo("BruteForce"));
            Assert.That(manager.Session.SwitchEpoch, Is.EqualTo(epoch));
            Assert.That(manager.LastDecision.Outcome, Is.EqualTo(DecisionOutcome.Manual));
        }

        [Test]
        public void WhatIsSetInTheInspectorHoldsWhileTheGamePlays()
        {
            SweepstakeManager manager = MakeManager();
            manager.gameObject.AddComponent<ScenarioPlayer>().ObjectCount = 50;
            Frames(2);
            Set(manager, "mode", SessionMode.Manual);
            Set(manager, "backend", "Tracy");
            Player.CallAll("OnValidate");
            Frames(2);
            Assert.That((manager.Mode, manager.ActiveBackend), Is.EqualTo((SessionMode.Manual, "Tracy")));
            Set(manager, "backend", "Quadtree");
            Player.CallAll("OnValidate");
            Frames(2);
            Assert.That(Logged("Quadtree"), Has.Exactly(1).Items);
            Assert.That(manager.ActiveBackend, Is.EqualTo("Tracy"));
        }

        [TestCase("intervalSeconds", "Interval Seconds", SweepstakeState.Embedded)]
        [TestCase("cooldownSeconds", "Cooldown Seconds", SweepstakeState.Embedded)]
        [TestCase("settlingSeconds", "Settling Seconds", SweepstakeState.Failed)]
        [TestCase("bailOutSeconds", "Bail Out Seconds", SweepstakeState.Failed)]
        public void ADurationThatIsNoNumberOfSecondsIsAProblem(string field, string label, SweepstakeState state)
        {
            foreach (float seconds in new[] { float.PositiveInfinity, float.NaN, -1, 1e30f })
            {
                SweepstakeManager manager = null;
                Assert.DoesNotThrow(() => manager = MakeManager(config => Set(config.decisions, field, seconds)));
                Assert.That((manager.State, manager.Problem.Contains($"'{label}'")), Is.EqualTo((state, true)), manager.Problem);
                Assert.That(Logged(label), Is.Not.Empty);
                Set(manager.Config.decisions, field, 1f);
                manager.enabled = false;
                manager.enabled = true;
                Assert.That((manager.State, manager.Problem), Is.EqualTo((SweepstakeState.Embedded, "")));
                Debug.Lines.Clear();
            }
        }

        [Test]
        public void AnUnknownBackendIsAProblem()
        {
            SweepstakeManager inConfig = MakeManager(config => config.search.backends = new[] { "KdTree" });
            SweepstakeManager first = MakeManager(backend: "KdTree");
            foreach (SweepstakeManager manager in new[] { inConfig, first })
                Assert.That((manager.State, manager.Problem.Contains("'KdTree'")), Is.EqualTo((SweepstakeState.Failed, true)), manager.Problem);
            Assert.That(Logged("KdTree"), Has.Exactly(2).Items);
            SweepstakeManager playing = MakeManager();
            playing.gameObject.AddComponent<ScenarioPlayer>().ObjectCount = 50;
            Frames(1);
            Set(playing, "backend", "KdTree");
            Player.CallAll("OnValidate");
            Frames(1);
            Assert.That((playing.State, playing.Problem.Contains("'KdTree'")), Is.EqualTo((SweepstakeState.Embedded, true)), "in AI Decides too");
            Set(playing, "backend", "SAP");
            Player.CallAll("OnValidate");
            Frames(1);
            Assert.That(playing.Problem, Is.Empty, "the name is right now");
        }

        [Test]
        public void AManagerThatIsEnabledAgainAfterAShutdownPlaysItsScenario()
        {
            SweepstakeManager manager = MakeManager();
            var player = manager.gameObject.AddComponent<ScenarioPlayer>();
            player.ObjectCount = 50;
            Frames(3);
            SweepstakeManager.Shutdown();
            manager.enabled = false;
            manager.enabled = true;
            Frames(3);
            Assert.That((manager.State, manager.Problem), Is.EqualTo((SweepstakeState.Embedded, "")));
            Assert.That(player.Step, Is.InRange(1, 3), "the scene has begun again");
            Assert.That(manager.LastSample.ObjectCount, Is.EqualTo(50));
        }

        [Test]
        public void CooldownAndSettlingHoldAndAreShown()
        {
            SweepstakeManager manager = MakeManager(config =>
            {
                config.decisions.intervalSeconds = 0.1f;
                config.decisions.cooldownSeconds = 1000;
                config.decisions.settlingSeconds = 1000;
                config.decisions.policy = "paper";
                config.search.backends = new[] { "SAP", "KDTree" };
            });
            manager.gameObject.AddComponent<ScenarioPlayer>().ObjectCount = 100;
            FramesUntil(() => manager.Session.SwitchEpoch > 0, "switched");
            FramesUntil(() => ShownText(manager).Contains("held: the "), "shown as held");
            uint epoch = manager.Session.SwitchEpoch;
            ulong decided = manager.LastDecision.DecisionId;
            FramesUntil(() => manager.LastDecision.DecisionId > decided + 5, "decided");
            Assert.That(manager.Session.SwitchEpoch, Is.EqualTo(epoch));
        }

        /// <summary>
        /// Returns whether the latest decision has a leader. If so, checks that the text contains its name and probability.
        /// </summary>
        private static bool SaysWhoIsTheBest(SweepstakeManager manager)
        {
            Decision decision = manager.LastDecision;
            int leader = (int)decision.Verdict.LeaderArm;
            if (decision.Verdict.LeaderProbability <= 0)
                return false;
            string best = string.Format(
                System.Globalization.CultureInfo.InvariantCulture, "{0} is the best with {1:P0}", manager.Backends[leader], decision.ProbabilityOf(leader));
            string named = decision.CommandArm == Decision.NoArm ? "(candidate: \\w+; )?" : $"command: {manager.Backends[(int)decision.CommandArm]}; ";
            Assert.That(DecisionText(manager, decision), Does.Match($@"^Decision: [^;]+; {named}{System.Text.RegularExpressions.Regex.Escape(best)}; \d+ s ago$"));
            return true;
        }

        [Test]
        public void ADecisionNamesWhatItKnowsAndNoMore()
        {
            SweepstakeManager manager = MakeManager();
            string best = manager.Backends[1], other = manager.Backends[2];
            var decision = new Decision { Outcome = DecisionOutcome.Switched, ActiveArm = 3, CandidateArm = 2, CommandArm = 2 };
            Assert.That(DecisionText(manager, decision), Is.EqualTo($"Decision: another backend is better; command: {other}; 0 s ago"), "the text of a daemon's decision");
            decision.Outcome = DecisionOutcome.HeldGate;
            decision.CommandArm = Decision.NoArm;
            decision.Verdict = new Verdict { Kind = VerdictKind.Tie, LeaderArm = 1, LeaderProbability = 0.75 };
            Assert.That(
                DecisionText(manager, decision),
                Does.Match($"^Decision: held: not worth the cost of a switch; candidate: {other}; {best} is the best with 75 ?%; 0 s ago$"));
        }

        private static string DecisionText(SweepstakeManager manager, in Decision decision)
        {
            var text = new System.Text.StringBuilder();
            StatusText.AppendDecision(text, manager, decision);
            return text.ToString();
        }

        [Test]
        public void VSyncIsTold()
        {
            SweepstakeManager manager = MakeManager();
            Assert.That(ShownText(manager), Does.Not.Contain("vSync"));
            QualitySettings.vSyncCount = 1;
            Assert.That(ShownText(manager), Does.Contain("\nvSync is on"));
            QualitySettings.vSyncCount = 0;
        }

        private static string ShownText(SweepstakeManager manager)
        {
            var text = new System.Text.StringBuilder();
            StatusText.Append(text, manager, 60);
            return text.ToString();
        }

        [Test]
        public void ABackendThatDoesNotExistFailsWithTheRemedyAndOnce()
        {
            SweepstakeManager manager = MakeManager(backend: "Quadtree");
            Assert.That(manager.State, Is.EqualTo(SweepstakeState.Failed));
            Assert.That(manager.Problem, Does.Contain("Quadtree").And.Contain("KDTree"));
            Frames(10);
            Assert.That(Logged("error: "), Has.Exactly(1).Items);
        }

        [Test]
        public void BrokenPriorsAreToldAndTheGamePlays()
        {
            SweepstakeManager manager = MakeManager(config =>
            {
                config.decisions.priors = (TextAsset)Activator.CreateInstance(typeof(TextAsset));
                config.decisions.priors.bytes = new byte[] { 1, 2, 3 };
            });
            manager.gameObject.AddComponent<ScenarioPlayer>().ObjectCount = 50;
            Frames(3);
            Assert.That(manager.Problem, Is.Not.Empty);
            Assert.That(manager.LastSample.ObjectCount, Is.EqualTo(50));
        }

        [Test]
        public void TheDefaultsOfAConfigAreTheLibrarys()
        {
            var config = ScriptableObject.CreateInstance<SweepstakeConfig>();
            var session = new SessionOptions();
            var decider = new DeciderOptions();
            var link = new LinkOptions();
            SessionOptions ours = config.ToSessionOptions(SessionMode.Ai, "");
            Assert.That((ours.BailOutNs, ours.SettlingNs), Is.EqualTo((session.BailOutNs, session.SettlingNs)));
            DeciderOptions deciding = config.ToDeciderOptions("", "1.0");
            Assert.That(
                (deciding.DecisionIntervalNs, deciding.CooldownNs, deciding.FpsFloor, deciding.Seed),
                Is.EqualTo((decider.DecisionIntervalNs, decider.CooldownNs, decider.FpsFloor, decider.Seed)));
            Assert.That(deciding.Weights, Is.EqualTo(decider.Weights));
            Assert.That(deciding.Weights, Is.EqualTo(new RewardWeights(0.55, 0.25, 0.12, 0.08)));
            LinkOptions linked = config.ToLinkOptions("", "1.0");
            Assert.That((deciding.Build, linked.Build), Is.EqualTo(("1.0", "1.0")));
            Assert.That((linked.BatchIntervalMs, linked.BatchFrames), Is.EqualTo((link.BatchIntervalMs, link.BatchFrames)));
            Assert.That((linked.DecisionIntervalNs, linked.CooldownNs, linked.SettlingNs), Is.EqualTo((link.DecisionIntervalNs, link.CooldownNs, link.SettlingNs)));
            Assert.That((linked.DecisionIntervalNs, linked.Weights), Is.EqualTo(((ulong?)null, (RewardWeights?)null)), "a daemon has its own rules");
            Assert.That(link.Weights, Is.Null);
            Assert.That(config.daemon.isUsed, Is.False, "nothing leaves the machine by default");
            Assert.That(config.daemon.address, Does.StartWith("127.0.0.1:"));
            Assert.That(config.daemon.allowsOperatorOrders, Is.False);
        }

        [Test]
        public void TheRulesOfAGameAreSentOnlyIfTheConfigSaysSo()
        {
            var config = ScriptableObject.CreateInstance<SweepstakeConfig>();
            config.decisions.intervalSeconds = 0.5f;
            config.decisions.cooldownSeconds = 0;
            config.decisions.settlingSeconds = 3;
            config.decisions.weights = new WeightSettings { frameRate = 0.25, detection = 0.25, memory = 0.5, checks = 0 };
            Assert.That(config.ToDeciderOptions("", "").Weights, Is.EqualTo(new RewardWeights(0.25, 0.25, 0.5, 0)));
            Assert.That(config.ToLinkOptions("", "").CooldownNs, Is.Null);
            config.daemon.usesRulesOfGame = true;
            LinkOptions linked = config.ToLinkOptions("", "");
            Assert.That((linked.DecisionIntervalNs, linked.CooldownNs, linked.SettlingNs), Is.EqualTo(((ulong?)500_000_000, (ulong?)0, (ulong?)3_000_000_000)));
            Assert.That(linked.Weights, Is.EqualTo(new RewardWeights(0.25, 0.25, 0.5, 0)));
        }

        [Test]
        public void TheLaneIsOffOnMobileDevices()
        {
            var config = ScriptableObject.CreateInstance<SweepstakeConfig>();
            Assert.That(config.ToSessionOptions(SessionMode.Ai, "").Shadow, Is.EqualTo(ShadowMode.Auto));
            Application.isMobilePlatform = true;
            Assert.That(config.ToSessionOptions(SessionMode.Ai, "").Shadow, Is.EqualTo(ShadowMode.Off));
            config.search.lane = ShadowMode.On;
            Assert.That(config.ToSessionOptions(SessionMode.Ai, "").Shadow, Is.EqualTo(ShadowMode.On));
        }

        [Test]
        public void NothingIsLearntFromAPauseTheBackgroundAndALoad()
        {
            SweepstakeManager manager = MakeManager();
            manager.gameObject.AddComponent<ScenarioPlayer>().ObjectCount = 10;
            Frames(1);
            Assert.That(manager.LastSample.Flags & FrameFlags.Loading, Is.EqualTo(FrameFlags.Loading), "the first frame includes the time of loading");
            AssertFlags(manager, FrameFlags.None);
            Player.Send("OnApplicationPause", true);
            AssertFlags(manager, FrameFlags.Paused);
            Player.Send("OnApplicationPause", false);
            AssertFlags(manager, FrameFlags.Paused, FrameFlags.None);
            Player.Send("OnApplicationFocus", false);
            AssertFlags(manager, FrameFlags.Paused);
            Player.Send("OnApplicationFocus", true);
            AssertFlags(manager, FrameFlags.Paused, FrameFlags.None);
            Time.timeScale = 0;
            AssertFlags(manager, FrameFlags.Paused);
            Time.timeScale = 1;
            AssertFlags(manager, FrameFlags.Paused, FrameFlags.None);
            manager.IsLoading = true;
            AssertFlags(manager, FrameFlags.Loading);
            manager.IsLoading = false;
            AssertFlags(manager, FrameFlags.Loading, FrameFlags.None);
            UnityEngine.SceneManagement.SceneManager.SayLoaded(UnityEngine.SceneManagement.SceneManager.Add("next level"));
            AssertFlags(manager, FrameFlags.Loading, FrameFlags.None);
            Application.isEditor = true;
            Player.Send("OnApplicationFocus", false);
            AssertFlags(manager, FrameFlags.None);
        }

        [Test]
        public void AFrameAllocatesNothing()
        {
            SweepstakeManager manager = MakeManager(config => config.decisions.intervalSeconds = 0.1f);
            manager.gameObject.AddComponent<ScenarioPlayer>().ObjectCount = 500;
            int decisions = 0;
            manager.Decided += _ => ++decisions;
            manager.VerdictChanged += _ => { };
            int awaited = 0;
            Func<bool> isDecided = () => decisions >= awaited;
            Action play = () => Player.Frame();
            long allocated = Eventually.AllocatedBy(() =>
            {
                awaited = decisions + 3;
                Eventually.Is(isDecided, () => "decided thrice", play);
            });
            Assert.That(allocated, Is.EqualTo(0));
        }

        [Test]
        public void AListenerThatThrowsStopsNothingAndKeepsNothingFromTheOthers()
        {
            SweepstakeManager manager = MakeManager(config =>
            {
                config.decisions.intervalSeconds = 0.1f;
                config.daemon.isUsed = true;
                config.daemon.address = "127.0.0.1:9";
            });
            manager.gameObject.AddComponent<ScenarioPlayer>().ObjectCount = 10;
            var told = new List<object>();
            manager.BackendChanged += _ => throw new InvalidOperationException("a bug of backends");
            manager.BackendChanged += backend => told.Add(backend);
            manager.Decided += _ => throw new InvalidOperationException("a bug of decisions");
            manager.Decided += decision => told.Add(decision);
            manager.StateChanged += _ => throw new InvalidOperationException("a bug of states");
            manager.StateChanged += state => told.Add(state);
            manager.Mode = SessionMode.Manual;
            manager.Disconnect();
            manager.SelectBackend("SAP");
            Frames(5);
            Assert.That(told.Where(what => !(what is Decision)), Is.EqualTo(new object[] { SweepstakeState.Embedded, "SAP" }));
            Assert.That(Logged("a bug of backends").Count() + Logged("a bug of states").Count(), Is.EqualTo(2));
            Assert.That(manager.LastSample.FrameIndex, Is.EqualTo(4));
            FramesUntil(() => told.OfType<Decision>().Any(), "raised for a decision");
            Assert.That(Logged("a bug of decisions"), Has.Exactly(told.OfType<Decision>().Count()).Items);
        }

        [Test]
        public void AListenerMayDisableTheManager()
        {
            SweepstakeManager manager = MakeManager(config =>
            {
                config.daemon.isUsed = true;
                config.daemon.address = "127.0.0.1:9";
            });
            manager.gameObject.AddComponent<ScenarioPlayer>().ObjectCount = 10;
            manager.StateChanged += Disable;
            manager.Disconnect();
            Assert.DoesNotThrow(() => Frames(3));
            manager.StateChanged -= Disable;
            Assert.That((manager.State, manager.Session), Is.EqualTo((SweepstakeState.Stopped, (BroadPhaseSession)null)));

            manager.Config.daemon.isUsed = false;
            manager.enabled = true;
            manager.BackendChanged += _ => manager.enabled = false;
            manager.SelectBackend("SAP");
            Frames(3);
            Assert.That(manager.State, Is.EqualTo(SweepstakeState.Stopped));
            Assert.That(Logged("exception: "), Is.Empty);

            void Disable(SweepstakeState state) => manager.enabled = false;
        }

        [Test]
        public void AListenerMayBeginAnewWhatHasFailed([Values] bool failsAgain)
        {
            SweepstakeManager manager = MakeManager();
            manager.gameObject.AddComponent<ScenarioPlayer>().ObjectCount = 10;
            var states = new List<SweepstakeState>();
            manager.StateChanged += states.Add;
            manager.StateChanged += state =>
            {
                if (state != SweepstakeState.Failed)
                    return;
                if (failsAgain)
                    Set(manager, "backend", "Quadtree");
                manager.enabled = false;
                manager.enabled = true;
            };
            Eventually.ShutsDown();
            Frames(1);
            Assert.That(states, Is.EqualTo(new[] { SweepstakeState.Failed, SweepstakeState.Stopped }), "it begins with the next frame");
            Frames(3);
            Assert.That(Logged("error: "), Has.Exactly(failsAgain ? 4 : 1).Items, "no more than once a frame");
            Assert.That(manager.State, Is.EqualTo(failsAgain ? SweepstakeState.Stopped : SweepstakeState.Embedded));
            Assert.That(manager.Session, failsAgain ? Is.Null : Is.Not.Null);
            Assert.That(manager.LastSample.FrameIndex, Is.EqualTo(failsAgain ? 0 : 2));
            Assert.That(SweepstakeManager.Enabled, Is.EqualTo(new[] { manager }));
        }

        [Test]
        public void AShutdownEndsEveryManagerWhateverTheListenersDo([Values] bool throws)
        {
            SweepstakeManager[] managers = { MakeManager(), MakeManager(), MakeManager() };
            foreach (SweepstakeManager manager in managers)
            {
                manager.StateChanged += _ =>
                {
                    if (throws)
                        throw new InvalidOperationException("a bug of the game");
                    managers[0].enabled = managers[2].enabled = false;
                };
            }
            Assert.DoesNotThrow(SweepstakeManager.Shutdown);
            Assert.That(managers.Select(manager => manager.State), Is.All.EqualTo(SweepstakeState.Stopped));
            Assert.That(managers.Select(manager => manager.Session), Is.All.Null);
        }

        [Test]
        public void FramesAreWrittenToACsvFile()
        {
            SweepstakeManager manager = MakeManager();
            manager.gameObject.AddComponent<ScenarioPlayer>().ObjectCount = 10;
            string path = Path.GetTempFileName();
            QualitySettings.vSyncCount = 2;
            manager.StartCsv(path, "a scene", 7);
            QualitySettings.vSyncCount = 0;
            Frames(20);
            manager.StopCsv();
            Eventually.Is(() => File.ReadAllLines(path).Length == 21, () => "written to the end");
            Assert.That(File.ReadLines(path).Skip(1), Is.All.EndsWith($",a scene,7,{SweepstakeLibrary.Version},2"), "each row has the vSync count, which limits the frame rate");
            File.Delete(path);
        }

        private static void AssertFlags(SweepstakeManager manager, params FrameFlags[] expected)
        {
            foreach (FrameFlags flags in expected)
            {
                Player.Frame();
                Assert.That(manager.LastSample.Flags & (FrameFlags.Paused | FrameFlags.Loading), Is.EqualTo(flags));
            }
        }
    }
}
