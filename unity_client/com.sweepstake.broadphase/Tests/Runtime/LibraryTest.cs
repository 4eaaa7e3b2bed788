#nullable enable
using System;
using System.Diagnostics;
using NUnit.Framework;

namespace Sweepstake.Tests
{
    public sealed class LibraryTest
    {
        [Test]
        public void TheLibraryIsThereAndEachStructFits()
        {
            Assert.That(SweepstakeLibrary.FindProblem(), Is.Null);
            var problems = new LowLevel.LayoutProblems();
            LowLevel.NativeLayouts.Check(problems);
            Assert.That(problems.ToString(), Is.Empty);
            Assert.That(SweepstakeLibrary.Version, Is.GreaterThan(new Version(0, 0, 0)));
        }

        [Test]
        public void APlatformThatCannotHaveALibraryIsToldWithTheRemedy()
        {
            Assert.That(SweepstakeLibrary.FindPlatformProblem(true, 8), Is.Null);
            Assert.That(SweepstakeLibrary.FindPlatformProblem(false, 8)!.Message, Does.Contain("does not support this platform").And.Contain("Use Unity's own"));
            Assert.That(
                SweepstakeLibrary.FindPlatformProblem(true, 4)!.Message,
                Is.EqualTo("Sweepstake needs a 64-bit process. Choose a 64-bit architecture in the player's settings."));
        }

        [Test]
        public void AMisplacedFieldAndAnotherSizeAreFound()
        {
            var problems = new LowLevel.LayoutProblems();
            problems.Field("FrameSample.Arm", 44, 48);
            problems.Size("FrameSample", 7, 60, 64, false);
            problems.Size("Belief", 13, 16, 16, false);
            Assert.That(problems.ToString(), Does.Contain("FrameSample.Arm is at offset 44 in C# and at 48"));
            Assert.That(problems.ToString(), Does.Contain("FrameSample has 60 bytes in C#"));
            Assert.That(problems.ToString(), Does.Not.Contain("Belief"));
        }

        [Test]
        public void ShutdownEndsEverythingIsBoundedAndMayBeCalledAgain()
        {
            var world = new BroadPhaseWorld("SAP");
            var session = new BroadPhaseSession();
            var decider = new EmbeddedDecider(session);
            var proxies = new ProxySet();
            var scene = new MotionScene("brownian");
            Assert.That(SweepstakeLibrary.LiveCount(), Is.GreaterThanOrEqualTo(4));
            Assert.That(SweepstakeLibrary.Shutdown(60_000), Is.True);
            Assert.That(SweepstakeLibrary.Shutdown(0), Is.True);
            Assert.That(SweepstakeLibrary.LiveCount(), Is.EqualTo(0));
            Assert.That(SessionWork.RunningCount, Is.EqualTo(0));
            Assert.That(Assert.Throws<SweepstakeException>(() => scene.Step())!.Code, Is.EqualTo(ResultCode.FailedPrecondition));
            Assert.Throws<SweepstakeException>(() => session.BeginFrame());
            Assert.That(new[] { world.IsDisposed, session.IsDisposed, proxies.IsDisposed, scene.IsDisposed }, Is.All.True);
            foreach (IDisposable left in new IDisposable[] { decider, world, session, proxies, scene })
                left.Dispose();
            using var after = new MotionScene("brownian");
            Assert.That(after.IsDisposed, Is.False);
            Assert.That(SweepstakeLibrary.LiveCount(ObjectKind.Scene), Is.EqualTo(1), "objects created after Shutdown work");
        }

        [Test]
        public void TheClockIsSteadyAndInNanoseconds()
        {
            ulong first = SteadyClock.NowNs;
            long ticks = Stopwatch.GetTimestamp();
            ulong second = SteadyClock.NowNs;
            Assert.That(second, Is.GreaterThanOrEqualTo(first));
            Assert.That(ticks / (double)Stopwatch.Frequency, Is.InRange(first / 1e9 - 0.001, second / 1e9 + 0.001));
        }
    }
}
