#nullable disable
using System;
using System.Diagnostics;
using System.Threading;
using NUnit.Framework;

namespace Sweepstake.Tests
{
    /// <summary>What other threads and processes do in their own time: waited for, however busy the machine is.</summary>
    internal static class Eventually
    {
        internal static readonly TimeSpan Patience = TimeSpan.FromMinutes(2);
        // The runtime's own threads come and go.
        private const int SpareThreads = 4;
        private const int AllocationRounds = 5;
        private const int TimedRounds = 10;

        /// <summary>Waits. It allocates nothing, for those who count that.</summary>
        /// <param name="between">What goes on until it is so; null: nothing.</param>
        internal static void Is(Func<bool> isSo, Func<string> what, Action between = null)
        {
            for (long began = Stopwatch.GetTimestamp(); !isSo(); Thread.Sleep(1))
            {
                if (Stopwatch.GetElapsedTime(began) >= Patience)
                    Assert.Fail("never " + what());
                between?.Invoke();
            }
        }

        internal static void HasAtMostThreads(int count) => Is(() => ThreadCount() <= count + SpareThreads, () => $"{count} threads but {ThreadCount()}");

        internal static int ThreadCount()
        {
            using Process process = Process.GetCurrentProcess();
            return process.Threads.Count;
        }

        /// <summary>As often as it takes: each Shutdown waits for a bounded time, and the next one goes on.</summary>
        internal static void ShutsDown() => Is(() => SweepstakeLibrary.Shutdown(), () => "shut down");

        /// <summary>At least one round in some takes less: a busy machine may hold any of them.</summary>
        internal static void TakesLessThan(TimeSpan bound, Func<TimeSpan> round)
        {
            TimeSpan least = round();
            for (int rounds = 1; rounds < TimedRounds && least >= bound; ++rounds)
            {
                TimeSpan taken = round();
                least = taken < least ? taken : least;
            }
            Assert.That(least, NUnit.Framework.Is.LessThan(bound));
        }

        /// <summary>Bytes of this thread by `work`, after it was done once: the least of some rounds, since what happens once is not of each frame.</summary>
        internal static long AllocatedBy(Action work)
        {
            work();
            long least = long.MaxValue;
            for (int round = 0; round < AllocationRounds && least > 0; ++round)
            {
                long before = GC.GetAllocatedBytesForCurrentThread();
                work();
                least = Math.Min(least, GC.GetAllocatedBytesForCurrentThread() - before);
            }
            return least;
        }
    }
}
