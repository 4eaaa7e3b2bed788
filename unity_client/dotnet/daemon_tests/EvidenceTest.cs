using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Globalization;
using System.IO;
using System.Linq;
using System.Net.Http;
using System.Text.RegularExpressions;
using System.Threading;
using System.Threading.Tasks;
using NUnit.Framework;
using Sweepstake.GrpcNet;
using Sweepstake.Protocol.V1;
using Cells = System.Collections.Generic.Dictionary<string, string>;

namespace Sweepstake.Tests
{
    /// <summary>Tests that the same run over the C++ and over the C# transport gives the same evidence on the daemon's disk.</summary>
    public sealed class EvidenceTest
    {
        // The columns of a window in the audit log whose sums do not depend on where the window ends.
        private static readonly string[] Summed =
        {
            "frame_count", "ordinary_frame_count", "time_ns", "ordinary_detection_ns", "calm_frame_count", "rebuild_detection_ns", "check_count", "pair_count",
        };
        // The number of messages sent ahead of their acknowledgement. It is small enough that a decision never gets more lane visits than
        // it accepts.
        private const ulong MessagesAhead = 4;
        private const int Attempts = 10;
        // Equals DecisionSession::kMaxShadowSamples: a late decision uses only this number of visits, the latest ones.
        private const int VisitsOfALateDecision = 256;
        private static readonly TimeSpan AfterTheLastFrame = TimeSpan.FromSeconds(1);

        private DaemonProcess overCpp;
        private DaemonProcess overCSharp;

        [SetUp]
        public void StartDaemons()
        {
            overCpp = new DaemonProcess("--http", "127.0.0.1:0");
            overCSharp = new DaemonProcess("--http", "127.0.0.1:0");
        }

        [TearDown]
        public void EndDaemons()
        {
            overCpp.Dispose();
            overCSharp.Dispose();
        }

        [Test]
        public async Task ARunOverCppAndOverCSharpIsTheSameAcknowledgedEvidence()
        {
            // AI Decides leaves out frames in which the scene may change its regime. Which these are depends on the times of decisions.
            StreamTelemetryRequest[] sent = await PlayBothWays("--objects", "3000", "--policy", "paper", "--mode", "manual", "--arm", "SAP", "--shadow", "off", "--duration", "2s");
            double[] learnt = WindowSums(overCpp);
            Assert.That(WindowSums(overCSharp), Is.EqualTo(learnt));
            double frames = sent.Where(message => message.FrameBatch != null).Sum(message => message.FrameBatch.FrameTimeNs.Count);
            Assert.That(learnt[0], Is.GreaterThan(0).And.LessThanOrEqualTo(frames), "settling frames are excluded from learning");
        }

        /// <summary>
        /// Tests AI Decides with the lane. The two daemons may decide at different times and divide frames into windows differently, but
        /// their decisions have the same input.
        /// </summary>
        [Test]
        public async Task ARunOfAiDecidesWithTheLaneIsTheSameEvidenceToo()
        {
            // With this many objects, leaving BruteForce is worth it on every machine, because its cost is quadratic.
            await PlayBothWays("--objects", "10000", "--mode", "ai", "--arm", "BruteForce", "--shadow", "on", "--duration", "4s");
            string[] switches = Switches(overCpp);
            Assert.That(switches, Is.Not.Empty, "the daemon has decided");
            Assert.That(Switches(overCSharp), Is.EqualTo(switches));
            string[] visits = Visits(overCpp);
            Assert.That(Visits(overCSharp), Is.EqualTo(visits));
            Assume.That(visits, Is.Not.Empty, "the lane needs a second processor");
        }

