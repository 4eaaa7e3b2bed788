using System;
using System.IO;
using System.Linq;
using System.Net.Http;
using System.Runtime.CompilerServices;
using System.Threading;
using NUnit.Framework;
using Sweepstake.Editor;
using Sweepstake.Samples;
using Sweepstake.Unity;
using UnityEditor;
using UnityEngine;

namespace Sweepstake.Tests
{
    /// <summary>Tests the manager and the window with a real daemon.</summary>
    public sealed class DaemonTest : Stage
    {
        [Test]
        public void ADaemonThatIsKilledAndComesBackIsOneLineEach()
        {
            using var daemon = new DaemonProcess();
            SweepstakeManager manager = MakeConnected(daemon.Address);
            FramesUntil(() => manager.State == SweepstakeState.Online, "online");
            Assert.That(manager.Problem, Is.Empty);
            daemon.Kill();
            FramesUntil(() => manager.State == SweepstakeState.Offline, "offline");
            ulong frame = manager.LastSample.FrameIndex;
            Frames(300);
            Assert.That(manager.LastSample.FrameIndex, Is.EqualTo(frame + 300), "the game continues");
            Assert.That(manager.Problem, Is.Not.Empty);
            daemon.Restart();
            FramesUntil(() => manager.State == SweepstakeState.Online, "online again");
            Assert.That(Debug.Lines, Has.Count.EqualTo(3), string.Join("\n", Debug.Lines));
        }

        [Test]
        public void ADaemonThatIsAbsentIsOneLineAndNoError()
        {
            string address;
            using (var probe = new DaemonProcess())
                address = probe.Address;
            SweepstakeManager manager = MakeConnected(address);
            FramesUntil(() => manager.State == SweepstakeState.Offline, "offline without a daemon");
            for (int wait = 0; wait < 100; ++wait)
            {
                Frames(1);
                Thread.Sleep(5);
            }
            Assert.That(manager.State, Is.EqualTo(SweepstakeState.Offline));
            Assert.That(Debug.Lines, Has.Count.EqualTo(1), string.Join("\n", Debug.Lines));
        }

        [Test]
        public void ConnectAndDisconnectWhileTheGamePlays()
        {
            using var daemon = new DaemonProcess();
            SweepstakeManager manager = MakeManager(config => config.daemon.address = daemon.Address);
            manager.gameObject.AddComponent<ScenarioPlayer>().ObjectCount = 50;
            Frames(5);
            Assert.That(manager.State, Is.EqualTo(SweepstakeState.Embedded));
            Assert.That(manager.Connection, Is.Null, "a config alone does not connect");
            manager.Connect();
            FramesUntil(() => manager.State == SweepstakeState.Online, "online");
            Assert.That(manager.Decider, Is.Null);
            manager.Disconnect();
            Frames(5);
            Assert.That(manager.State, Is.EqualTo(SweepstakeState.Embedded));
            Assert.That(manager.Decider, Is.Not.Null);
        }

        [Test]
        public void ARecompilationWhileConnectedEndsTheStreamAndTheGameConnectsAgain()
        {
            using var daemon = new DaemonProcess("--http", "127.0.0.1:0");
            SweepstakeManager manager = MakeConnected(daemon.Address);
            FramesUntil(() => manager.State == SweepstakeState.Online, "online");
            string session = manager.Connection.Status.SessionId;
            RuntimeHelpers.RunClassConstructor(typeof(EditorLifetime).TypeHandle);
            AssemblyReloadEvents.SayReload();
            Assert.That((SweepstakeLibrary.LiveCount(), SessionWork.RunningCount), Is.EqualTo((0, 0)));
            FramesUntil(() => HasOpenStreams(daemon, 0), "without a stream");

            manager.gameObject.SetActive(false);
            manager.gameObject.SetActive(true);
            FramesUntil(() => manager.State == SweepstakeState.Online, "online in the new domain");
            Assert.That(manager.Connection.Status.SessionId, Is.Not.EqualTo(session));
            FramesUntil(() => HasOpenStreams(daemon, 1), "with one stream");
            Assert.That(Debug.Lines, Has.Count.EqualTo(2), string.Join("\n", Debug.Lines));
        }

