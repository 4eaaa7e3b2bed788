#nullable enable
using System;
using NUnit.Framework;

namespace Sweepstake.Tests
{
    public sealed class ProxiesTest
    {
        private static readonly Aabb Unit = new Aabb(0, 0, 0, 1, 1, 1);
        private static readonly Aabb Away = new Aabb(5, 0, 0, 6, 1, 1);

        [Test]
        public void PairsBeginAndEndWithAWorldAndWithASession([Values] bool withSession)
        {
            using var world = new BroadPhaseWorld("SAP");
            using var session = new BroadPhaseSession();
            using ProxySet proxies = WithEvents();
            ProxyHandle a = proxies.Add(Unit, Passing(1));
            ProxyHandle b = proxies.Add(Unit, Passing(2));
            Search(proxies, world, session, withSession);
            Assert.That(proxies.Added.Length, Is.EqualTo(1));
            Assert.That(proxies.Added[0].A, Is.EqualTo(a));
            Assert.That(proxies.Added[0].B, Is.EqualTo(b));
            Assert.That(proxies.Pairs.ToArray(), Is.EqualTo(new[] { new OverlapPair(a.Id, b.Id) }));

            Search(proxies, world, session, withSession);
            Assert.That(proxies.Added.Length + proxies.Removed.Length, Is.EqualTo(0));

            proxies.SetBoxes(new[] { b }, new[] { Away });
            Search(proxies, world, session, withSession);
            Assert.That(proxies.Removed.Length, Is.EqualTo(1));
            Assert.That(proxies.Pairs.Length, Is.EqualTo(0));
        }

        [Test]
        public void AProxyWithoutOptionsHasTheFilterThatPassesAll()
        {
            using var proxies = new ProxySet();
            var added = new ProxyHandle[1];
            proxies.Add(new[] { Unit }, ReadOnlySpan<ProxyOptions>.Empty, added);
            proxies.Get(added[0], out ProxyOptions options);
            Assert.That(options.Filter, Is.EqualTo(ProxyFilter.All));
        }

        [Test]
        public void FiltersDecideAndStaticProxiesIgnoreOneAnother()
        {
            using var world = new BroadPhaseWorld("DBVT");
            using ProxySet proxies = WithEvents();
            ProxyHandle bullet = proxies.Add(Unit, new ProxyOptions(new ProxyFilter(1, 2)));
            ProxyHandle other = proxies.Add(Unit, new ProxyOptions(new ProxyFilter(1, 2)));
            ProxyHandle wall = proxies.Add(Unit, new ProxyOptions(new ProxyFilter(2, 1), ProxyFlags.Static));
            ProxyHandle floor = proxies.Add(Unit, new ProxyOptions(new ProxyFilter(2, 3), ProxyFlags.Static));
            Assert.That(wall.WasAddedStatic, Is.True);
            Assert.That(proxies.MovingCount, Is.EqualTo(2));
            Assert.That(proxies.StaticCount, Is.EqualTo(2));
            proxies.FindPairs(world);
            Assert.That(proxies.Pairs.Length, Is.EqualTo(4), "each bullet overlaps the wall and the floor");
            proxies.SetFilter(other, new ProxyFilter(0, 0));
            proxies.FindPairs(world);
            Assert.That(proxies.Pairs.Length, Is.EqualTo(2));
            proxies.SetStatic(bullet, true);
            proxies.FindPairs(world);
            Assert.That(proxies.Pairs.Length, Is.EqualTo(0));
            proxies.Remove(floor);
            Assert.That(Assert.Throws<SweepstakeException>(() => proxies.Remove(floor))!.Code, Is.EqualTo(ResultCode.NotFound));
            Assert.That(proxies.HandleOf(wall.Id), Is.EqualTo(wall));
        }

        [Test]
        public void AProxyGivesBackItsBoxItsUserValueAndItsFlags()
        {
            using var proxies = new ProxySet();
            ProxyHandle proxy = proxies.Add(Away, new ProxyOptions(new ProxyFilter(4, 8), user: 77));
            Assert.That(proxies.Get(proxy, out ProxyOptions options).MaxX, Is.EqualTo(6));
            Assert.That(options.Filter.Mask, Is.EqualTo(8));
            Assert.That(options.User, Is.EqualTo(77));
            proxies.SetUser(proxy, 78);
            proxies.SetSleeping(proxy, true);
            proxies.ShiftOrigin(5, 0, 0);
            Assert.That(proxies.Get(proxy, out options).MinX, Is.EqualTo(0));
            Assert.That(options.User, Is.EqualTo(78));
            Assert.That(options.Flags, Is.EqualTo(ProxyFlags.Sleeping));
            byte[] saved = proxies.Save();
            proxies.Remove(proxy);
            proxies.Restore(saved);
            Assert.That(proxies.Get(proxy, out _).MinX, Is.EqualTo(0));
        }

