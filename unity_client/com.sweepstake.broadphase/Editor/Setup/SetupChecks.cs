#nullable enable
using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using Sweepstake.Unity;
using UnityEditor;

namespace Sweepstake.Editor
{
    internal enum SetupState
    {
        Ok,
        /// <summary>A part is missing, and only the feature that the text names does not work.</summary>
        Optional,
        Wrong,
    }

    /// <summary>One line of the setup window.</summary>
    internal sealed class SetupCheck
    {
        internal SetupCheck(SetupState state, string title, string text, params SetupLink[] links)
        {
            State = state;
            Title = title;
            Text = text;
            Links = links;
        }

        internal SetupState State { get; }
        internal string Title { get; }
        /// <summary>What the checked item is for and, if it is missing, what to do.</summary>
        internal string Text { get; }
        /// <summary>Where the missing parts come from.</summary>
        internal IReadOnlyList<SetupLink> Links { get; }
    }

    /// <summary>A page on which a package describes its installation, and its address for the Package Manager.</summary>
    internal sealed class SetupLink
    {
        internal SetupLink(string name, string page, string gitUrl = "")
        {
            Name = name;
            Page = page;
            GitUrl = gitUrl;
        }

        internal string Name { get; }
        internal string Page { get; }
        /// <summary>For <i>Install package from git URL</i>; empty if a scoped registry is used instead.</summary>
        internal string GitUrl { get; }
    }

    /// <summary>Properties of the project that the checks read.</summary>
    internal sealed class SetupFacts
    {
        /// <summary>Why the native library cannot be used; null if it is present and matches.</summary>
        internal NativeLibraryException? LibraryProblem { get; set; }
        /// <summary>The platform of the build settings.</summary>
        internal BuildTarget Platform { get; set; } = BuildTarget.StandaloneWindows64;
        /// <summary>Whether the project has the native library for that platform.</summary>
        internal bool HasPlatformLibrary { get; set; }
        /// <summary>Whether the iOS player has the define SWEEPSTAKE_IOS.</summary>
        internal bool HasArchiveDefine { get; set; }
        internal bool HasGrpcDefine { get; set; }
        /// <summary>Whether the editor can load an assembly, such as Grpc.Net.Client.</summary>
        internal Func<string, bool> IsLoaded { get; set; } = assembly => false;
        /// <summary>File names of the project's assemblies, such as Google.Protobuf.dll; a duplicate appears twice.</summary>
        internal IReadOnlyList<string> PrecompiledAssemblies { get; set; } = Array.Empty<string>();
        internal bool HasHttpHandlerOfUnity { get; set; }
    }

    /// <summary>Checks a project. Each check contains the remedy for a missing part.</summary>
    internal static class SetupChecks
    {
        internal const string GrpcDefine = "SWEEPSTAKE_GRPC";
        /// <summary>With it, an iOS build links the archive of the native library.</summary>
        internal const string ArchiveDefine = "SWEEPSTAKE_IOS";
        /// <summary>The assembly of the package com.cysharp.yetanotherhttphandler.</summary>
        internal const string Handler = "Cysharp.Net.Http.YetAnotherHttpHandler";

        /// <summary>
        /// What gRPC needs: Grpc.Net.Client, Google.Protobuf and all that these need and Unity's .NET Standard lacks. Unity loads no library whose references are missing.
        /// </summary>
        internal static readonly string[] GrpcAssemblies =
        {
            "Google.Protobuf", "Grpc.Core.Api", "Grpc.Net.Common", "Grpc.Net.Client", "Microsoft.Extensions.Logging.Abstractions",
            "Microsoft.Extensions.DependencyInjection.Abstractions", "System.Diagnostics.DiagnosticSource", "System.Runtime.CompilerServices.Unsafe",
        };

        /// <summary>What YetAnotherHttpHandler needs in addition to Unity's .NET Standard.</summary>
        internal static readonly string[] HandlerAssemblies = { "System.IO.Pipelines", "System.Runtime.CompilerServices.Unsafe" };

        private static readonly SetupLink HandlerLink = new SetupLink(
            "YetAnotherHttpHandler", "https://github.com/Cysharp/YetAnotherHttpHandler",
            "https://github.com/Cysharp/YetAnotherHttpHandler.git?path=src/YetAnotherHttpHandler#1.11.5");

        private static readonly SetupLink LibraryLink = new SetupLink("Native Library", DocumentationPageAttribute.UrlOf("native-library.md"));

        private static readonly SetupLink[] NuGetLinks =
        {
            new SetupLink("NuGetForUnity", "https://github.com/GlitchEnzo/NuGetForUnity", "https://github.com/GlitchEnzo/NuGetForUnity.git?path=/src/NuGetForUnity"),
            new SetupLink("UnityNuGet", "https://github.com/xoofx/UnityNuGet"),
        };

        internal static IReadOnlyList<SetupCheck> Of(SetupFacts facts) => new[]
        {
            Library(facts), Platform(facts), Libraries(facts), Duplicates(facts), Http2(facts), Define(facts),
        };

        internal static IReadOnlyList<string> MissingLibraries(SetupFacts facts) => Missing(facts, GrpcAssemblies);

        private static IReadOnlyList<string> Missing(SetupFacts facts, IEnumerable<string> assemblies) =>
            assemblies.Where(assembly => !facts.IsLoaded(assembly)).ToArray();

