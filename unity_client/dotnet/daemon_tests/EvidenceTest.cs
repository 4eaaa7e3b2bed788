using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Globalization;
using System.IO;
using System.Linq;
using System.Threading.Tasks;
using NUnit.Framework;
using Sweepstake.GrpcNet;
using Sweepstake.Protocol.V1;

namespace Sweepstake.Tests
{
    /// <summary>The same run over both transports is the same evidence on the daemon's disk.</summary>
    public sealed class EvidenceTest
    {
        // The last of these members of a run in the audit log are those of its window.
        private const int WindowMembers = 11;
        private static readonly int[] Summed = { 0, 1, 2, 3, 7, 8, 9 };
        private static readonly TimeSpan AfterTheLastFrame = TimeSpan.FromMilliseconds(500);

        [Test]
        public async Task ARunOverCppAndOverCSharpIsTheSameAcknowledgedEvidence()
        {
            using var first = new DaemonProcess();
            using var second = new DaemonProcess();
            using var tap = new Http2Tap(first.Address, AfterTheLastFrame);
            Run(
                "run", "--scene", "hurricane", "--objects", "2000", "--mode", "manual", "--arm", "SAP", "--shadow", "off", "--duration", "2s",
                "--time-scale", "50", "--daemon", tap.Address);
            await tap.Passing;
            StreamTelemetryRequest[] sent = tap.Messages.Select(message => StreamTelemetryRequest.Parser.ParseFrom(message)).ToArray();
            Assert.That(sent.First().Hello, Is.Not.Null);
            Assert.That(sent.Last().Goodbye, Is.Not.Null);
            ulong last = sent.Max(message => message.Sequence);
            Assert.That(await Replay(tap.Messages, second.Address, last), Is.EqualTo(last), "all of it is acknowledged");

            double[] overCpp = Evidence(first);
            double[] overCSharp = Evidence(second);
            Assert.That(overCSharp, Is.EqualTo(overCpp));
            double frames = sent.Where(message => message.FrameBatch != null).Sum(message => message.FrameBatch.FrameTimeNs.Count);
            Assert.That(overCpp[0], Is.GreaterThan(0).And.LessThanOrEqualTo(frames), "those that settle are not learnt from");
        }

        /// <summary>Sends these messages as they are. Returns the last sequence that the daemon acknowledged.</summary>
        private static async Task<ulong> Replay(List<byte[]> messages, string address, ulong last)
        {
            using var transport = new GrpcTelemetryTransport(new DaemonEndpoint { Address = address, Handler = Game.Sockets });
            using ITelemetryStream stream = transport.Open();
            ulong acknowledged = 0;
            await stream.WriteAsync(messages[0]);
            Assert.That(Parsed(await stream.ReadAsync()).Welcome, Is.Not.Null);
            Task reading = Task.Run(async () =>
            {
                while (acknowledged < last && await stream.ReadAsync() is byte[] response)
                    acknowledged = Math.Max(acknowledged, Parsed(response).Acknowledgement?.Sequence ?? 0);
            });
            for (int index = 1; index < messages.Count - 1; ++index)
                await stream.WriteAsync(messages[index]);
            await Task.WhenAny(reading, Task.Delay(TimeSpan.FromSeconds(30)));
            await Task.Delay(AfterTheLastFrame);
            await stream.WriteAsync(messages[messages.Count - 1]);
            await stream.FinishAsync();
            return acknowledged;
        }

        private static StreamTelemetryResponse Parsed(byte[] response) => StreamTelemetryResponse.Parser.ParseFrom(response);

        /// <summary>What all windows of the audit log amount to: frames, times, checks and pairs do not depend on where a window ended.</summary>
        private static double[] Evidence(DaemonProcess daemon)
        {
            string path = Path.Combine(daemon.Folder, "decisions.csv");
            Run("audit", "export", "--daemon", daemon.Address, "--out", path);
            string[] rows = File.ReadAllLines(path);
            int kind = Array.IndexOf(rows[0].Split(','), "kind");
            var sums = new double[Summed.Length];
            foreach (string[] cells in rows.Select(Cells).Where(cells => cells[kind] == "tick"))
            {
                string[] members = cells[kind + 3].Split(' ')[1].Split(':');
                for (int index = 0; index < Summed.Length; ++index)
                    sums[index] += double.Parse(members[members.Length - WindowMembers + Summed[index]], CultureInfo.InvariantCulture);
            }
            return sums;
        }

        /// <summary>A tick has no commas within its first cells.</summary>
        private static string[] Cells(string row) => row.Split(',');

        private static void Run(params string[] arguments)
        {
            using Process process = Process.Start(new ProcessStartInfo(DaemonProcess.Program("sweepstake"), arguments) { RedirectStandardOutput = true });
            string output = process!.StandardOutput.ReadToEnd();
            process.WaitForExit();
            Assert.That(process.ExitCode, Is.EqualTo(0), output);
        }
    }
}
