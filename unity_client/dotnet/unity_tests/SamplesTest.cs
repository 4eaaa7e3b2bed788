using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.IO;
using System.Linq;
using NUnit.Framework;
using Sweepstake.Samples;
using Sweepstake.Unity;
using UnityEngine;

namespace Sweepstake.Tests
{
    /// <summary>Plays the component of each sample.</summary>
    public sealed class SamplesTest : Stage
    {
        private static string Folder => Application.persistentDataPath;

        [Test]
        public void TheQuickStartCountsItsPairs()
        {
            var sample = new GameObject("quick start").AddComponent<QuickStart>();
            var tracker = sample.GetComponent<ColliderTracker>();
            int open = 0;
            tracker.PairBegan += _ => ++open;
            tracker.PairEnded += _ => --open;
            Frames(120);
            var manager = sample.GetComponent<SweepstakeManager>();
            Assert.That(tracker.Count, Is.EqualTo(300));
            Assert.That(manager.LastSample.PairCount, Is.GreaterThan(0));
            Assert.That(open, Is.EqualTo(tracker.Proxies.Pairs.Length));
        }

        [Test]
        public void EachScenarioPlaysTenThousandBoxesAndDrawsEachOnce([Values(0, 1, 2, 3, 4)] int scenario)
        {
            var sample = new GameObject("triggers").AddComponent<Triggers>();
            var player = sample.GetComponent<ScenarioPlayer>();
            player.ObjectCount = 10_000;
            Frames(1);
            Press((char)('1' + scenario));
            Assert.That(player.Scenario, Is.EqualTo(SweepstakeLibrary.Scenes[scenario]));
            Frames(1);
            Graphics.InstanceCount = 0;
            Frames(1);
            Assert.That(Graphics.InstanceCount, Is.EqualTo(10_000));
            Assert.That(sample.GetComponent<SweepstakeManager>().LastSample.ObjectCount, Is.EqualTo(10_000));
        }

        [Test]
        public void TheSameSeedGivesTheSameBoxesWhateverTheFrameRate([Values(0, 1, 2, 3, 4)] int scenario)
        {
            ulong[] first = HashesOf(SweepstakeLibrary.Scenes[scenario], 7, 1 / 60f);
            Assert.That(HashesOf(SweepstakeLibrary.Scenes[scenario], 7, 1 / 200f), Is.EqualTo(first));
            Assert.That(HashesOf(SweepstakeLibrary.Scenes[scenario], 8, 1 / 60f), Is.Not.EqualTo(first));
        }

        [Test]
        public void CountSpeedBoundsAndSeedChangeWhileItPlays()
        {
            var player = MakeManager().gameObject.AddComponent<ScenarioPlayer>();
            var manager = player.GetComponent<SweepstakeManager>();
            Frames(2);
            Assert.That(manager.LastSample.ObjectCount, Is.EqualTo(3000));
            player.ObjectCount = 100;
            Frames(1);
            Assert.That(manager.LastSample.ObjectCount, Is.EqualTo(100));
            Assert.That(player.Step, Is.EqualTo(1), "the scene restarts");
            ulong hash = player.Hash;
            foreach (Action change in new Action[] { () => player.Speed = 33, () => player.WorldHalfExtent = 12, () => player.Seed = 5, () => player.Scenario = "brownian" })
            {
                change();
                Frames(1);
                Assert.That(player.Hash, Is.Not.EqualTo(hash));
                hash = player.Hash;
            }
        }

        [Test]
        public void WhatCannotBePlayedIsToldOnceAndTheFormerSceneGoesOn()
        {
            var player = MakeManager().gameObject.AddComponent<ScenarioPlayer>();
            var manager = player.GetComponent<SweepstakeManager>();
            player.ObjectCount = 100;
            Frames(5);
            player.Scenario = "huricane";
            Frames(5);
            Assert.That(manager.State, Is.EqualTo(SweepstakeState.Embedded));
            Assert.That(Logged("hurricane"), Has.Exactly(1).Items, "the error lists the existing names");
            Assert.That((player.Step, manager.LastSample.ObjectCount), Is.EqualTo((10UL, 100U)));
            player.Scenario = "brownian";
            player.ObjectCount = -1;
            Frames(2);
            Assert.That((player.ObjectCount, player.Step, manager.LastSample.ObjectCount), Is.EqualTo((0, 2UL, 0U)));
            player.ObjectCount = int.MaxValue;
            Assert.That(player.ObjectCount, Is.EqualTo(ScenarioPlayer.MaxObjects));
            player.ObjectCount = 10;
            Frames(2);
            Assert.That(manager.LastSample.ObjectCount, Is.EqualTo(10));
            Assert.That(Logged(""), Has.Exactly(1).Items);
        }