        /// <summary>
        /// Plays over the C++ transport to one daemon, then sends the same messages over the C# transport to the other one. Returns the
        /// messages.
        /// </summary>
        private async Task<StreamTelemetryRequest[]> PlayBothWays(params string[] arguments)
        {
            List<byte[]> played = await PlayInTime(overCpp, address => PlayOverCpp(arguments, address));
            List<byte[]> replayed = await PlayInTime(overCSharp, address => Replay(played, address));
            Assert.That(replayed, Is.EqualTo(played), "byte by byte");
            string[] counters = Counters(overCpp);
            Assert.That(counters, Has.Some.Match("accepted_frames_total [1-9]"));
            Assert.That(Counters(overCSharp), Is.EqualTo(counters));
            return played.Select(Sent).ToArray();
        }

        /// <summary>Repeats the game until the daemon's decisions were in time (see WasInTime). Returns the messages.</summary>
        private static async Task<List<byte[]>> PlayInTime(DaemonProcess daemon, Func<string, Task> play)
        {
            for (int attempt = 0; attempt < Attempts; ++attempt)
            {
                if (attempt > 0)
                    daemon.BeginAnew();
                using var tap = new Http2Tap(daemon.Address, AfterTheLastFrame);
                await play(tap.Address);
                await tap.Passing;
                Assert.That(Sent(tap.Messages[0]).Hello, Is.Not.Null);
                if (WasInTime(daemon, tap.Messages))
                    return tap.Messages;
            }
            throw new AssertionException("the machine is too busy for a game");
        }

        private static Task PlayOverCpp(string[] arguments, string address)
        {
            Run(new[] { "run", "--scene", "hurricane", "--time-scale", "50", "--daemon", address }.Concat(arguments).ToArray());
            return Task.CompletedTask;
        }

        /// <summary>
        /// Returns whether the daemon has used all lane visits. A game waits only two seconds for the end, and a late daemon then loses
        /// visits in two ways: visits after its last decision, and visits that did not fit into a decision.
        /// </summary>
        private static bool WasInTime(DaemonProcess daemon, List<byte[]> played)
        {
            if (Sent(played[played.Count - 1]).Goodbye == null)
                return false;
            string[] sent = played.SelectMany(message => Sent(message).FrameBatch?.ShadowSamples.ToArray() ?? Array.Empty<ShadowSample>()).Select(NameOf).ToArray();
            string[] learnt = Rows(daemon, "tick").SelectMany(VisitsOf).Select(NameOf).ToArray();
            bool hadRoom = Rows(daemon, "tick").All(row => VisitsOf(row).Count() < VisitsOfALateDecision);
            if (hadRoom)
                Assert.That(learnt, Is.EqualTo(sent.Take(learnt.Length)), "a visit was lost, and no decision was late");
            return learnt.Length == sent.Length;
        }

        private static string NameOf(ShadowSample visit) => $"{visit.FirstFrameIndex}:{visit.Arm}";

        private static string NameOf(Cells visit) => $"{visit["shadow_first_frame_index"]}:{visit["shadow_arm"]}";

        private static StreamTelemetryRequest Sent(byte[] message) => StreamTelemetryRequest.Parser.ParseFrom(message);

        /// <summary>
        /// Sends these messages unchanged. As a game does, it sends some of them before earlier ones are acknowledged. It sends the goodbye
        /// when all others are acknowledged.
        /// </summary>
        private static async Task Replay(List<byte[]> messages, string address)
        {
            using var transport = new GrpcTelemetryTransport(new DaemonEndpoint { Address = address, Handler = Game.Sockets });
            using ITelemetryStream stream = transport.Open();
            ulong acknowledged = 0;
            await stream.WriteAsync(messages[0]);
            Assert.That(Parsed(await stream.ReadAsync()).Welcome, Is.Not.Null);
            Task reading = Task.Run(async () =>
            {
                while (await stream.ReadAsync() is byte[] response)
                    Volatile.Write(ref acknowledged, Parsed(response).Acknowledgement?.Sequence ?? acknowledged);
            });
            ulong sent = 0;
            for (int index = 1; index < messages.Count - 1; ++index)
            {
                await Until(() => Volatile.Read(ref acknowledged) + MessagesAhead >= sent);
                await stream.WriteAsync(messages[index]);
                sent = Sent(messages[index]).Sequence;
            }
            await Until(() => Volatile.Read(ref acknowledged) == sent);
            await stream.WriteAsync(messages[messages.Count - 1]);
            await stream.FinishAsync();
            await reading.WaitAsync(Eventually.Patience);
        }

