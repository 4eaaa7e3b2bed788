#nullable enable
using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using System.Security.Cryptography;
using System.Text;

namespace Sweepstake
{
    /// <summary>
    /// A file with what deciders have learnt about one scene on one device. The next decider of the scene continues it, and its evidence
    /// counts in full. The file has the format of <see cref="EmbeddedDecider.ExportPriors"/>. It is replaced as a whole, so a crash leaves the
    /// earlier content. One decider at a time uses a file. A second decider of the same scene, also in another process, gets a file of its own.
    /// Thread-safe.
    /// </summary>
    public sealed class SavedPriors
    {
        private const string Extension = ".json";
        private const int MaxNameChars = 40;

        private static readonly object Gate = new object();
        // All files that this process has opened. A file may still have to be written when its decider has ended.
        private static readonly Dictionary<string, SavedPriors> Known = new Dictionary<string, SavedPriors>();

        private readonly string stem;
        private volatile byte[]? unwritten;
        private bool isUsed;
        private bool isWriting;
        // An open file that no other process can open. Held while a decider uses the priors, and until they are written.
        private FileStream? claim;
        private volatile string problem = "";

        private SavedPriors(string stem, string path)
        {
            this.stem = stem;
            Path = path;
        }

        public string Path { get; private set; }
        /// <summary>Why a file was set aside, or why the latest one is not written, and what to do; "" if nothing is wrong.</summary>
        public string Problem => problem;
        /// <summary>Source name under which the decider learns. A new file has a new name, because its sequence numbers begin at 1 again.</summary>
        internal string SourceId => System.IO.Path.GetExtension(System.IO.Path.GetFileNameWithoutExtension(Path)).Substring(1);
        /// <summary>What is newer than the file, because it is not written yet; null if the file is up to date.</summary>
        internal byte[]? Unwritten => unwritten;

        /// <summary>
        /// Selects the scene's file that no decider uses, or a new one. Pass the result to a decider, which gives it back when it ends.
        /// </summary>
        /// <param name="folder">It is created when something is saved.</param>
        /// <param name="device">A name of the device, because timings of other devices are not comparable.</param>
        public static SavedPriors Open(string folder, string project, string scene, string device)
        {
            string stem = System.IO.Path.Combine(folder, $"{FileName(scene)}-{Hash(project, scene, device)}");
            string trouble = "";
            lock (Gate)
            {
                SavedPriors opened = Paths(stem, ref trouble)
                    .Select(path => Known.TryGetValue(path, out SavedPriors? known) ? known : new SavedPriors(stem, path))
                    .FirstOrDefault(found => !found.isUsed && found.TryClaim()) ?? new SavedPriors(stem, NewPath(stem));
                Known[opened.Path] = opened;
                opened.isUsed = true;
                opened.problem = trouble;
                return opened;
            }
        }

        /// <summary>Gives the file back, so that the next decider of the scene may use it.</summary>
        internal void Close()
        {
            lock (Gate)
            {
                isUsed = false;
                ReleaseUnused();
            }
        }

        /// <summary>
        /// Reserves the file for this process. Returns false if another process uses it. A folder that cannot be written
        /// is ignored.
        /// </summary>
        private bool TryClaim()
        {
            if (claim != null)
                return true;
            string path = Path + ".lock";
            FileStream opened;
            try
            {
                opened = new FileStream(path, FileMode.OpenOrCreate, FileAccess.ReadWrite, FileShare.None);
            }
            catch (Exception failed) when (failed is IOException || failed is UnauthorizedAccessException)
            {
                return !File.Exists(path);
            }
            try
            {
                // Unity's runtimes check FileShare only within the process, and .NET locks no regions on macOS.
                opened.Lock(0, 1);
            }
            catch (PlatformNotSupportedException)
            {
            }
            catch (IOException)
            {
                opened.Dispose();
                return false;
            }
            claim = opened;
            return true;
        }

        private void ReleaseUnused()
        {
            if (isUsed || isWriting || unwritten != null)
                return;
            claim?.Dispose();
            claim = null;
        }

