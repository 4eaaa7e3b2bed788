#nullable enable
using System;
using System.Threading;
using NUnit.Framework;
using Sweepstake.LowLevel;

namespace Sweepstake.Tests
{
    /// <summary>Tests what a job does: it calls the C ABI with pointers only, on threads other than the creator of the objects.</summary>
    public sealed unsafe class JobsTest
    {
        private const int Threads = 4;
        private const int Rounds = 50;

        [Test]
        public void QueriesOfSeveralThreadsGiveWhatOneThreadGives()
        {
            using var scene = Oracle.CrowdedScene("brownian");
            using var proxies = new ProxySet();
            var handles = new ProxyHandle[scene.Boxes.Length];
            proxies.Add(scene.Boxes, ReadOnlySpan<ProxyOptions>.Empty, handles);
            proxies.PrepareQueries();
            Aabb[] boxes = scene.Boxes.Slice(0, 50).ToArray();
            var ends = new ulong[boxes.Length];
            var found = new ProxyHandle[4096];
            Assert.That(proxies.QueryBoxes(boxes, ProxyFilter.All, found, ends), Is.True);
            int wrong = 0;
            OnThreads(_ => Interlocked.Add(ref wrong, CountWrong(proxies.Pointer, boxes, found, ends)));
            Assert.That(wrong, Is.EqualTo(0));
        }

        [Test]
        public void AFrameMayBePlayedByAnotherThreadEachTime()
        {
            using var scene = Oracle.CrowdedScene("hurricane");
            using var session = new BroadPhaseSession();
            for (int frame = 0; frame < Rounds; ++frame)
            {
                scene.Step();
                ulong pairCount = 0;
                Aabb[] boxes = scene.Boxes.ToArray();
                var job = new Thread(() => pairCount = PlayFrame(session.Pointer, boxes));
                job.Start();
                job.Join();
                Assert.That(pairCount, Is.EqualTo((ulong)Oracle.Pairs(boxes).Count));
            }
            Assert.That(session.LastSample.FrameIndex, Is.EqualTo(Rounds - 1));
        }

        private static ulong PlayFrame(IntPtr session, Aabb[] boxes)
        {
            OverlapPair* pairs;
            ulong count;
            fixed (Aabb* start = boxes)
            {
                NativeMethods.swp_session_begin_frame(session);
                NativeMethods.swp_session_find_pairs(session, start, (uint)boxes.Length);
                NativeMethods.swp_session_pairs(session, &pairs, &count);
                NativeMethods.swp_session_end_frame(session, 1, 0);
            }
            return count;
        }

        private static int CountWrong(IntPtr proxies, Aabb[] boxes, ProxyHandle[] expected, ulong[] expectedEnds)
        {
            int wrong = 0;
            var found = new ProxyHandle[expected.Length];
            var ends = new ulong[expectedEnds.Length];
            fixed (Aabb* box = boxes)
            fixed (ProxyHandle* handle = found)
            fixed (ulong* end = ends)
            {
                for (int round = 0; round < Rounds; ++round)
                {
                    ResultCode result = NativeMethods.swp_proxies_query_boxes(
                        proxies, box, (uint)boxes.Length, null, handle, (ulong)found.Length, end);
                    int count = (int)expectedEnds[expectedEnds.Length - 1];
                    bool isSame = result == ResultCode.Ok && ends.AsSpan().SequenceEqual(expectedEnds) &&
                        found.AsSpan(0, count).SequenceEqual(expected.AsSpan(0, count));
                    wrong += isSame ? 0 : 1;
                }
            }
            return wrong;
        }

        private static void OnThreads(Action<int> job)
        {
            var threads = new Thread[Threads];
            for (int index = 0; index < Threads; ++index)
            {
                int number = index;
                threads[index] = new Thread(() => job(number));
                threads[index].Start();
            }
            foreach (Thread thread in threads)
                thread.Join();
        }
    }
}