        private static async Task Until(Func<bool> isSo)
        {
            for (Stopwatch watch = Stopwatch.StartNew(); !isSo(); await Task.Delay(1))
                Assert.That(watch.Elapsed, Is.LessThan(Eventually.Patience), "never acknowledged");
        }

        private static StreamTelemetryResponse Parsed(byte[] response) => StreamTelemetryResponse.Parser.ParseFrom(response);

        /// <summary>The daemon's counters of what it received from games.</summary>
        private static string[] Counters(DaemonProcess daemon)
        {
            using var browser = new HttpClient();
            string[] lines = browser.GetStringAsync($"http://{daemon.HttpAddress}/metrics").Result.Split('\n');
            return lines.Where(line => Regex.IsMatch(line, "^sweepstake_(accepted|applied|dropped|invalid|malformed|refused|rejected|replayed)_")).ToArray();
        }

        /// <summary>
        /// The sums of frames, times, checks and pairs over all windows of a policy without regimes. They do not depend on where windows
        /// end. The log has a window as it is before a decision, when its frames are still new.
        /// </summary>
        private static double[] WindowSums(DaemonProcess daemon)
        {
            var sums = new double[Summed.Length];
            foreach (List<Cells> row in Rows(daemon, "tick"))
            {
                for (int index = 0; index < Summed.Length; ++index)
                    sums[index] += double.Parse(row[0]["runs_active_new_frames_" + Summed[index]], CultureInfo.InvariantCulture);
            }
            return sums;
        }

        /// <summary>The lane visits in the order of their arrival.</summary>
        private static string[] Visits(DaemonProcess daemon) =>
            Rows(daemon, "tick").SelectMany(VisitsOf).Select(visit => string.Join(' ', visit.Where(cell => cell.Key.StartsWith("shadow_")))).ToArray();

        private static IEnumerable<Cells> VisitsOf(List<Cells> row) => row.Where(cells => cells["shadow_arm"] != "");

        private static string[] Switches(DaemonProcess daemon) =>
            Rows(daemon, "switch").Select(row => string.Join(' ', row[0].Where(cell => Regex.IsMatch(cell.Key, "^(arm|reason|switch_.*)$")))).ToArray();

        /// <summary>The rows of one kind in the audit log. Each has one line per item of its longest list. No cell contains a comma.</summary>
        private static List<List<Cells>> Rows(DaemonProcess daemon, string kind)
        {
            string path = Path.Combine(daemon.Folder, "decisions.csv");
            Run("audit", "export", "--daemon", daemon.Address, "--out", path);
            string[] lines = File.ReadAllLines(path);
            string[] header = lines[0].Split(',');
            var rows = new List<List<Cells>>();
            foreach (string line in lines.Skip(1))
            {
                var cells = new Cells(header.Zip(line.Split(','), KeyValuePair.Create));
                if (cells["item"] == "0")
                    rows.Add(new List<Cells>());
                rows[rows.Count - 1].Add(cells);
            }
            return rows.Where(row => row[0]["kind"] == kind).ToList();
        }

        private static void Run(params string[] arguments)
        {
            using Process process = Process.Start(new ProcessStartInfo(DaemonProcess.Program("sweepstake"), arguments) { RedirectStandardOutput = true });
            string output = process!.StandardOutput.ReadToEnd();
            process.WaitForExit();
            Assert.That(process.ExitCode, Is.EqualTo(0), output);
        }
    }
}
