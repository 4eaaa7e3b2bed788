#nullable enable
using System;
using System.Globalization;
using System.IO;
using System.Text;
using System.Threading;

namespace Sweepstake
{
    /// <summary>
    /// Writes samples of frames to a CSV file (RFC 4180, invariant culture) on a thread of its own. The frame thread only copies a sample into
    /// a bounded ring, where a full one drops the new sample and counts it; it never waits and allocates nothing. One thread writes samples.
    /// </summary>
    /// <remarks>
    /// The first columns are those of `sweepstake run --csv`; then what the whole file has in common: the version of the columns, the scene, the
    /// seed, the version of the library and, since it caps the frame rate, how many vertical blanks
    /// of the display a frame waited for when the recording began.
    /// </remarks>
    public sealed class FrameCsvWriter : IDisposable
    {
        /// <summary>Raised by each change of the columns.</summary>
        public const int FormatVersion = 2;
        /// <summary>How long Dispose waits at most, in milliseconds.</summary>
        public const int DisposeTimeoutMs = 2000;
        private const int FlushIntervalMs = 100;
        private const string Header =
            "frame,arm,switch_epoch,frame_time_ns,detection_time_ns,aabb_check_count,pair_count,object_count,native_bytes,flags," +
            "csv_version,scene,seed,library_version,vsync_count\r\n";

        private readonly FrameSample[] ring;
        private readonly string[] arms;
        private readonly string suffix;
        private readonly StreamWriter file;
        private readonly Thread thread;
        private readonly object wakeGate = new object();
        private readonly StringBuilder row = new StringBuilder();
        private long written;
        private long taken;
        private long dropped;
        private bool isEnding;
        private volatile Exception? failure;

        /// <param name="path">A file there is replaced.</param>
        /// <param name="session">Whose frames they are.</param>
        /// <param name="scene">What was played, as the name of the scene; "": not known.</param>
        /// <param name="seed">What it was seeded with; 0: not known.</param>
        /// <param name="capacity">Of the ring: 4,096 frames are 256 KiB.</param>
        /// <param name="vSyncCount">When the recording began; 0: frames wait for no vertical blank; null: not known.</param>
        /// <exception cref="IOException">The file cannot be written.</exception>
        public FrameCsvWriter(string path, BroadPhaseSession session, string scene = "", ulong seed = 0, int capacity = 4096, int? vSyncCount = null)
        {
            if (capacity < 1)
                throw new ArgumentOutOfRangeException(nameof(capacity));
            ring = new FrameSample[capacity];
            arms = new string[session.Arms.Count];
            for (int arm = 0; arm < arms.Length; ++arm)
                arms[arm] = Quoted(session.Arms[arm]);
            suffix = string.Format(
                CultureInfo.InvariantCulture, ",{0},{1},{2},{3},{4}\r\n", FormatVersion, Quoted(scene), seed, SweepstakeLibrary.Version, vSyncCount);
            file = new StreamWriter(path, false, new UTF8Encoding(false));
            file.Write(Header);
            thread = new Thread(WriteRows) { IsBackground = true, Name = "sweepstake csv" };
            thread.Start();
        }

        /// <summary>Samples that found the ring full.</summary>
        public long DroppedCount => Interlocked.Read(ref dropped);

        /// <summary>Why nothing is written any more, such as a full disk; null: all is well.</summary>
        public Exception? Failure => failure;

        /// <summary>Takes the sample of the frame that has just ended.</summary>
        public void Write(in FrameSample sample)
        {
            long index = written;
            if (index - Volatile.Read(ref taken) >= ring.Length)
            {
                Interlocked.Increment(ref dropped);
                return;
            }
            ring[index % ring.Length] = sample;
            Volatile.Write(ref written, index + 1);
        }

        /// <summary>Writes what was taken and closes the file. May be called more than once.</summary>
        /// <returns>Whether that is done; if not, its thread goes on with it, and <see cref="Failure"/> says what became of it.</returns>
        public bool Stop(int timeoutMs)
        {
            lock (wakeGate)
            {
                isEnding = true;
                Monitor.Pulse(wakeGate);
            }
            return thread.Join(Math.Max(0, timeoutMs));
        }

        public void Dispose()
        {
            Stop(DisposeTimeoutMs);
        }

        /// <summary>A field as RFC 4180 has it.</summary>
        internal static string Quoted(string field) =>
            field.IndexOfAny(new[] { ',', '"', '\r', '\n' }) < 0 ? field : "\"" + field.Replace("\"", "\"\"") + "\"";

        private void WriteRows()
        {
            try
            {
                using (file)
                {
                    while (!WaitForEnd())
                        WriteTaken();
                    WriteTaken();
                }
            }
            catch (Exception problem) when (problem is IOException || problem is ObjectDisposedException || problem is UnauthorizedAccessException)
            {
                failure = problem;
            }
        }

        private bool WaitForEnd()
        {
            lock (wakeGate)
            {
                if (!isEnding)
                    Monitor.Wait(wakeGate, FlushIntervalMs);
                return isEnding;
            }
        }

        private void WriteTaken()
        {
            long end = Volatile.Read(ref written);
            for (long index = taken; index < end; ++index)
            {
                WriteRow(ring[index % ring.Length]);
                Volatile.Write(ref taken, index + 1);
            }
            file.Flush();
        }

        private void WriteRow(in FrameSample sample)
        {
            row.Clear();
            row.Append(sample.FrameIndex).Append(',').Append(arms[sample.Arm]).Append(',').Append(sample.SwitchEpoch);
            row.Append(',').Append(sample.FrameTimeNs).Append(',').Append(sample.DetectionTimeNs).Append(',').Append(sample.AabbCheckCount);
            row.Append(',').Append(sample.PairCount).Append(',').Append(sample.ObjectCount).Append(',').Append(sample.NativeBytes);
            row.Append(',').Append((uint)sample.Flags).Append(suffix);
            file.Write(row.ToString());
        }
    }
}
