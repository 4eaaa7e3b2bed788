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

    /// <summary>
    /// The native library: whether it is there and fits, what it holds, and its end. Any thread may call any of this at any time, but Shutdown.
    /// </summary>
    public static unsafe class SweepstakeLibrary
    {
        private const string Install =
            "Put the plug-in of this package's version into Runtime/Plugins, or Assets/Plugins (Documentation~/native-library.md says how it is built).";

#if UNITY_WEBGL && !UNITY_EDITOR
        private const bool IsWebGL = true;
#else
        private const bool IsWebGL = false;
#endif

        private static volatile bool isChecked;
        private static IReadOnlyList<string>? backends;
        private static IReadOnlyList<string>? scenes;

        /// <summary>The version of the library, for people.</summary>
        /// <exception cref="NativeLibraryException">The library does not fit.</exception>
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

        /// <summary>The backends by name, in the order of the library; brute force, the oracle, is one of them.</summary>
        /// <exception cref="NativeLibraryException">The library does not fit.</exception>
        public static IReadOnlyList<string> Backends
        {
            get
            {
                EnsureLoaded();
                return backends ??= Native.Texts(NativeMethods.swp_backend_count(), index => Native.Text(NativeMethods.swp_backend_name(index)));
            }
        }

        /// <summary>The scenes by name: the five scenarios first, then the reference suite, changing and degenerate ones.</summary>
        /// <exception cref="NativeLibraryException">The library does not fit.</exception>
        public static IReadOnlyList<string> Scenes
        {
            get
            {
                EnsureLoaded();
                return scenes ??= Native.Texts(NativeMethods.swp_scene_count(), index => Native.Text(NativeMethods.swp_scene_name(index)));
            }
        }

        /// <summary>
        /// Loads the library and compares its ABI and each struct, field by field, with this assembly; once, then it costs nothing.
        /// </summary>
        /// <exception cref="NativeLibraryException">It is missing, of another ABI, or there is none for this platform.</exception>
        public static void EnsureLoaded()
        {
            NativeLibraryException? problem = FindProblem();
            if (problem != null)
                throw problem;
        }

        /// <summary>As <see cref="EnsureLoaded"/>, for user interfaces: null if all is well.</summary>
        public static NativeLibraryException? FindProblem()
        {
            if (isChecked)
                return null;
            NativeLibraryException? lacking = FindPlatformProblem(IsWebGL, IntPtr.Size);
            if (lacking != null)
                return lacking;
            try
            {
                return CompareAbi();
            }
            catch (DllNotFoundException missing)
            {
                return new NativeLibraryException("The native library 'sweepstake' was not found.", Install, missing);
            }
            catch (EntryPointNotFoundException missing)
            {
                return new NativeLibraryException("The native library 'sweepstake' is not the one of this package.", Install, missing);
            }
            catch (BadImageFormatException wrong)
            {
                return new NativeLibraryException("The native library 'sweepstake' is for another platform.", Install, wrong);
            }
        }

        /// <summary>Null where there can be a library, if not here.</summary>
        internal static NativeLibraryException? FindPlatformProblem(bool isWebGL, int pointerBytes)
        {
            if (isWebGL)
                return new NativeLibraryException("Sweepstake has no native library for WebGL.", "Use Unity's own physics queries there.");
            return pointerBytes == 8
                ? null
                : new NativeLibraryException("Sweepstake needs a 64-bit process.", "Choose a 64-bit architecture in the player's settings.");
        }

        /// <summary>How many native objects of a kind live in the process.</summary>
        public static int LiveCount(ObjectKind kind = ObjectKind.Any)
        {
            EnsureLoaded();
            return (int)NativeMethods.swp_live_count(kind);
        }

        /// <summary>
        /// Ends all connections and deciders, then every native object of the process with its threads and memory, in about the given time
        /// at most: before a domain reload, at the end of play mode and of the game. No frame, job or query may be under way. What is made
        /// afterwards lives; wrappers that are left over throw. May be called more than once, where there is no library that fits, and first
        /// of all in a new domain: what the former one has left behind ends, too.
        /// </summary>
        /// <returns>Whether all has ended; false: some call had not returned in time, and a later Shutdown goes on.</returns>
        public static bool Shutdown(int timeoutMs = SessionWork.DisposeTimeoutMs)
        {
            ulong endNs = SteadyClock.NowNs + (ulong)Math.Max(0, timeoutMs) * 1_000_000;
            SessionWork[] stopped = SessionWork.StopAll(endNs);
            if (FindProblem() != null)
                return true;
            ulong nowNs = SteadyClock.NowNs;
            uint leftMs = nowNs < endNs ? (uint)((endNs - nowNs) / 1_000_000) : 0;
            if (NativeMethods.swp_shutdown_all(leftMs) != ResultCode.Ok)
                return false;
            foreach (SessionWork work in stopped)
                work.Release();
            return true;
        }

        private static NativeLibraryException? CompareAbi()
        {
            uint abi = NativeMethods.swp_abi_version();
            if (abi != NativeLayouts.AbiVersion)
            {
                return new NativeLibraryException(
                    $"The native library 'sweepstake' has ABI {abi}, and this package needs ABI {NativeLayouts.AbiVersion}.", Install);
            }
            var problems = new LayoutProblems();
            NativeLayouts.Check(problems);
            isChecked = problems.IsEmpty;
            return isChecked ? null : new NativeLibraryException($"The native library 'sweepstake' does not fit: {problems}.", Install);
        }
    }
}