        [Test]
        public void WithoutAnySceneNoBoxesArePlayed()
        {
            var player = MakeManager().gameObject.AddComponent<ScenarioPlayer>();
            var manager = player.GetComponent<SweepstakeManager>();
            player.Scenario = "nowhere.aabbs";
            Frames(3);
            Assert.That((manager.State, manager.LastSample.ObjectCount), Is.EqualTo((SweepstakeState.Embedded, 0U)));
            player.Scenario = "hurricane";
            Frames(1);
            Assert.That(manager.LastSample.ObjectCount, Is.EqualTo(3000));
        }

        [Test]
        public void TriggersHasAButtonForEachScenarioAndAlgorithmAndAKeyForTheRest()
        {
            var sample = new GameObject("triggers").AddComponent<Triggers>();
            var manager = sample.GetComponent<SweepstakeManager>();
            var player = sample.GetComponent<ScenarioPlayer>();
            player.ObjectCount = 50;
            Frames(2);
            foreach (string scenario in SweepstakeLibrary.Scenes.Take(5))
            {
                Click(scenario);
                Assert.That(player.Scenario, Is.EqualTo(scenario));
            }
            Assert.That(manager.Mode, Is.EqualTo(SessionMode.Ai));
            foreach (string algorithm in SweepstakeLibrary.Backends)
            {
                Click(algorithm);
                Frames(1);
                Assert.That((manager.ActiveBackend, manager.Mode), Is.EqualTo((algorithm, SessionMode.Manual)));
                Player.CallAll("OnGUI");
                Assert.That(GUILayout.Texts, Has.Some.EqualTo("● " + algorithm).And.Some.EqualTo("[M] Mode: Manual"));
            }
            Press('B');
            Frames(1);
            Assert.That(manager.ActiveBackend, Is.EqualTo(SweepstakeLibrary.Backends[0]), "the first follows the last");
            Press('M');
            Assert.That(manager.Mode, Is.EqualTo(SessionMode.Ai));
            Press('D');
            Assert.That(player.ObjectCount, Is.EqualTo(100));
            Click("Half");
            Assert.That(player.ObjectCount, Is.EqualTo(50));
        }

        [Test]
        public void TriggersShowsTheFiguresOfTheLatestFrame()
        {
            var sample = new GameObject("triggers").AddComponent<Triggers>();
            Frames(40);
            Player.CallAll("OnGUI");
            string shown = GUILayout.Texts.Last();
            Assert.That(shown, Does.Contain("3000 objects").And.Contain(" pairs").And.Contain(" ms of ").And.Contain("AABB checks; verdict: "));
            Assert.That(shown, Does.Contain(sample.GetComponent<SweepstakeManager>().ActiveBackend + ": ").And.Match("Frame [0-9]+: [1-9]"));
        }

        [Test]
        public void TriggersComparesEachAlgorithmAndAiDecides()
        {
            Triggers sample = MakeComparing(500);
            var manager = sample.GetComponent<SweepstakeManager>();
            FramesUntil(() => File.Exists(Triggers.ComparisonPath), "complete");
            string[][] rows = File.ReadAllLines(Triggers.ComparisonPath).Select(row => row.Split(',')).ToArray();
            Assert.That(rows[0], Is.EqualTo(new[] { "algorithm", "frames", "detection ms", "frame ms", "checks", "pairs" }));
            Assert.That(rows.Skip(1).Select(row => row[0]), Is.EqualTo(SweepstakeLibrary.Backends.Append("AI Decides")));
            Assert.That(rows.Skip(1).Select(row => int.Parse(row[1])), Is.All.GreaterThan(5));
            Assert.That(rows.Skip(1).SelectMany(row => row.Skip(2)).Select(value => double.Parse(value)), Is.All.GreaterThan(0), "each value was measured");
            Frames(2);
            Assert.That((manager.Mode, manager.ActiveBackend), Is.EqualTo((SessionMode.Manual, "Tracy")), "as before");
            Player.CallAll("OnGUI");
            Assert.That(GUILayout.Texts.TakeLast(6), Is.EqualTo(rows.Last()), "the table is on the screen");
            Assert.That(Logged(Triggers.ComparisonPath), Has.Exactly(1).Items);
        }

