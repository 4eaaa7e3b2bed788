using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.IO;
using System.Linq;
using System.Net.Http;
using System.Text.RegularExpressions;
using NUnit.Framework;
using Sweepstake.GrpcNet;
using Sweepstake.Protocol.V1;

namespace Sweepstake.Tests
{
    /// <summary>The whole way: the sample plays Hurricane with 3,000 objects through C#, and the daemon's own tools look at what came of it.</summary>
    public sealed class HeadlessTest
    {
        [Test]
        public void HurricaneIsLearntAndItsDecisionsDeriveAgain()
        {
            using var daemon = new DaemonProcess("--http", "127.0.0.1:0");
            string output = Headless(
                0, "--daemon", daemon.Address, "--objects", "3000", "--frames", "1500", "--time-scale", "100", "--policy", "paper");
            Match sent = Regex.Match(output, @"(\d+) frames sent, (\d+) dropped, 0 refused");
            Assert.That(sent.Success, Is.True, output);
            Assert.That(int.Parse(sent.Groups[1].Value) + int.Parse(sent.Groups[2].Value), Is.EqualTo(1500));
            Match session = Regex.Match(output, @"session (\S+)");

            using var client = new DaemonClient(new DaemonEndpoint { Address = daemon.Address });
            ScenePosterior scene = client.Posteriors.GetPosterior(
                new GetPosteriorRequest { Project = "default", Scene = "hurricane-3000", RewardVersion = 1 }).Scene;
            Assert.That(scene.Arms.Sum(arm => (long)arm.WindowCount), Is.GreaterThan(0));
            using var browser = new HttpClient();
            Assert.That(browser.GetStringAsync($"http://{daemon.HttpAddress}/metrics").Result, Does.Match(@"sweepstake_\w*frames\w*(\{[^}]*\})? [1-9]"));

            string decisions = Path.Combine(daemon.Folder, "decisions.csv");
            RunTool("audit", "export", "--daemon", daemon.Address, "--out", decisions);
            string[] rows = File.ReadAllLines(decisions);
            Assert.That(rows.Count(row => row.Contains(session.Groups[1].Value)), Is.GreaterThan(3));
            RunTool("replay", "--log", decisions);
        }

        [Test]
        public void WithoutADaemonItDecidesItself()
        {
            string csv = Path.GetTempFileName();
            string output = Headless(0, "--objects", "300", "--frames", "200", "--csv", csv);
            Assert.That(output, Does.Contain("frame 200").And.Contain("embedded"));
            Assert.That(File.ReadAllLines(csv).Length, Is.EqualTo(201));
            File.Delete(csv);
        }

        [Test]
        public void BadUsageIsSaid()
        {
            Headless(2, "--objects", "many");
            Headless(2, "--scene", "huricane");
            Headless(2, "--what", "1");
            Assert.That(Headless(0, "--help"), Does.Contain("--daemon HOST:PORT"));
        }

        private static string Headless(int exitCode, params string[] arguments)
        {
            string program = Path.Combine(AppContext.BaseDirectory, "Sweepstake.Headless.dll");
            return Run("dotnet", exitCode, new List<string> { program }.Concat(arguments));
        }

        private static void RunTool(params string[] arguments)
        {
            Run(DaemonProcess.Program("sweepstake"), 0, arguments);
        }

        private static string Run(string program, int exitCode, IEnumerable<string> arguments)
        {
            using Process process = Process.Start(new ProcessStartInfo(program, arguments) { RedirectStandardOutput = true });
            string output = process.StandardOutput.ReadToEnd();
            process.WaitForExit();
            Assert.That(process.ExitCode, Is.EqualTo(exitCode), output);
            return output;
        }
    }
}