        [Test]
        public void AWrongSettingIsToldAndTheGameDecidesItself()
        {
            SweepstakeManager manager = MakeConnected("nowhere");
            Frames(3);
            if (manager.State == SweepstakeState.Embedded)
                Assert.That(manager.Problem, Does.Contain("HOST:PORT"));
            else
                FramesUntil(() => manager.Problem.Contains("HOST:PORT"), "shown the format of an address");
            Assert.That(manager.LastSample.FrameIndex, Is.GreaterThan(0));
        }

        [Test]
        public void TheRightTokenLetsInAndAWrongOneIsRefused()
        {
            string token = null;
            using var daemon = new DaemonProcess(
                made => token = made.Run("token", "create", "default", "--role", "ingest"), new[] { "--require-tokens" });
            string file = Path.Combine(daemon.Folder, "token");
            File.WriteAllText(file, token);
            SweepstakeManager right = MakeConnected(daemon.Address, file);
            FramesUntil(() => right.State == SweepstakeState.Online, "online");
            File.WriteAllText(file + "2", "swt_wrong");
            SweepstakeManager wrong = MakeConnected(daemon.Address, file + "2");
            FramesUntil(() => wrong.State == SweepstakeState.Refused, "refused");
            Assert.That(wrong.Problem, Does.Contain("token"));
            Assert.That(Logged("token"), Has.Exactly(1).Items);
        }

        [Test]
        public void FilesOfAConfigAreBelowStreamingAssetsUnlessTheyAreAbsolute()
        {
            Application.streamingAssetsPath = "/game/StreamingAssets";
            var endpoint = DaemonTransport.EndpointOf(new DaemonSettings { address = "host:1", usesTls = true, tokenFile = "keys/token" });
            Assert.That((endpoint.Address, endpoint.UsesTls), Is.EqualTo(("host:1", true)));
            Assert.That(endpoint.TokenFile, Is.EqualTo("/game/StreamingAssets/keys/token"));
            Assert.That(DaemonTransport.EndpointOf(new DaemonSettings { tokenFile = "/etc/token" }).TokenFile, Is.EqualTo("/etc/token"));
            var tls = new DaemonSettings { usesTls = true, caFile = "ca.pem", certFile = "/etc/cert.pem", keyFile = "key.pem" };
            Assert.That(
                DaemonTransport.TlsFilesOf(tls), Is.EqualTo(("/game/StreamingAssets/ca.pem", "/etc/cert.pem", "/game/StreamingAssets/key.pem")));
            tls.usesTls = false;
            Assert.That(DaemonTransport.TlsFilesOf(tls), Is.EqualTo(((string)null, (string)null, (string)null)));
            endpoint = DaemonTransport.EndpointOf(new DaemonSettings());
            Assert.That((endpoint.UsesTls, endpoint.TokenFile), Is.EqualTo((false, (string)null)));
            Assert.That(endpoint.IsLoopback, Is.True);
        }

        [Test]
        public void WhereStreamingAssetsAreNoFilesTheConfigSaysWhatToDo()
        {
            Application.streamingAssetsPath = "jar:file:///data/app/game/base.apk!/assets";
            var settings = new DaemonSettings { address = "host:1", tokenFile = "arcade.token" };
            Assert.That(
                Assert.Throws<SweepstakeException>(() => DaemonTransport.EndpointOf(settings)).Message,
                Does.Contain("'arcade.token'").And.Contain("persistentDataPath"));
            settings.tokenFile = "/data/user/0/game/files/arcade.token";
            Assert.That(DaemonTransport.EndpointOf(settings).TokenFile, Is.EqualTo(settings.tokenFile));
        }