        [Test]
        public void AStoppedComparisonWritesNothingAndManyBoxesSkipBruteForce()
        {
            Triggers sample = MakeComparing(10_001);
            var manager = sample.GetComponent<SweepstakeManager>();
            Frames(1);
            Assert.That(manager.ActiveBackend, Is.EqualTo(SweepstakeLibrary.Backends.First(name => name != "BruteForce")));
            Click("Stop comparing");
            Frames(60);
            Assert.That((manager.Mode, manager.ActiveBackend), Is.EqualTo((SessionMode.Manual, "Tracy")));
            Assert.That(File.Exists(Triggers.ComparisonPath), Is.False);
        }

        [Test]
        public void TriggersSavesARowPerFrame()
        {
            var sample = new GameObject("triggers").AddComponent<Triggers>();
            sample.GetComponent<ScenarioPlayer>().ObjectCount = 50;
            Frames(2);
            Press('S');
            Frames(20);
            Click("Stop saving");
            Assert.That(File.ReadAllText(Triggers.FramesPath), Does.Contain("hurricane"));
            Assert.That(File.ReadAllLines(Triggers.FramesPath).Length, Is.InRange(20, 24), "a heading, and a row per frame");
            File.Delete(Triggers.FramesPath);
            Directory.CreateDirectory(Triggers.FramesPath);
            Click("Save frames");
            Assert.That(Logged("error: "), Has.Exactly(1).Items, "a folder has the name of the file");
            Player.CallAll("OnGUI");
            Assert.That(GUILayout.Texts, Has.Some.Contains("Save frames"));
        }

        [Test]
        public void JobsFindTheOraclesNeighbours()
        {
            var sample = new GameObject("jobs").AddComponent<JobBoids>();
            Frames(30);
            Aabb[] boxes = ((IEnumerable<Aabb>)Field(sample, "boxes")).ToArray();
            int[] neighbours = ((IEnumerable<int>)Field(sample, "neighbours")).ToArray();
            var expected = new int[boxes.Length];
            for (int a = 0; a < boxes.Length; ++a)
            {
                for (int b = a + 1; b < boxes.Length; ++b)
                {
                    if (!boxes[a].Overlaps(boxes[b]))
                        continue;
                    ++expected[a];
                    ++expected[b];
                }
            }
            Assert.That(neighbours, Is.EqualTo(expected));
            Assert.That(sample.TouchingCount, Is.EqualTo(expected.Count(count => count > 0)).And.GreaterThan(0));
        }

        [Test]
        public void ARecordingIsWhatTheCommandLineMeasures()
        {
            GameObject made = MakeManager().gameObject;
            made.AddComponent<ScenarioPlayer>().ObjectCount = 60;
            var recorder = made.AddComponent<LevelRecorder>();
            Frames(31);
            recorder.enabled = false;
            using var played = new MotionScene(recorder.FilePath);
            using var original = new MotionScene("hurricane", Options(60));
            for (int step = 0; step < 30; ++step)
            {
                original.Step();
                Assert.That(played.Boxes.ToArray(), Is.EqualTo(original.Boxes.ToArray()));
                played.Step();
            }
            string costs = Path.Combine(Folder, "level.costs");
            RunTool("trace", "--scene", recorder.FilePath, "--out", costs);
            Assert.That(new FileInfo(costs).Length, Is.GreaterThan(0));
            Assert.That(
                RunTool("bench", "--scene", recorder.FilePath, "--frames", "20", "--warmup", "2", "--arms", "SAP", "--json"), Does.Contain("\"objects\": 60").Or.Contain("\"objects\":60"));
        }

        [Test]
        public void ARecordingTakesCountsThatChangeAndBoxesThatAreBroken()
        {
            string path = Path.Combine(Folder, "changing.aabbs");
            var frames = new List<List<Aabb>>();
            for (int frame = 0; frame < 10; ++frame)
                frames.Add(Enumerable.Range(0, frame % 4 + 1).Select(index => new Aabb(index, 0, frame, index + 1, 1, frame + 1)).ToList());
            frames[3][0] = new Aabb(float.NaN, 0, 0, 1, 1, 1);
            using (var writer = new AabbsWriter(path, "level one\n"))
            {
                foreach (List<Aabb> frame in frames)
                    writer.Write(frame);
                Assert.That(File.Exists(path), Is.False, "the file must not exist before it is complete");
                writer.Finish();
            }
            using var played = new MotionScene(path);
            for (int frame = 0; frame < frames.Count; ++frame)
            {
                Aabb[] boxes = played.Boxes.ToArray();
                Assert.That(boxes.Length, Is.EqualTo(frames[frame].Count));
                Assert.That(boxes.Where(box => box.IsValid), Is.EqualTo(frames[frame].Where(box => box.IsValid)));
                played.Step();
            }
            RunTool("check", "--scene", path);
        }

