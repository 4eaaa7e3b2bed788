#nullable enable
using System;
using System.Globalization;
using System.IO;
using System.Threading;
using NUnit.Framework;

namespace Sweepstake.Tests
{
    public sealed class FrameCsvWriterTest
    {
        [Test]
        public void EachFrameIsARowWithVersionsAndSeedInTheInvariantCulture()
        {
            CultureInfo culture = Thread.CurrentThread.CurrentCulture;
            string path = Path.GetTempFileName();
            try
            {
                Thread.CurrentThread.CurrentCulture = WithOtherSigns();
                using var session = new BroadPhaseSession(new SessionOptions { Arms = "SAP" });
                using var scene = Oracle.CrowdedScene("brownian");
                using (var csv = new FrameCsvWriter(path, session, "a \"quoted\", scene", 7, vSyncCount: 1))
                {
                    for (int frame = 0; frame < 1000; ++frame)
                    {
                        session.BeginFrame();
                        session.FindPairs(scene.Boxes);
                        session.EndFrame(1_234_567);
                        csv.Write(session.LastSample);
                    }
                    Assert.That(csv.DroppedCount, Is.EqualTo(0));
                    Assert.That(csv.Stop(60_000), Is.True);
                }
                string text = File.ReadAllText(path);
                string[] lines = text.Split(new[] { "\r\n" }, StringSplitOptions.None);
                Assert.That(lines.Length, Is.EqualTo(1002), "a header, the rows, and nothing after the last line break");
                Assert.That(lines[0], Does.StartWith("frame,arm,switch_epoch,frame_time_ns,").And.EndsWith("csv_version,scene,seed,library_version,vsync_count"));
                Assert.That(lines[2], Does.StartWith("1,SAP,0,1234567,"));
                Assert.That(lines[2], Does.EndWith($",2,\"a \"\"quoted\"\", scene\",7,{SweepstakeLibrary.Version},1"));
            }
            finally
            {
                Thread.CurrentThread.CurrentCulture = culture;
                File.Delete(path);
            }
        }

        private static CultureInfo WithOtherSigns()
        {
            var culture = (CultureInfo)CultureInfo.InvariantCulture.Clone();
            culture.NumberFormat.NumberDecimalSeparator = ",";
            culture.NumberFormat.NegativeSign = "~";
            return culture;
        }

        [Test]
        public void AFullRingDropsAndCounts()
        {
            string path = Path.GetTempFileName();
            using var session = new BroadPhaseSession();
            using (var csv = new FrameCsvWriter(path, session, capacity: 4))
            {
                for (int frame = 0; frame < 100_000; ++frame)
                    csv.Write(default);
                Assert.That(csv.DroppedCount, Is.GreaterThan(0));
                Assert.That(csv.Failure, Is.Null);
            }
            File.Delete(path);
        }
    }
}
