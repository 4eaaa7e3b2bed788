#nullable disable
using System;
using System.IO;
using System.Reflection;
using System.Runtime.CompilerServices;
using System.Runtime.Loader;
using NUnit.Framework;

namespace Sweepstake.Tests
{
    /// <summary>
    /// Simulates a domain reload, which Unity does after each change of a script: it loads the managed code again into the same process.
    /// Statics are reset, nothing disposes of the objects of the old code, and the native library stays.
    /// </summary>
    public sealed class DomainReloadTest
    {
        // Loading the code again is slow, so each domain begins and ends play ten times: 1,000 times in all.
        private const int Domains = 100;
        private const int EndsOfEach = 10;
        private const int PatienceMs = 120_000;
        private static BroadPhaseSession played;
        private static EmbeddedDecider decider;

        [Test]
        public void AThousandReloadsLeaveNoNativeObjectAndNoThread()
        {
            Eventually.ShutsDown();
            int threadsBefore = Eventually.ThreadCount();
            for (int domain = 0; domain < Domains; ++domain)
            {
                PlayInANewDomain();
                Assert.That(SweepstakeLibrary.LiveCount(), Is.GreaterThan(0), "the last end of each domain leaves objects behind");
            }
            Eventually.ShutsDown();
            Assert.That(SweepstakeLibrary.LiveCount(), Is.EqualTo(0));
            Collect();
            Eventually.HasAtMostThreads(threadsBefore);
        }

        /// <summary>
        /// Runs in its own domain: begins and ends play ten times. The last time it calls no Shutdown, as after an error. The next domain
        /// first ends the objects that are left.
        /// </summary>
        public static void PlayAndEnd()
        {
            if (!SweepstakeLibrary.Shutdown(PatienceMs) || SweepstakeLibrary.LiveCount() != 0)
                throw new InvalidOperationException("Shutdown did not end what a former domain left.");
            for (int end = 0; end < EndsOfEach; ++end)
            {
                Play();
                if (end == EndsOfEach - 1)
                    return;
                if (!SweepstakeLibrary.Shutdown(PatienceMs) || SweepstakeLibrary.LiveCount() != 0 || SessionWork.RunningCount != 0)
                    throw new InvalidOperationException("Shutdown did not end everything.");
            }
        }

        private static void Play()
        {
            var scene = new MotionScene("brownian");
            played = new BroadPhaseSession(new SessionOptions { Arms = "SAP,DBVT" });
            decider = new EmbeddedDecider(played);
            for (int frame = 0; frame < 3; ++frame)
            {
                scene.Step();
                played.BeginFrame();
                played.FindPairs(scene.Boxes);
                played.EndFrame(1_000_000);
            }
        }

        [MethodImpl(MethodImplOptions.NoInlining)]
        private static void PlayInANewDomain()
        {
            var domain = new Domain();
            Assembly tests = domain.LoadFromAssemblyPath(typeof(DomainReloadTest).Assembly.Location);
            tests.GetType(typeof(DomainReloadTest).FullName)!.GetMethod(nameof(PlayAndEnd))!.Invoke(null, null);
            domain.Unload();
        }

        private static void Collect()
        {
            for (int pass = 0; pass < 3; ++pass)
            {
                GC.Collect();
                GC.WaitForPendingFinalizers();
            }
        }

        private sealed class Domain : AssemblyLoadContext
        {
            internal Domain()
                : base(isCollectible: true)
            {
            }

            protected override Assembly Load(AssemblyName name)
            {
                string path = Path.Combine(AppContext.BaseDirectory, name.Name + ".dll");
                return name.Name == "Sweepstake.Core" ? LoadFromAssemblyPath(path) : null;
            }
        }
    }
}
