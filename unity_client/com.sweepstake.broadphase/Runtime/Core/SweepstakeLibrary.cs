#nullable enable
using System;
using System.Collections.Generic;
using Sweepstake.LowLevel;

namespace Sweepstake
{
    /// <summary>The kinds of native objects.</summary>
    public enum ObjectKind : uint
    {
        Any = 0,
        World = 1,
        Session = 2,
        Proxies = 3,
        Scene = 4,
        Link = 5,
    }

    /// <summary>The native library: whether it is present and matches, its contents, and its shutdown. Thread-safe, except for Shutdown.</summary>
    public static unsafe class SweepstakeLibrary
    {
        private const string Install =
            "Window > Sweepstake > Setup has a button for each way to get it. It belongs into Runtime/Plugins or Assets/Plugins (Documentation~/native-library.md).";

        private static volatile bool isChecked;
        private static volatile int shutdownCount;
        private static IReadOnlyList<string>? backends;
        private static IReadOnlyList<string>? scenes;

        /// <summary>The number of shutdowns. An object that was created before the latest one has ended.</summary>
        internal static int ShutdownCount => shutdownCount;

        /// <summary>The version of the library, for display.</summary>
        /// <exception cref="NativeLibraryException">The library does not match this package.</exception>
        public static Version Version
        {
            get
            {
                EnsureLoaded();
                uint major, minor, patch;
                Native.Check(NativeMethods.swp_version(&major, &minor, &patch));
                return new Version((int)major, (int)minor, (int)patch);
            }
        }

        /// <summary>The names of the backends in the order of the library, including BruteForce, the reference for tests.</summary>
        /// <exception cref="NativeLibraryException">The library does not match this package.</exception>
        public static IReadOnlyList<string> Backends =>
            backends ??= Names(NativeMethods.swp_backend_count, index => Native.Text(NativeMethods.swp_backend_name(index)));

        /// <summary>The names of the scenes: first the five scenarios, then the reference suite, then changing and degenerate scenes.</summary>
        /// <exception cref="NativeLibraryException">The library does not match this package.</exception>
        public static IReadOnlyList<string> Scenes =>
            scenes ??= Names(NativeMethods.swp_scene_count, index => Native.Text(NativeMethods.swp_scene_name(index)));

        /// <summary>Loads the library and compares its ABI and each struct, field by field, with this assembly. Later calls cost nothing.</summary>
        /// <exception cref="NativeLibraryException">The library is missing, has another ABI, or does not exist for this platform.</exception>
        public static void EnsureLoaded()
        {
            if (FindProblem() is NativeLibraryException problem)
                throw problem;
        }

        /// <summary>Like <see cref="EnsureLoaded"/>, for user interfaces: returns the problem, or null if there is none.</summary>
        public static NativeLibraryException? FindProblem()
        {
            if (isChecked)
                return null;
            try
            {
                return FindPlatformProblem(NativeMethods.HasLibrary, IntPtr.Size) ?? CompareAbi();
            }
            catch (Exception wrong) when (wrong is DllNotFoundException || wrong is EntryPointNotFoundException || wrong is BadImageFormatException)
            {
                return Unusable(
                    wrong is DllNotFoundException ? "was not found" :
                    wrong is EntryPointNotFoundException ? "lacks a function that this package needs" : "is for another platform", wrong);
            }
        }

        /// <summary>Returns why this build cannot use a native library; null if it can use one.</summary>
        internal static NativeLibraryException? FindPlatformProblem(bool hasLibrary, int pointerBytes)
        {
            if (!hasLibrary)
            {
                return new NativeLibraryException(
                    "Sweepstake does not support this platform: the build has no native library for it.",
                    "Use Unity's own physics queries there. On iOS, add the archive and the define SWEEPSTAKE_IOS (Documentation~/native-library.md).",
                    new NotSupportedException());
            }
            return pointerBytes == 8
                ? null
                : new NativeLibraryException("Sweepstake needs a 64-bit process.", "Choose a 64-bit architecture in the player's settings.");
        }

        /// <summary>The number of live native objects of a kind in this process.</summary>
        public static int LiveCount(ObjectKind kind = ObjectKind.Any)
        {
            EnsureLoaded();
            return (int)NativeMethods.swp_live_count(kind);
        }

        /// <summary>
        /// Ends all connections and deciders, then frees every native object of the process with its threads and memory, within about the
        /// given time. Call it before a domain reload, at the end of play mode and at the end of the game. No frame, job or query may be
        /// running. Objects created afterwards work; older wrappers throw. It may be called repeatedly, and without a matching library. As
        /// the first call in a new domain, it also frees the objects that the former domain left.
        /// </summary>
        /// <returns>True if everything has ended. False: a call did not return in time, and a later Shutdown continues.</returns>
        public static bool Shutdown(int timeoutMs = SessionWork.DisposeTimeoutMs)
        {
            ulong endNs = SteadyClock.After(timeoutMs);
            SessionWork[] stopped = SessionWork.StopAll(endNs);
            if (FindProblem() != null)
                return true;
            bool hasEnded = NativeMethods.swp_shutdown_all((uint)SteadyClock.MsUntil(endNs)) == ResultCode.Ok;
            ++shutdownCount;
            if (!hasEnded)
                return false;
            foreach (SessionWork work in stopped)
                work.Release();
            return true;
        }

        internal delegate ResultCode Initializer<T>(T* options)
            where T : unmanaged;

        /// <summary>Returns options with the library's defaults. Allocates nothing with a lambda that captures nothing.</summary>
        /// <param name="options">Options with the size of their struct.</param>
        internal static T Defaults<T>(T options, Initializer<T> initialize)
            where T : unmanaged
        {
            EnsureLoaded();
            Native.Check(initialize(&options));
            return options;
        }

        private static IReadOnlyList<string> Names(Func<uint> count, Func<uint, string> nameOf)
        {
            EnsureLoaded();
            return Native.Texts(count(), nameOf);
        }

        private static NativeLibraryException? CompareAbi()
        {
            uint abi = NativeMethods.swp_abi_version();
            if (abi != NativeLayouts.AbiVersion)
                return Unusable($"has ABI {abi}, and this package needs ABI {NativeLayouts.AbiVersion}");
            var problems = new LayoutProblems();
            NativeLayouts.Check(problems);
            isChecked = problems.IsEmpty;
            return isChecked ? null : Unusable($"has other structs than this package: {problems}");
        }

        private static NativeLibraryException Unusable(string problem, Exception? cause = null) =>
            new NativeLibraryException($"The native library 'sweepstake' {problem}.", Install, cause);
    }
}