        [Test]
        public void AFrameAllocatesNothingWhileTheManagerSends()
        {
            using var daemon = new DaemonProcess();
            SweepstakeManager manager = MakeConnected(daemon.Address);
            FramesUntil(() => manager.State == SweepstakeState.Online, "online");
            Frames(300);
            Assert.That(AllocatedBy(600), Is.EqualTo(0));
        }

        [Test]
        public void TheWindowWatchesPosteriorsAndMeasuresTheRoundTrip()
        {
            using var daemon = new DaemonProcess();
            SweepstakeManager manager = MakeConnected(daemon.Address);
            using var watcher = new PosteriorWatcher();
            Assert.That(watcher.IsRunning, Is.False, "it reads nothing before it is started");
            watcher.Start(manager.Config.daemon, manager.Config.project);
            FramesUntil(() => watcher.Latest.Lines.Count > 0 && watcher.Latest.RoundTripMs > 0, "updated with the posteriors; " + watcher.Latest.Problem);
            Assert.That(watcher.Latest.Lines.Select(line => line.Scene), Is.All.EqualTo("level"));
            Assert.That(watcher.Latest.Lines.Select(line => line.Mean), Is.All.InRange(0, 1));
            Assert.That(SweepstakeWindow.TextOf(watcher.Latest), Does.Contain("level").And.Contain("windows"));
            daemon.Kill();
            FramesUntil(() => watcher.Latest.Problem.Length > 0, "shown that the daemon is gone");
            Assert.That(watcher.Latest.Lines, Is.Not.Empty, "what was known stays");
        }

        [Test]
        public void AWatchThatEndsLeavesNothingToTheNextOne()
        {
            using var daemon = new DaemonProcess();
            SweepstakeManager manager = MakeConnected(daemon.Address);
            using var watcher = new PosteriorWatcher();
            DaemonSettings settings = manager.Config.daemon;
            watcher.Start(settings, manager.Config.project);
            FramesUntil(() => watcher.Latest.Lines.Count > 0 && watcher.Latest.RoundTripMs > 0, "updated with the posteriors; " + watcher.Latest.Problem);
            watcher.Dispose();
            Assert.That(watcher.IsRunning, Is.False);
            Assert.That(watcher.Latest.Lines, Is.Not.Empty, "what was known stays");
            Assert.That(watcher.Latest.RoundTripMs, Is.NaN, "a stopped watcher measures nothing");
            watcher.Start(settings, "another project");
            Assert.That(watcher.Latest.Lines, Is.Empty);
            FramesUntil(() => watcher.Latest.RoundTripMs > 0, "answered");
            Assert.That((watcher.Latest.Lines.Count, watcher.Latest.Problem), Is.EqualTo((0, "")));
            watcher.Start(settings, manager.Config.project);
            FramesUntil(() => watcher.Latest.Lines.Count > 0, "updated with the posteriors again");
        }

        [Test]
        public void WhatNobodyExpectsIsToldAndEndsTheWatch()
        {
            using var daemon = new DaemonProcess();
            using var watcher = new PosteriorWatcher();
            watcher.Start(new DaemonSettings { address = daemon.Address }, null);
            FramesUntil(() => !watcher.IsRunning, "ended");
            Assert.That(watcher.Latest.Problem, Is.Not.Empty);
            Assert.That(watcher.Latest.RoundTripMs, Is.NaN);
        }

        private static bool HasOpenStreams(DaemonProcess daemon, int count)
        {
            using var browser = new HttpClient();
            return browser.GetStringAsync($"http://{daemon.HttpAddress}/metrics").Result.Contains($"\nsweepstake_open_streams {count}\n");
        }

        private static SweepstakeManager MakeConnected(string address, string tokenFile = "")
        {
            SweepstakeManager manager = MakeManager(config =>
            {
                config.daemon.isUsed = true;
                config.daemon.address = address;
                config.daemon.tokenFile = tokenFile;
                config.daemon.batchIntervalMs = 20;
            });
            manager.gameObject.AddComponent<ScenarioPlayer>().ObjectCount = 50;
            return manager;
        }
    }
}