        [Test]
        public void QueriesFindWhatTheirFilterLetsThrough()
        {
            using var proxies = new ProxySet();
            var handles = new ProxyHandle[10];
            for (int k = 0; k < handles.Length; ++k)
                handles[k] = proxies.Add(Aabb.Around(3 * k, 0, 0, 1, 1, 1), new ProxyOptions(new ProxyFilter(k % 2 == 0 ? 1u : 2u, uint.MaxValue)));
            proxies.PrepareQueries();
            var found = new ProxyHandle[16];
            var ends = new ulong[2];
            var boxes = new[] { Aabb.Around(0, 0, 0, 4, 1, 1), Aabb.Around(9, 0, 0, 0.5F, 1, 1) };
            Assert.That(proxies.QueryBoxes(boxes, ProxyFilter.All, found, ends), Is.True);
            Assert.That(ends, Is.EqualTo(new ulong[] { 2, 3 }));
            Assert.That(found[0], Is.EqualTo(handles[0]));
            Assert.That(found[2], Is.EqualTo(handles[3]));
            Assert.That(proxies.QueryBoxes(boxes, ProxyFilter.All, Span<ProxyHandle>.Empty, ends), Is.False);
            Assert.That(ends[1], Is.EqualTo(3));

            var sphere = new[] { new SphereQuery { CenterX = 6, Radius = 2.5F } };
            Assert.That(proxies.QuerySpheres(sphere, new ProxyFilter(uint.MaxValue, 2), found, ends.AsSpan(0, 1)), Is.True);
            Assert.That(ends[0], Is.EqualTo(2), "the proxies with odd index at 3 and 9");

            var ray = new RayQuery { OriginX = -10, DirectionX = 1, MaxDistance = 100 };
            var hits = new QueryHit[16];
            proxies.CastRays(new[] { ray }, new ProxyFilter(uint.MaxValue, 2), hits.AsSpan(0, 1));
            Assert.That(hits[0].Proxy, Is.EqualTo(handles[1]));
            Assert.That(hits[0].Distance, Is.EqualTo(12).Within(1e-4));
            Assert.That(proxies.CastRay(ray, ProxyFilter.All, hits, out int count), Is.True);
            Assert.That(count, Is.EqualTo(10));
            Assert.That(hits[9].Proxy, Is.EqualTo(handles[9]));

            var sweep = new BoxSweepQuery { Box = Aabb.Around(0, 10, 0, 1, 1, 1), TranslationY = -16 };
            proxies.SweepBoxes(new[] { sweep }, ProxyFilter.All, hits.AsSpan(0, 1));
            Assert.That(hits[0].Proxy, Is.EqualTo(handles[0]));
            Assert.That(hits[0].Distance, Is.EqualTo(0.5F).Within(1e-4));
        }

        [Test]
        public void ASearchWithTooManyPairsThrowsAndTheNextOneHasAllEvents()
        {
            using var world = new BroadPhaseWorld("DBVT");
            ProxySetOptions options = ProxySetOptions.Default;
            options.HasPairEvents = true;
            options.MaxPairs = 5;
            using var proxies = new ProxySet(options);
            ProxyHandle last = default;
            for (int i = 0; i < 4; i++)
            {
                last = proxies.Add(Unit, Passing(0));
                proxies.SetSleeping(last, true);
            }
            var refused = Assert.Throws<SweepstakeException>(() => proxies.FindPairs(world));
            Assert.That(refused!.Code, Is.EqualTo(ResultCode.ResourceExhausted));
            Assert.That(proxies.Added.Length, Is.EqualTo(0));
            proxies.Remove(last);
            proxies.FindPairs(world);
            Assert.That(proxies.Added.Length, Is.EqualTo(3));
        }

        [Test]
        public void ABoxOfDoublesIsRoundedOutward()
        {
            Aabb box = Aabb.RoundOutward(new[] { 0.1, 0.1, 0.1 }, new[] { 0.1, 0.2, 0.3 });
            Assert.That((double)box.MinX, Is.LessThanOrEqualTo(0.1));
            Assert.That((double)box.MaxX, Is.GreaterThanOrEqualTo(0.1));
            Assert.That(box.MinX, Is.LessThan(box.MaxX));
        }

        private static ProxySet WithEvents()
        {
            ProxySetOptions options = ProxySetOptions.Default;
            options.HasPairEvents = true;
            return new ProxySet(options);
        }

        private static ProxyOptions Passing(ulong user) => new ProxyOptions(ProxyFilter.All, ProxyFlags.None, user);

        private static void Search(ProxySet proxies, BroadPhaseWorld world, BroadPhaseSession session, bool withSession)
        {
            if (!withSession)
            {
                proxies.FindPairs(world);
                return;
            }
            session.BeginFrame();
            proxies.FindPairs(session);
            session.EndFrame(1);
        }
    }
}
