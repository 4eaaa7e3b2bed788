using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.IO;
using System.Linq;
using System.Net.Http;
using System.Reflection;
using System.Text.Json;
using System.Text.RegularExpressions;
using Google.Protobuf;
using NUnit.Framework;
using Sweepstake.Editor;
using Sweepstake.GrpcNet;
using Sweepstake.Protocol.V1;

namespace Sweepstake.Tests
{
    /// <summary>
    /// Tests all parts together: the sample plays Hurricane with 3,000 objects through C#, and the daemon's own tools check the result.
    /// </summary>
    public sealed class HeadlessTest
    {
        private const string Scene = "hurricane-3000";

        /// <summary>Tests "adaptive", the policy of AI Decides with the lane, and "paper".</summary>
        [TestCase("adaptive")]
        [TestCase("paper")]
        public void HurricaneIsLearntShownAndDerivedAgainAsThatOfTheCppClient(string policy)
        {
            using var daemon = new DaemonProcess("--http", "127.0.0.1:0");
            string output = Headless(
                0, "--daemon", daemon.Address, "--objects", "3000", "--frames", "6000", "--time-scale", "100", "--policy", policy);
            Match sent = Regex.Match(output, @"(\d+) frames sent, (\d+) dropped, 0 refused");
            Assert.That(sent.Success, Is.True, output);
            Assert.That(int.Parse(sent.Groups[1].Value) + int.Parse(sent.Groups[2].Value), Is.EqualTo(6000));

            using var client = new DaemonClient(new DaemonEndpoint { Address = daemon.Address });
            var request = new ListPosteriorsRequest { Project = "default" };
            ListPosteriorsResponse learnt = client.Posteriors.ListPosteriors(request);
            Assert.That(learnt.Scenes.Single().Scene, Is.EqualTo(Scene));
            Assert.That(learnt.Scenes.Single().Arms.Sum(arm => (long)arm.WindowCount), Is.GreaterThan(0));
            using var browser = new HttpClient { BaseAddress = new Uri($"http://{daemon.HttpAddress}") };
            Assert.That(PostedList(browser, request), Is.EqualTo(learnt), "HTTP says what gRPC says");
            Assert.That(DashboardScenes(browser), Is.EqualTo(new[] { Scene }), "the scenes that the dashboard shows");

            // The run makes about 45 decisions. Even if the disk is busy, all their rows fit into the audit log's queue, so none is lost.
            RunTool(
                "run", "--daemon", daemon.Address, "--scene", "hurricane", "--objects", "3000", "--mode", "ai", "--policy", policy,
                "--time-scale", "30", "--duration", "3s");
            string ofCSharp = Regex.Match(output, @"session (\S+)").Groups[1].Value;
            Assert.That(DecisionsDerivedAgain(daemon, 1, "--session", ofCSharp), Is.GreaterThan(3));
            Assert.That(DecisionsDerivedAgain(daemon, 2), Is.GreaterThan(DecisionsDerivedAgain(daemon, 1, "--session", ofCSharp) + 3));
        }

        [Test]
        public void WithoutADaemonItDecidesItself()
        {
            string csv = Path.GetTempFileName();
            string output = Headless(0, "--objects", "300", "--frames", "200", "--csv", csv);
            Assert.That(output, Does.Contain("frame 200").And.Contain("embedded"));
            Assert.That(File.ReadAllLines(csv).Length, Is.EqualTo(201));
            File.Delete(csv);
            Headless(1, "--objects", "10", "--frames", "10", "--csv", "/dev/full");
        }

        /// <summary>
        /// A native program has no code that is compiled at run time and no unused code, as with IL2CPP. dotnet_test.sh builds it.
        /// </summary>
        [Test]
        public void ANativeProgramPlaysAgainstADaemonWithoutGoogleProtobuf()
        {
            string program = Environment.GetEnvironmentVariable("UNITY_CLIENT_NATIVE");
            Assume.That(program, Is.Not.Null, "dotnet_test.sh says why it did not build the program");
            Assert.That(File.ReadAllText(program, System.Text.Encoding.Latin1), Does.Contain("Grpc.Net.Client").And.Not.Contain("Google.Protobuf"));
            using var daemon = new DaemonProcess();
            string output = Run(program, 0, new[] { "--daemon", daemon.Address, "--objects", "300", "--frames", "2000" });
            Match sent = Regex.Match(output, @"(\d+) frames sent, (\d+) dropped, 0 refused; (\d+) of \3 messages acknowledged");
            Assert.That(sent.Success, Is.True, output);
            Assert.That(int.Parse(sent.Groups[1].Value) + int.Parse(sent.Groups[2].Value), Is.EqualTo(2000));
        }

