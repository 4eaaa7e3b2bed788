using System;
using NUnit.Framework;

namespace Sweepstake.Tests
{
    /// <summary>Tests that a frame allocates nothing on the managed heap, also with a decider, a connection or a CSV file.</summary>
    public sealed class FrameAllocationTest
    {
        private const ulong FrameNs = 16_666_667;

        [Test]
        public void AFrameOfASessionAllocatesNothing()
        {
            using var session = new BroadPhaseSession(new SessionOptions { Arms = "SAP,DBVT,KDTree", SettlingNs = 1 });
            using var decider = new EmbeddedDecider(session);
            using var scene = Oracle.CrowdedScene("hurricane");
            using var csv = new FrameCsvWriter(System.IO.Path.GetTempFileName(), session);
            ulong pairs = 0;
            int frame = 0;
            Assert.That(AllocatedByFrames(() =>
            {
                scene.Step();
                session.BeginFrame();
                session.FindPairs(scene.Boxes);
                foreach (OverlapPair pair in session.Pairs)
                    pairs += pair.A < pair.B ? 1u : 0u;
                session.EndFrame(FrameNs);
                csv.Write(session.LastSample);
                session.SelectArm(frame++ / 10 % 3);
                pairs += (ulong)session.ActiveArm + session.SwitchEpoch + (ulong)session.Mode + (ulong)session.Verdict.Kind;
                pairs += session.LastDecision.DecisionId + session.LastOutcome.CommandId + session.DroppedSampleCount + SteadyClock.NowNs % 2;
            }), Is.EqualTo(0));
            Assert.That(pairs, Is.GreaterThan(0));
        }

        [Test]
        public void AFrameOfProxiesAndQueriesAllocatesNothing()
        {
            using var world = new BroadPhaseWorld("SAP");
            using var scene = Oracle.CrowdedScene("brownian");
            ProxySetOptions options = ProxySetOptions.Default;
            options.HasPairEvents = true;
            using var proxies = new ProxySet(options);
            var handles = new ProxyHandle[scene.Boxes.Length];
            proxies.Add(scene.Boxes, ReadOnlySpan<ProxyOptions>.Empty, handles);
            var rays = new[] { new RayQuery { DirectionX = 1, MaxDistance = 50 } };
            var hits = new QueryHit[1];
            var found = new ProxyHandle[512];
            var ends = new ulong[4];
            int seen = 0;
            Assert.That(AllocatedByFrames(() =>
            {
                scene.Step();
                proxies.SetBoxes(handles, scene.Boxes);
                proxies.FindPairs(world);
                seen += proxies.Pairs.Length + proxies.Added.Length + proxies.Removed.Length;
                proxies.PrepareQueries();
                proxies.CastRays(rays, ProxyFilter.All, hits);
                proxies.QueryBoxes(scene.Boxes.Slice(0, 4), ProxyFilter.All, found, ends);
                seen += (int)world.Counters.PairCount;
            }), Is.EqualTo(0));
            Assert.That(seen, Is.GreaterThan(0));
        }

        private static long AllocatedByFrames(Action frame) => Eventually.AllocatedBy(() =>
        {
            for (int index = 0; index < 600; ++index)
                frame();
        });
    }
}
