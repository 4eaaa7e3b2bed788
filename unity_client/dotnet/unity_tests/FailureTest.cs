using System;
using System.Diagnostics;
using System.IO;
using System.Linq;
using System.Threading.Tasks;
using NUnit.Framework;
using Sweepstake.Samples;
using Sweepstake.Unity;
using UnityEngine;

namespace Sweepstake.Tests
{
    /// <summary>Tests that failures on other threads are reported once, and that the game continues.</summary>
    public sealed class FailureTest : Stage
    {
        private const string FullDisk = "/dev/full";
        // More frames than fit in the writer's ring and in the pipe that it writes to.
        private const int TooManyFrames = 20_000;

        private SweepstakeManager manager;

        [SetUp]
        public void MakeGame()
        {
            manager = MakeManager();
            manager.gameObject.AddComponent<ScenarioPlayer>().ObjectCount = 10;
        }

        [Test]
        public void ACsvFileThatCannotBeWrittenIsToldWhileTheGamePlays()
        {
            manager.StartCsv(FullDisk);
            FramesUntil(() => manager.Problem.Contains("CSV"), "reported");
            ulong frame = manager.LastSample.FrameIndex;
            Frames(10);
            manager.StopCsv();
            Assert.That(Logged("CSV"), Has.Exactly(1).Items);
            Assert.That((manager.State, manager.LastSample.FrameIndex), Is.EqualTo((SweepstakeState.Embedded, frame + 10)));
        }

        [Test]
        public void ACsvFileThatCannotBeWrittenIsToldAtItsEnd([Values] bool isOfTheManager)
        {
            // The end waits only for a limited time, so the failure may be reported in a later frame.
            FramesUntil(() => IsToldAtTheEnd(isOfTheManager), "reported at the end");
            Assert.That(Logged("CSV"), Has.Exactly(1).Items);
        }

        [Test]
        public void TheProblemOfACsvFileEndsWithTheNextOne()
        {
            manager.StartCsv(FullDisk);
            FramesUntil(() => manager.Problem.Contains("CSV"), "reported");
            string path = Path.GetTempFileName();
            manager.StartCsv(path);
            Frames(1);
            Assert.That(manager.Problem, Is.Empty);
            manager.StopCsv();
            File.Delete(path);
        }

        private bool IsToldAtTheEnd(bool isOfTheManager)
        {
            manager.StartCsv(FullDisk);
            if (isOfTheManager)
                manager.enabled = false;
            else
                manager.StopCsv();
            manager.enabled = true;
            return Logged("CSV").Any();
        }

        [Test]
        public void FramesThatACsvFileLacksAreTold()
        {
            string pipe = Path.Combine(Path.GetTempPath(), "sweepstake_csv_" + Environment.ProcessId);
            Start("mkfifo", pipe).WaitForExit();
            using Process reader = Start("sh", "-c", "exec 3<\"$0\"; read go; exec cat <&3 >/dev/null", pipe);
            manager.StartCsv(pipe);
            Frames(TooManyFrames);
            reader.StandardInput.WriteLine();
            manager.StopCsv();
            reader.WaitForExit();
            File.Delete(pipe);
            Assert.That(Logged("CSV"), Has.Exactly(1).Items);
            Assert.That(Logged("CSV").Single(), Does.Match("lacks \\d+ frames"));
        }

        private static Process Start(string program, params string[] arguments) =>
            Process.Start(new ProcessStartInfo(program, arguments) { RedirectStandardInput = true });

        [Test]
        public void AConnectionWhoseThreadDiesIsTold()
        {
            manager.Connect(new BrokenTransport(), new LinkOptions { Project = "p", Scene = "s" });
            FramesUntil(() => manager.Problem.Contains("a bug of the transport"), "reported");
            Frames(10);
            Assert.That(manager.State, Is.EqualTo(SweepstakeState.Offline));
            Assert.That(Logged("error: "), Has.Exactly(1).Items);
            Set(manager, "mode", SessionMode.Manual);
            Set(manager, "backend", "SAP");
            Player.CallAll("OnValidate");
            Frames(1);
            Assert.That((manager.ActiveBackend, manager.Problem.Contains("a bug of the transport")), Is.EqualTo(("SAP", true)), "decisions have still stopped");
            manager.Disconnect();
            Frames(1);
            Assert.That((manager.State, manager.Problem), Is.EqualTo((SweepstakeState.Embedded, "")), "the game decides itself again");
        }

        [Test]
        public void ADeciderWhoseThreadDiesIsToldUntilItBeginsAnew()
        {
            KillDecider(manager);
            FramesUntil(() => manager.Problem.Contains("the decider has failed"), "reported");
            Assert.That(manager.Problem, Does.Contain(manager.Decider.Failure.Message).And.Contain("enable the manager"));
            ulong frame = manager.LastSample.FrameIndex;
            Frames(10);
            Assert.That((manager.State, manager.LastSample.FrameIndex), Is.EqualTo((SweepstakeState.Embedded, frame + 10)));
            Assert.That(Logged("error: "), Has.Exactly(1).Items);
            manager.enabled = false;
            manager.enabled = true;
            Frames(1);
            Assert.That((manager.Problem, manager.Decider.Failure), Is.EqualTo(("", (Exception)null)));
        }

        private sealed class BrokenTransport : ITelemetryTransport, ITelemetryStream
        {
            private int disposed;

            public StreamEnd End => default;

            public ITelemetryStream Open() => this;
            public Task WriteAsync(ArraySegment<byte> message) => Task.CompletedTask;
            public Task FinishAsync() => Task.CompletedTask;
            public Task<byte[]> ReadAsync() => Task.FromResult<byte[]>(null);

            public void Dispose()
            {
                if (disposed++ == 0)
                    throw new InvalidOperationException("a bug of the transport");
            }
        }
    }
}
