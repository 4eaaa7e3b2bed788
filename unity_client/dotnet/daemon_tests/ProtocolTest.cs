using System;
using System.Diagnostics;
using System.Linq;
using System.Threading.Tasks;
using NUnit.Framework;
using Sweepstake.Protocol.V1;

namespace Sweepstake.Tests
{
    /// <summary>Tests how a connection behaves if the daemon sends exactly what the test chooses.</summary>
    public sealed class ProtocolTest
    {
        [Test]
        public void AHelloSaysWhoTheGameIs()
        {
            var stream = new ScriptedStream().Saying(new StreamTelemetryResponse { Welcome = ScriptedDaemon.Welcome() });
            using var game = new Game(new ScriptedDaemon(() => stream), options =>
            {
                options.Build = "42";
                options.MachineClass = "desk";
                options.Seed = 7;
                options.AllowsOperatorOrders = true;
                options.DecisionIntervalNs = 500_000_000;
                options.CooldownNs = 0;
                options.Weights = new Sweepstake.RewardWeights(0.25, 0.25, 0.5, 0);
            });
            game.PlayUntilOnline();
            Hello hello = stream.Sent(request => request.Hello).Single();
            Assert.That(hello.Project, Is.EqualTo("unity"));
            Assert.That(hello.Build, Is.EqualTo("42"));
            Assert.That(hello.MachineClass, Is.EqualTo("desk"));
            Assert.That(hello.Seed, Is.EqualTo(7));
            Assert.That(hello.DecisionIntervalNs, Is.EqualTo(500_000_000));
            Assert.That((hello.HasCooldownNs, hello.CooldownNs), Is.EqualTo((true, 0ul)));
            Assert.That(hello.HasSettlingNs, Is.False, "the daemon's settling time");
            Assert.That((hello.Weights.Detection, hello.Weights.Memory), Is.EqualTo((0.25, 0.5)));
            Assert.That(hello.Capabilities, Is.EqualTo(new[] { Capability.OperatorOrders, Capability.StopsTrials }));
            Assert.That(hello.Arms.Select(arm => arm.Name), Is.EqualTo(game.Session.Arms));
            Assert.That(game.Status.DaemonVersion, Is.EqualTo("9.9.9"));
            Assert.That(game.Status.SessionId, Is.EqualTo("scripted"));
        }

        [Test]
        public void ADecisionForABackendThatIsUnknownIsRefused()
        {
            var stream = new ScriptedStream().Saying(
                new StreamTelemetryResponse { Welcome = ScriptedDaemon.Welcome() },
                new StreamTelemetryResponse { SwitchCommand = new Protocol.V1.SwitchCommand { CommandId = 1, Arm = 77, Reason = Protocol.V1.SwitchReason.Policy } });
            using var game = new Game(new ScriptedDaemon(() => stream));
            game.PlayUntil(() => stream.Sent(request => request.SwitchOutcome).Any(), "answered");
            Protocol.V1.SwitchOutcome outcome = stream.Sent(request => request.SwitchOutcome).First();
            Assert.That(outcome.CommandId, Is.EqualTo(1));
            Assert.That(outcome.Executed, Is.False);
            Assert.That(game.Session.SwitchEpoch, Is.EqualTo(0));
        }

        [Test]
        public void ManualIsNeverOverruledByADaemon()
        {
            var stream = new ScriptedStream().Saying(
                new StreamTelemetryResponse { Welcome = ScriptedDaemon.Welcome() },
                new StreamTelemetryResponse { SwitchCommand = new Protocol.V1.SwitchCommand { CommandId = 1, Arm = 2, Reason = Protocol.V1.SwitchReason.Policy } });
            using var game = new Game(new ScriptedDaemon(() => stream), null, session => session.Mode = SessionMode.Manual);
            game.PlayUntil(() => stream.Sent(request => request.SwitchOutcome).Any(), "answered");
            Assert.That(stream.Sent(request => request.SwitchOutcome).First().Executed, Is.False);
            Assert.That(game.Session.ActiveArm, Is.EqualTo(0));
        }

        [Test]
        public void BytesThatAreNoMessageEndTheStreamAndNotTheGame()
        {
            var broken = new ScriptedStream().Saying(new StreamTelemetryResponse { Welcome = ScriptedDaemon.Welcome() });
            broken.Say(new byte[] { 0xff, 0xff, 0xff });
            var good = new ScriptedStream().Saying(new StreamTelemetryResponse { Welcome = ScriptedDaemon.Welcome() });
            int opened = 0;
            using var game = new Game(new ScriptedDaemon(() => opened++ == 0 ? broken : good));
            game.PlayUntil(() => game.Status.Stats.ConnectionCount == 2, "connected again");
            Assert.That(broken.IsDisposed, Is.True);
            Assert.That(game.Connection.Failure, Is.Null);
        }

        [Test]
        public void AWriteThatNeverEndsHoldsNeitherAFrameNorTheEnd()
        {
            Eventually.TakesLessThan(TimeSpan.FromSeconds(2), EndInTheMidstOfAWrite);
        }

