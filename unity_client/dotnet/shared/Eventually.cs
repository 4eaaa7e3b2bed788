#nullable disable
using System;
using System.Diagnostics;
using System.Threading;
using NUnit.Framework;

namespace Sweepstake.Tests
{
    /// <summary>Waits until other threads and processes have done something, however busy the machine is.</summary>
    internal static class Eventually
    {
        internal static readonly TimeSpan Patience = TimeSpan.FromMinutes(2);
        // The number of threads that may be left, because the runtime starts and ends threads of its own.
        private const int SpareThreads = 4;
        private const int AllocationRounds = 5;
        private const int TimedRounds = 10;

        /// <summary>Waits until the condition is true. It allocates nothing, so it can be used in tests that count allocations.</summary>
        /// <param name="between">Called between the checks; null for nothing.</param>
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

        /// <summary>Repeats Shutdown until everything has ended. Each call waits for a limited time, and the next one continues.</summary>
        internal static void ShutsDown() => Is(() => SweepstakeLibrary.Shutdown(), () => "shut down");

        /// <summary>
        /// Checks that at least one of several rounds takes less than `bound`, because a busy machine may delay single rounds.
        /// </summary>
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

        /// <summary>
        /// Returns the number of bytes that `work` allocates on this thread, apart from its first call. It is the minimum of several
        /// rounds, to exclude single events.
        /// </summary>
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