        [Test]
        public void ARecordedColliderHasOneIndexForLifeWhateverComesAndGoes()
        {
            var tracker = MakeManager().gameObject.AddComponent<ColliderTracker>();
            var recorder = tracker.gameObject.AddComponent<LevelRecorder>();
            var random = new System.Random(11);
            var live = new List<BoxCollider>();
            var frames = new List<float[]>();
            for (int made = 0; frames.Count < 40; ++made)
            {
                live.Add(MakeBox(new Vector3(0, 3 * made, 0), 0, random.Next(3) == 0));
                tracker.Scan();
                tracker.Refresh(live[random.Next(live.Count)]);
                BoxCollider gone = live[random.Next(live.Count)];
                if (random.Next(3) > 0 && live.Remove(gone))
                    UnityEngine.Object.DestroyImmediate(gone.gameObject);
                Frames(1);
                frames.Add(live.Select(box => box.bounds.min.y).ToArray());
            }
            recorder.enabled = false;
            using var played = new MotionScene(recorder.FilePath);
            var indices = new Dictionary<float, int>();
            foreach (float[] expected in frames)
            {
                List<Aabb> boxes = played.Boxes.ToArray().ToList();
                Assert.That(boxes.Where(box => box.IsValid).Select(box => box.MinY), Is.EquivalentTo(expected));
                foreach (float height in expected)
                {
                    int index = boxes.FindIndex(box => box.IsValid && box.MinY == height);
                    Assert.That(index, Is.EqualTo(indices.TryAdd(height, index) ? index : indices[height]));
                }
                played.Step();
            }
            Assert.That(indices.Values.Max(), Is.LessThan(frames.Max(expected => expected.Length) + 1), "free indices are used again");
        }

        [Test]
        public void NothingToRecordIsSaidAndLeavesNoFile()
        {
            GameObject made = MakeManager().gameObject;
            made.AddComponent<ColliderTracker>();
            var recorder = made.AddComponent<LevelRecorder>();
            Frames(3);
            recorder.enabled = false;
            Assert.That(Logged("nothing to record"), Has.Exactly(1).Items);
            Assert.That(Directory.GetFiles(Folder), Is.Empty);
        }

        private static ulong[] HashesOf(string scenario, uint seed, float frameSeconds)
        {
            var player = MakeManager().gameObject.AddComponent<ScenarioPlayer>();
            player.Scenario = scenario;
            player.ObjectCount = 100;
            player.Seed = seed;
            var hashes = new ulong[10];
            while (player.Step < 10)
            {
                Player.Frame(frameSeconds);
                hashes[player.Step - 1] = player.Hash;
            }
            UnityEngine.Object.DestroyImmediate(player.gameObject);
            return hashes;
        }

        /// <summary>A sample that compares, with short runs; before, Tracy was chosen.</summary>
        private static Triggers MakeComparing(int objects)
        {
            var sample = new GameObject("triggers").AddComponent<Triggers>();
            Set(sample, "secondsEach", 0.2f);
            sample.GetComponent<ScenarioPlayer>().ObjectCount = objects;
            sample.GetComponent<ScenarioPlayer>().WorldHalfExtent = 10;
            Frames(1);
            Click("Tracy");
            Frames(2);
            Press('C');
            return sample;
        }

        private static SceneOptions Options(uint objects)
        {
            SceneOptions options = SceneOptions.Default;
            options.ObjectCount = objects;
            return options;
        }

        [Test]
        public void TheRecordersLevelIsRecorded()
        {
            GameObject made = MakeManager().gameObject;
            made.AddComponent<MovingCubes>();
            var recorder = made.AddComponent<LevelRecorder>();
            Frames(20);
            recorder.enabled = false;
            using var played = new MotionScene(recorder.FilePath);
            Aabb[] first = played.Boxes.ToArray();
            Assert.That(first.Count(box => box.IsValid), Is.EqualTo(200));
            played.Step();
            played.Step();
            Assert.That(played.Boxes.ToArray(), Is.Not.EqualTo(first));
        }

        private static object Field(object owner, string name) =>
            owner.GetType().GetField(name, System.Reflection.BindingFlags.Instance | System.Reflection.BindingFlags.NonPublic)!.GetValue(owner);

        private static string RunTool(params string[] arguments)
        {
            using Process process = Process.Start(new ProcessStartInfo(DaemonProcess.Program("sweepstake-lab"), arguments) { RedirectStandardOutput = true });
            string output = process!.StandardOutput.ReadToEnd();
            process.WaitForExit();
            Assert.That(process.ExitCode, Is.EqualTo(0), output);
            return output;
        }
    }
}