        private static TimeSpan EndInTheMidstOfAWrite()
        {
            var stream = new ScriptedStream { Writing = new TaskCompletionSource<bool>().Task };
            stream.Saying(new StreamTelemetryResponse { Welcome = ScriptedDaemon.Welcome() });
            var daemon = new ScriptedDaemon(() => stream);
            using var game = new Game(daemon, null, session => session.QueueFrames = 64);
            game.PlayUntil(() => stream.Requests.Count > 0, "writing");
            game.Play(20_000);
            Assert.That(stream.Requests.Count, Is.EqualTo(1), "the write is under way");
            game.PlayUntil(() => game.Session.DroppedSampleCount > 0, "dropping the oldest");
            var watch = Stopwatch.StartNew();
            game.Connection.Stop(300);
            TimeSpan taken = watch.Elapsed;
            Eventually.Is(() => stream.IsDisposed && daemon.IsDisposed, () => "cancelled during a write");
            Assert.That(game.Status.State, Is.EqualTo(LinkState.Closed));
            return taken;
        }

        [Test]
        public void AnOrderlyEndSendsWhatIsLeftAndSaysGoodbye()
        {
            var stream = new ScriptedStream().Saying(new StreamTelemetryResponse { Welcome = ScriptedDaemon.Welcome() });
            using var game = new Game(new ScriptedDaemon(() => stream));
            game.PlayUntilOnline();
            game.Play(100);
            Task<bool> stopping = Task.Run(() => game.Connection.Stop(120_000));
            while (!stream.IsFinished && !stopping.IsCompleted)
            {
                ulong last = stream.Requests.Select(request => request.Sequence).DefaultIfEmpty().Max();
                stream.Saying(new StreamTelemetryResponse { Acknowledgement = new Acknowledgement { Sequence = last } });
                Task.Delay(5).Wait();
            }
            Assert.That(stream.IsFinished, Is.True, "the writing was ended, not cut off");
            stream.EndWith(default);
            Assert.That(stopping.Result, Is.True);
            Assert.That(stream.Requests.Last().Goodbye, Is.Not.Null);
            Assert.That(stream.Sent(request => request.FrameBatch).Sum(batch => batch.FrameTimeNs.Count), Is.EqualTo((int)game.FrameCount));
        }

        [Test]
        public void ATransportThatCannotBeginSaysWhyAndIsTriedAgain()
        {
            var daemon = new ScriptedDaemon(() => throw new InvalidOperationException("the token is missing"));
            using var game = new Game(daemon);
            game.PlayUntil(() => daemon.OpenCount > 1, "tried again");
            Assert.That(game.Status.LastError, Does.Contain("the token is missing"));
        }

        [Test]
        public void BetweenAttemptsTheLinkSleepsAndAllocatesNothing()
        {
            const int Attempts = 20;
            var daemon = new AbsentDaemon();
            using var game = new Game(daemon, options => options.BackoffMinMs = options.BackoffMaxMs = 100);
            game.PlayUntil(() => daemon.OpenCount > Attempts, "tried again");
            Assert.That(game.Connection.WakeUpCount, Is.LessThanOrEqualTo(2 * daemon.OpenCount), "the delays are 50 ms long on average");
            Assert.That(daemon.AllocatedBetween, Is.EqualTo(0));
        }

        [Test]
        public void AnEndWakesTheLinkDuringALongDelay()
        {
            var daemon = new AbsentDaemon();
            using var game = new Game(daemon, options => options.BackoffMinMs = options.BackoffMaxMs = 3_600_000);
            game.PlayUntil(() => daemon.OpenCount > 0 && game.Status.LastError.Length > 0, "refused");
            Assert.That(game.Connection.Stop(60_000), Is.True);
            Assert.That(game.Connection.WakeUpCount, Is.LessThanOrEqualTo(2));
        }

        [Test]
        public void WhileADaemonDoesNotAnswerTheLinkWakesSeldom()
        {
            var stream = new ScriptedStream();
            using var game = new Game(new ScriptedDaemon(() => stream));
            game.PlayUntil(() => stream.Requests.Count > 0, "greeted");
            long before = game.Connection.WakeUpCount;
            ulong beganNs = SteadyClock.NowNs;
            game.PlayUntil(() => game.Connection.WakeUpCount > before + 2, "awake");
            Assert.That(SteadyClock.NowNs - beganNs, Is.GreaterThan(250_000_000UL), "at least one whole interval lies between three wake-ups");
        }

        [Test]
        public void AStreamThatThrowsHasEndedAndIsTriedAgain([Values("write", "read")] string call)
        {
            var daemon = new ScriptedDaemon(() => new ScriptedStream { Broken = call });
            using var game = new Game(daemon);
            game.PlayUntil(() => daemon.OpenCount > 2, "tried again");
            Assert.That(game.Status.LastError, Does.Contain("a bug of " + call));
            Assert.That(game.Connection.Failure, Is.Null);
        }

        [Test]
        public void OneSessionHasOneDecider()
        {
            var stream = new ScriptedStream();
            using var game = new Game(new ScriptedDaemon(() => stream));
            Assert.Throws<SweepstakeException>(() => new EmbeddedDecider(game.Session));
            game.Connection.Dispose();
            using var decider = new EmbeddedDecider(game.Session);
            game.Play(10);
        }

        [Test]
        public void ShutdownEndsAConnectionThatIsStuck()
        {
            var stream = new ScriptedStream { Writing = new TaskCompletionSource<bool>().Task };
            var game = new Game(new ScriptedDaemon(() => stream));
            game.PlayUntil(() => stream.Requests.Count > 0, "writing");
            Eventually.ShutsDown();
            Assert.That(SweepstakeLibrary.LiveCount(), Is.EqualTo(0));
            Assert.That(SessionWork.RunningCount, Is.EqualTo(0));
            game.Dispose();
        }
    }
}