        private static SetupCheck Library(SetupFacts facts) => facts.LibraryProblem == null
            ? new SetupCheck(SetupState.Ok, "Native library", "It is present and matches the package.")
            : new SetupCheck(SetupState.Wrong, "Native library", facts.LibraryProblem.Message);

        /// <summary>Whether a file of the project is the native library, for any platform.</summary>
        internal static bool IsLibrary(string path) => Path.GetFileNameWithoutExtension(path) is "sweepstake" or "libsweepstake" or "libsweepstake_static";

        /// <summary>
        /// Checks the platform of the build settings. The check "Native library" is about the editor, which may run on another platform.
        /// </summary>
        private static SetupCheck Platform(SetupFacts facts)
        {
            string? source = SourceOf(facts.Platform);
            if (source == null)
            {
                return new SetupCheck(
                    SetupState.Wrong, "Platform",
                    $"The package does not support {facts.Platform}; a manager logs this and does nothing. Choose another platform in the build settings, or use Unity's own physics queries.");
            }
            if (!facts.HasPlatformLibrary)
            {
                return new SetupCheck(
                    SetupState.Wrong, "Platform", $"The project has no native library for {facts.Platform}, so managers in its builds do nothing. {source}", LibraryLink);
            }
            return facts.Platform == BuildTarget.iOS && !facts.HasArchiveDefine
                ? new SetupCheck(SetupState.Wrong, "Platform", $"The library for iOS is present, but builds do not use it: add {ArchiveDefine} to the scripting define symbols of the iOS player.", LibraryLink)
                : new SetupCheck(SetupState.Ok, "Platform", $"The project has the native library for {facts.Platform}.");
        }

        /// <summary>Returns where the library for a platform comes from; null if the package does not support the platform.</summary>
        private static string? SourceOf(BuildTarget platform) => platform switch
        {
            BuildTarget.StandaloneWindows64 => "A release contains it, and tests/cross.sh of the repository builds it on Linux.",
            BuildTarget.StandaloneLinux64 => "A release contains it, and unity_client/tools/build_plugin.sh of the repository builds it on Linux.",
            BuildTarget.EmbeddedLinux => "A release contains it for arm64, and tests/cross.sh of the repository builds it on Linux.",
            BuildTarget.StandaloneOSX => "Build it on a Mac with CMake; no release contains it yet.",
            BuildTarget.iOS => "Build the archive on a Mac with CMake; no release contains it yet.",
            BuildTarget.Android => "Build it with CMake and the Android NDK; no release contains it yet.",
            _ => null,
        };

        private static SetupCheck Libraries(SetupFacts facts)
        {
            IReadOnlyList<string> missing = MissingLibraries(facts);
            return missing.Count == 0
                ? new SetupCheck(SetupState.Ok, "gRPC's libraries", "The editor has loaded them.")
                : new SetupCheck(
                    SetupState.Optional, "gRPC's libraries",
                    $"Only for a daemon. Missing: {string.Join(", ", missing)}. Install Grpc.Net.Client and Google.Protobuf with NuGetForUnity or UnityNuGet, which add what these need.",
                    NuGetLinks);
        }

        private static SetupCheck Duplicates(SetupFacts facts)
        {
            string[] twice = facts.PrecompiledAssemblies.Where(file => GrpcAssemblies.Concat(HandlerAssemblies).Any(assembly => file == assembly + ".dll"))
                .GroupBy(name => name).Where(group => group.Count() > 1).Select(group => group.Key).ToArray();
            return twice.Length == 0
                ? new SetupCheck(SetupState.Ok, "Duplicates", "No library of gRPC is installed twice.")
                : new SetupCheck(SetupState.Wrong, "Duplicates", $"Installed twice: {string.Join(", ", twice)}. Remove one copy of each; this package does not contain any.");
        }

        private static SetupCheck Http2(SetupFacts facts)
        {
            IReadOnlyList<string> missing = Missing(facts, HandlerAssemblies);
            if (facts.IsLoaded(Handler))
            {
                return missing.Count == 0
                    ? new SetupCheck(SetupState.Ok, "HTTP/2", "The editor has loaded YetAnotherHttpHandler.")
                    : new SetupCheck(SetupState.Wrong, "HTTP/2", $"YetAnotherHttpHandler needs {string.Join(", ", missing)}. Install these with NuGetForUnity or UnityNuGet.", NuGetLinks);
            }
            return facts.HasHttpHandlerOfUnity
                ? new SetupCheck(
                    SetupState.Ok, "HTTP/2", "Unity's own handler. A private authority or a client certificate needs the package com.cysharp.yetanotherhttphandler.", HandlerLink)
                : new SetupCheck(
                    SetupState.Optional, "HTTP/2",
                    $"Only for a daemon. This Unity version does not have HTTP/2; install the package com.cysharp.yetanotherhttphandler, which needs {string.Join(", ", HandlerAssemblies)}. Its git URL needs Git on this machine.",
                    HandlerLink);
        }

        private static SetupCheck Define(SetupFacts facts)
        {
            if (facts.HasGrpcDefine && MissingLibraries(facts).Count > 0)
                return new SetupCheck(SetupState.Wrong, GrpcDefine, "It is set, but gRPC's libraries are missing: the console shows errors. Remove it below, or install them.");
            return facts.HasGrpcDefine
                ? new SetupCheck(SetupState.Ok, GrpcDefine, "It is set: the package compiles its connection to a daemon.")
                : new SetupCheck(SetupState.Optional, GrpcDefine, "Only for a daemon. Install the libraries, then set it below.");
        }
    }
}