        /// <summary>Renames a file that cannot be read, and continues with a new one. Returns false if the file cannot be the cause.</summary>
        internal bool SetAside(SweepstakeException unreadable)
        {
            if (unreadable.Code != ResultCode.DataLoss || unreadable.Message.StartsWith("priors_data:", StringComparison.Ordinal))
                return false;
            string aside = Path + ".unreadable";
            string what = $"They are kept as {aside}.";
            try
            {
                File.Move(Path, aside);
            }
            catch (Exception failed) when (failed is IOException || failed is UnauthorizedAccessException)
            {
                what = $"They could not be renamed: {failed.Message}";
            }
            lock (Gate)
            {
                Known.Remove(Path);
                claim?.Dispose();
                claim = null;
                Path = NewPath(stem);
                Known[Path] = this;
                unwritten = null;
            }
            problem = $"The saved priors cannot be read, so the game learns from the start. {what} {unreadable.Message}";
            return true;
        }

        /// <summary>
        /// Writes the file, on the calling thread. If another thread is writing it, that thread writes these priors too, and the call returns
        /// at once. On a failure, the priors stay in memory for the next decider.
        /// </summary>
        internal void Save(byte[] priors)
        {
            lock (Gate)
            {
                unwritten = priors;
                if (isWriting)
                    return;
                isWriting = true;
            }
            for (bool isDone = false; !isDone;)
            {
                byte[] next = Unwritten!;
                bool isWritten = Replace(next);
                lock (Gate)
                {
                    isDone = unwritten == next;
                    isWriting = !isDone;
                    if (isDone && isWritten)
                        unwritten = null;
                    ReleaseUnused();
                }
            }
        }

        private bool Replace(byte[] content)
        {
            try
            {
                Directory.CreateDirectory(System.IO.Path.GetDirectoryName(Path)!);
                lock (Gate)
                    TryClaim();
                string temporary = Path + ".tmp";
                using (var file = new FileStream(temporary, FileMode.Create, FileAccess.Write, FileShare.None))
                {
                    file.Write(content, 0, content.Length);
                    file.Flush(true);
                }
                if (File.Exists(Path))
                    File.Replace(temporary, Path, null);
                else
                    File.Move(temporary, Path);
                return true;
            }
            catch (Exception failed) when (failed is IOException || failed is UnauthorizedAccessException)
            {
                problem = $"What the game has learnt could not be saved as {Path}: {failed.Message} Check the folder and the disk.";
                return false;
            }
        }

        /// <summary>The scene's files on the disk and those that are not written yet, in a fixed order.</summary>
        private static IEnumerable<string> Paths(string stem, ref string trouble)
        {
            var paths = new SortedSet<string>(Known.Where(known => known.Value.stem == stem).Select(known => known.Key), StringComparer.Ordinal);
            try
            {
                string folder = System.IO.Path.GetDirectoryName(stem)!;
                if (Directory.Exists(folder))
                    paths.UnionWith(Directory.GetFiles(folder, System.IO.Path.GetFileName(stem) + ".*" + Extension));
            }
            catch (Exception failed) when (failed is IOException || failed is UnauthorizedAccessException)
            {
                trouble = $"The saved priors cannot be read, so the game learns from the start: {failed.Message}";
            }
            return paths;
        }

        private static string NewPath(string stem) => $"{stem}.{Guid.NewGuid():N}{Extension}";

        /// <summary>The letters and digits of a name, for people who look at the files. The hash makes the file name unique.</summary>
        private static string FileName(string name)
        {
            string kept = new string(name.Where(letter => letter < 128 && char.IsLetterOrDigit(letter)).Take(MaxNameChars).ToArray());
            return kept.Length > 0 ? kept : "scene";
        }

        private static string Hash(params string[] names)
        {
            using SHA256 hash = SHA256.Create();
            byte[] bytes = hash.ComputeHash(Encoding.UTF8.GetBytes(string.Join("\0", names)));
            return BitConverter.ToString(bytes, 0, 8).Replace("-", "").ToLowerInvariant();
        }
    }
}
