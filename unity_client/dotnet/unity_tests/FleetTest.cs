using System;
using System.Diagnostics;
using System.Linq;
using System.Net.Http;
using NUnit.Framework;
using Sweepstake.Editor;
using Sweepstake.Samples;
using Sweepstake.Unity;
using UnityEngine;

namespace Sweepstake.Tests
{
    /// <summary>Plays the sample Fleet with and without a real daemon.</summary>
    public sealed class FleetTest : Stage
    {
        private static readonly string[] Levels = { "forest", "harbour", "arena" };

        [Test]
        public void EachLevelConnectsAndShowsWhatTheDaemonDecidesAndWhy()
        {
            using var daemon = new DaemonProcess("--http", "127.0.0.1:0");
            Fleet fleet = MakeFleet(daemon.Address, "http://" + daemon.HttpAddress);
            FramesUntil(() => Levels.All(level => fleet.Text.Contains(level + ": Online")), "connected; " + fleet.Text);
            FramesUntil(() => fleet.Managers.All(manager => manager.Verdict.Kind != VerdictKind.Unknown), "shown a verdict");
            Frames(30);
            Assert.That(fleet.Text, Does.Not.Contain("No level is connected").And.Contain(" is the best with "));
            Assert.That(fleet.Text.Split("Decision: ").Length, Is.EqualTo(4));
            Assert.That(fleet.Text.Split("Verdict: ").Length, Is.EqualTo(4));
            using var browser = new HttpClient();
            Assert.That(browser.GetStringAsync($"http://{daemon.HttpAddress}/metrics").Result, Does.Contain("\nsweepstake_open_streams 3\n"));
            Click("dashboard");
            Assert.That(browser.GetStringAsync(Application.OpenedUrl).Result, Does.Contain("<html"), "the button opens the daemon's dashboard");

            using var watcher = new PosteriorWatcher();
            watcher.Start(fleet.Managers[0].Config.daemon, "fleet");
            FramesUntil(() => watcher.Latest.Lines.Select(line => line.Scene).Distinct().Count() == 3, "learnt in each level");
            Assert.That(watcher.Latest.Lines.Select(line => line.Scene).Distinct(), Is.EquivalentTo(Levels));
        }

        [Test]
        public void ADaemonThatIsGoneShowsTheCommandAndALaterOneIsUsed()
        {
            using var daemon = new DaemonProcess();
            Fleet fleet = MakeFleet(daemon.Address, "");
            FramesUntil(() => fleet.Text.Contains("arena: Online"), "connected");
            daemon.Kill();
            FramesUntil(() => fleet.Text.Contains(Fleet.StartCommand), "shown the command");
            Assert.That(fleet.Text, Does.Contain("forest: Offline").And.Contain(daemon.Address));
            ulong frame = fleet.Managers[0].LastSample.FrameIndex;
            Frames(10);
            Assert.That(fleet.Managers[0].LastSample.FrameIndex, Is.EqualTo(frame + 10), "the game continues");
            daemon.Restart();
            FramesUntil(() => fleet.Text.Contains("arena: Online"), "connected again");
            FramesUntil(() => !fleet.Text.Contains(Fleet.StartCommand), "without the command");
        }

        [Test]
        public void TheCommandStartsADaemonForTheSample()
        {
            var fleet = new GameObject("fleet").AddComponent<Fleet>();
            Frames(1);
            Press('C');
            Assert.That(GUIUtility.systemCopyBuffer, Is.EqualTo(Fleet.StartCommand));
            string[] words = Fleet.StartCommand.Split(' ');
            Assert.That(words[0], Is.EqualTo("sweepstaked"));
            using Process daemon = Process.Start(new ProcessStartInfo(DaemonProcess.Program(words[0]), words.Skip(1).Append("--print-config")) { RedirectStandardOutput = true });
            string config = daemon!.StandardOutput.ReadToEnd();
            daemon.WaitForExit();
            Assert.That(daemon.ExitCode, Is.EqualTo(0));
            Press('O');
            Assert.That(config, Does.Match($"listen *= *\"{fleet.Managers[0].Config.daemon.address}\""));
            Assert.That("http://" + words.Last(), Is.EqualTo(Application.OpenedUrl));
        }

        [Test]
        public void WhatPreventsAConnectionIsShownForEachLevel()
        {
            Fleet fleet = MakeFleet("nowhere", "");
            FramesUntil(() => fleet.Text.Split("HOST:PORT").Length == 4, "shown the format of an address; " + fleet.Text);
            Assert.That(fleet.Text, Does.Contain("Set Define").And.Contain(Fleet.StartCommand));
            Assert.That(fleet.Managers.Select(manager => manager.LastSample.ObjectCount), Is.All.EqualTo(100), "the levels play");
        }

        private static Fleet MakeFleet(string address, string dashboard)
        {
            var fleet = new GameObject("fleet").AddComponent<Fleet>();
            Set(fleet, "address", address);
            Set(fleet, "dashboard", dashboard);
            Set(fleet, "objectCount", 100);
            return fleet;
        }
    }
}
