#nullable enable
using System;
using System.Globalization;
using System.IO;
using System.Linq;
using System.Text;
using System.Threading;

namespace Sweepstake
{
    /// <summary>
    /// Writes frame samples to a CSV file (RFC 4180, invariant culture) on its own thread. The frame thread only copies a sample into a bounded
    /// ring. If the ring is full, the new sample is dropped and counted; the frame thread never waits and allocates nothing. Only one thread may
    /// write samples.
    /// </summary>
    /// <remarks>
    /// The first columns are those of `sweepstake run --csv`. The others are the same in all rows: the version of the columns, the scene, the
    /// seed, the version of the library, and the vertical blanks per frame (vSync) when the recording began, because vSync caps the frame rate.
    /// </remarks>
    public sealed class FrameCsvWriter : IDisposable
    {
        /// <summary>Incremented when the columns change.</summary>
        public const int FormatVersion = 2;
        /// <summary>Maximum time that Dispose waits for the file, in milliseconds.</summary>
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
        private readonly ManualResetEvent ending = new ManualResetEvent(false);
        private readonly StringBuilder row = new StringBuilder();
        private long written;
        private long taken;
        private long dropped;
        private volatile Exception? failure;

        /// <param name="path">An existing file is replaced.</param>
        /// <param name="session">The session whose frames are recorded.</param>
        /// <param name="scene">Name of the scene; "" if not known.</param>
        /// <param name="seed">Seed of the scene; 0 if not known.</param>
        /// <param name="capacity">Size of the ring in frames; 4,096 frames take 256 KiB.</param>
        /// <param name="vSyncCount">Vertical blanks per frame when the recording began; 0: no vSync; null: not known.</param>
        /// <exception cref="IOException">The file cannot be written.</exception>
        public FrameCsvWriter(string path, BroadPhaseSession session, string scene = "", ulong seed = 0, int capacity = 4096, int? vSyncCount = null)
        {
            if (capacity < 1)
                throw new ArgumentOutOfRangeException(nameof(capacity));
            ring = new FrameSample[capacity];
            arms = session.Arms.Select(Quoted).ToArray();
            suffix = string.Format(
                CultureInfo.InvariantCulture, ",{0},{1},{2},{3},{4}\r\n", FormatVersion, Quoted(scene), seed, SweepstakeLibrary.Version, vSyncCount);
            file = new StreamWriter(path, false, new UTF8Encoding(false));
            file.Write(Header);
            thread = new Thread(WriteRows) { IsBackground = true, Name = "sweepstake csv" };
            thread.Start();
        }

        /// <summary>Samples dropped because the ring was full.</summary>
        public long DroppedCount => Interlocked.Read(ref dropped);
        /// <summary>Why writing has ended, for example because the disk is full; null while there is no failure.</summary>
        public Exception? Failure => failure;

        /// <summary>Queues the sample of the frame that has just ended.</summary>
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

        /// <summary>Writes the queued samples and closes the file. May be called more than once.</summary>
        /// <returns>True if the file is complete. Otherwise the writing thread continues; <see cref="Failure"/> is set if it fails.</returns>
        public bool Stop(int timeoutMs)
        {
            ending.Set();
            return thread.Join(Math.Max(0, timeoutMs));
        }

        public void Dispose() => Stop(DisposeTimeoutMs);

        internal static string Quoted(string field) =>
            field.IndexOfAny(new[] { ',', '"', '\r', '\n' }) < 0 ? field : "\"" + field.Replace("\"", "\"\"") + "\"";

        private void WriteRows()
        {
            try
            {
                using (file)
                {
                    while (!ending.WaitOne(FlushIntervalMs))
                        WriteTaken();
                    WriteTaken();
                }
            }
            catch (Exception problem) when (problem is IOException || problem is ObjectDisposedException || problem is UnauthorizedAccessException)
            {
                failure = problem;
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
            file.Write(row);
        }
    }
}
