#nullable enable
using System;
using System.Buffers.Binary;
using System.Collections.Generic;
using System.IO;
using System.Text;

namespace Sweepstake.Samples
{
    /// <summary>
    /// Writes frames of boxes to an .aabbs file, which `sweepstake-lab trace`, `bench` and `replay` read and the library plays as a scene.
    /// If the number of boxes changes, the file uses the format's extension for changing counts. The data goes to a temporary file, which
    /// gets its final name when it is complete.
    /// </summary>
    public sealed class AabbsWriter : IDisposable
    {
        private const int HeaderBytes = 304;
        private const int NameBytes = 128;
        private const int BoxBytes = 32;
        private const int BufferBytes = 1 << 20;

        private readonly string path;
        private readonly string name;
        private readonly List<int> counts = new List<int>();
        private readonly byte[] box = new byte[BoxBytes];
        private FileStream? file;
        private Aabb world = new Aabb(float.MaxValue, float.MaxValue, float.MaxValue, float.MinValue, float.MinValue, float.MinValue);

        /// <param name="path">An existing file is replaced when the new one is complete.</param>
        /// <param name="name">
        /// Name of the scene: printable ASCII of at most 127 characters. Other characters become '?', and a longer name is cut.
        /// </param>
        /// <exception cref="IOException">The file cannot be written.</exception>
        public AabbsWriter(string path, string name)
        {
            this.path = path;
            this.name = name;
            file = new FileStream(PartialPath, FileMode.Create, FileAccess.Write, FileShare.None, BufferBytes);
            file.Write(new byte[HeaderBytes], 0, HeaderBytes);
        }

        public int FrameCount => counts.Count;

        private string PartialPath => path + ".partial";

        /// <summary>
        /// Adds a frame; the first one is the spawn state. An index stands for the same object in all frames. A box that is not finite is written
        /// as a box that overlaps nothing.
        /// </summary>
        public void Write(IReadOnlyList<Aabb> boxes)
        {
            if (file == null)
                throw new ObjectDisposedException(nameof(AabbsWriter));
            counts.Add(boxes.Count);
            for (int index = 0; index < boxes.Count; ++index)
            {
                Encode(boxes[index]);
                file.Write(box, 0, BoxBytes);
            }
        }

        /// <summary>Completes the file.</summary>
        /// <exception cref="InvalidOperationException">No frame had an object; no file was written.</exception>
        public void Finish()
        {
            if (file == null)
                return;
            int most = 0;
            foreach (int count in counts)
                most = Math.Max(most, count);
            if (most == 0)
            {
                Dispose();
                throw new InvalidOperationException("There was nothing to record: no frame had an object.");
            }
            bool isChanging = counts.Exists(count => count != most);
            for (int frame = 0; isChanging && frame < counts.Count; ++frame)
            {
                BinaryPrimitives.WriteInt32LittleEndian(box, counts[frame]);
                file.Write(box, 0, sizeof(int));
            }
            file.Seek(0, SeekOrigin.Begin);
            file.Write(Header(most, isChanging), 0, HeaderBytes);
            file.Dispose();
            file = null;
            if (File.Exists(path))
                File.Delete(path);
            File.Move(PartialPath, path);
        }

        /// <summary>Deletes the incomplete file if <see cref="Finish"/> was not called.</summary>
        public void Dispose()
        {
            if (file == null)
                return;
            file.Dispose();
            file = null;
            File.Delete(PartialPath);
        }

        private byte[] Header(int most, bool isChanging)
        {
            var header = new byte[HeaderBytes];
            Ascii(name).CopyTo(header, 0);
            Ascii("AABB").CopyTo(header, NameBytes);
            BinaryPrimitives.WriteInt32LittleEndian(header.AsSpan(2 * NameBytes), most);
            BinaryPrimitives.WriteInt32LittleEndian(header.AsSpan(2 * NameBytes + 4), counts.Count - 1);
            BinaryPrimitives.WriteInt32LittleEndian(header.AsSpan(2 * NameBytes + 8), isChanging ? 1 : 0);
            if (world.MinX > world.MaxX)
                world = default;
            Encode(world);
            box.CopyTo(header, HeaderBytes - BoxBytes);
            return header;
        }

        private void Encode(in Aabb encoded)
        {
            Aabb written = IsFinite(encoded) ? encoded : new Aabb(1, 1, 1, -1, -1, -1);
            if (written.IsValid)
                Widen(written);
            Put(0, written.MinX);
            Put(4, written.MinY);
            Put(8, written.MinZ);
            Put(16, written.MaxX);
            Put(20, written.MaxY);
            Put(24, written.MaxZ);
        }

        private void Widen(in Aabb added)
        {
            world = new Aabb(
                Math.Min(world.MinX, added.MinX), Math.Min(world.MinY, added.MinY), Math.Min(world.MinZ, added.MinZ),
                Math.Max(world.MaxX, added.MaxX), Math.Max(world.MaxY, added.MaxY), Math.Max(world.MaxZ, added.MaxZ));
        }

        private void Put(int at, float value) => BinaryPrimitives.WriteInt32LittleEndian(box.AsSpan(at), BitConverter.SingleToInt32Bits(value));

        private static byte[] Ascii(string text)
        {
            var printable = new StringBuilder();
            for (int index = 0; index < text.Length && index < NameBytes - 1; ++index)
                printable.Append(text[index] >= ' ' && text[index] <= '~' ? text[index] : '?');
            return Encoding.ASCII.GetBytes(printable.ToString());
        }

        private static bool IsFinite(in Aabb tested) =>
            float.IsFinite(tested.MinX) && float.IsFinite(tested.MinY) && float.IsFinite(tested.MinZ) &&
            float.IsFinite(tested.MaxX) && float.IsFinite(tested.MaxY) && float.IsFinite(tested.MaxZ);
    }
}