        [Test]
        public void BadUsageIsSaid()
        {
            Headless(2, "--objects", "many");
            Headless(2, "--scene", "huricane");
            Headless(2, "--what", "1");
            Headless(2, "--csv", "/dev/null/frames.csv");
            Assert.That(Headless(0, "--help"), Does.Contain("--daemon HOST:PORT"));
        }

        /// <summary>The tests above run the sample with these files only: .NET loads nothing else for it.</summary>
        [Test]
        public void APlayerNeedsNoGoogleProtobuf()
        {
            string files = File.ReadAllText(Path.Combine(AppContext.BaseDirectory, "Sweepstake.Headless.deps.json"));
            Assert.That(files, Does.Contain("Grpc.Net.Client.dll").And.Contain("Sweepstake.GrpcNet.dll").And.Not.Contain("Google.Protobuf"));
            var names = new List<string> { "Sweepstake.Headless" };
            for (int next = 0; next < names.Count; ++next)
            {
                if (File.Exists(Path.Combine(AppContext.BaseDirectory, names[next] + ".dll")))
                    names.AddRange(Assembly.Load(names[next]).GetReferencedAssemblies().Select(reference => reference.Name).Except(names));
            }
            Assert.That(names, Does.Contain("Sweepstake.GrpcNet").And.Contain("Grpc.Core.Api").And.Not.Contain("Google.Protobuf"));
        }

        private static string Headless(int exitCode, params string[] arguments)
        {
            string program = Path.Combine(AppContext.BaseDirectory, "Sweepstake.Headless.dll");
            return Run("dotnet", exitCode, new List<string> { program }.Concat(arguments));
        }

        private static ListPosteriorsResponse PostedList(HttpClient browser, ListPosteriorsRequest request)
        {
            using var post = new HttpRequestMessage(HttpMethod.Post, "/api/sweepstake.v1.PosteriorsService/ListPosteriors")
            {
                Content = new StringContent(JsonFormatter.Default.Format(request)),
            };
            post.Headers.Add("X-Sweepstake", "1");
            using HttpResponseMessage response = browser.Send(post);
            return ListPosteriorsResponse.Parser.ParseJson(response.EnsureSuccessStatusCode().Content.ReadAsStringAsync().Result);
        }

        /// <summary>The scenes in the first snapshot of the dashboard's events.</summary>
        private static string[] DashboardScenes(HttpClient browser)
        {
            const string Data = "data: ";
            using var events = new StreamReader(browser.GetStreamAsync("/events/sweepstake.v1.PosteriorsService/WatchPosteriors?request=%7B%7D").Result);
            var scenes = new List<string>();
            for (string line = events.ReadLine(); line != "event: snapshot-end"; line = events.ReadLine())
            {
                Assert.That(line, Is.Not.Null, "the events have ended");
                if (line.StartsWith(Data) && WatchPosteriorsResponse.Parser.ParseJson(line.Substring(Data.Length)).Posterior is ScenePosterior told)
                    scenes.Add(told.Scene);
            }
            return scenes.ToArray();
        }

        /// <summary>
        /// Checks the number of sessions in the audit log and that all decisions can be derived from it; returns their number.
        /// </summary>
        private static long DecisionsDerivedAgain(DaemonProcess daemon, long sessions, params string[] filter)
        {
            string log = Path.Combine(daemon.Folder, "decisions.csv");
            RunTool(new[] { "audit", "export", "--daemon", daemon.Address, "--out", log }.Concat(filter).ToArray());
            using JsonDocument report = JsonDocument.Parse(Run(DaemonProcess.Program("sweepstake-lab"), 0, new[] { "replay", "--log", log, "--json" }));
            long Member(string name) => report.RootElement.GetProperty(name).GetInt64();
            Assert.That(report.RootElement.GetProperty("equal").GetBoolean(), Is.True);
            Assert.That((Member("sessions"), Member("underived_decisions")), Is.EqualTo((sessions, 0L)));
            return Member("decisions");
        }

        private static string RunTool(params string[] arguments) => Run(DaemonProcess.Program("sweepstake"), 0, arguments);

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
