#nullable enable
using System;
using System.Collections.Generic;
using System.Linq;

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
        internal SetupCheck(SetupState state, string title, string text)
        {
            State = state;
            Title = title;
            Text = text;
        }

        internal SetupState State { get; }
        internal string Title { get; }
        /// <summary>What the checked item is for and, if it is missing, what to do.</summary>
        internal string Text { get; }
    }

    /// <summary>Properties of the project that the checks read.</summary>
    internal sealed class SetupFacts
    {
        /// <summary>Why the native library cannot be used; null if it is present and matches.</summary>
        internal NativeLibraryException? LibraryProblem { get; set; }
        internal bool IsWebGl { get; set; }
        internal bool HasGrpcDefine { get; set; }
        /// <summary>File names of the project's assemblies, such as Google.Protobuf.dll; a duplicate appears twice.</summary>
        internal IReadOnlyList<string> PrecompiledAssemblies { get; set; } = Array.Empty<string>();
        internal bool HasHttpHandlerPackage { get; set; }
        internal bool HasHttpHandlerOfUnity { get; set; }
    }

    /// <summary>Checks a project. Each check contains the remedy for a missing part.</summary>
    internal static class SetupChecks
    {
        internal const string GrpcDefine = "SWEEPSTAKE_GRPC";
        internal static readonly string[] GrpcAssemblies =
        {
            "Google.Protobuf.dll", "Grpc.Core.Api.dll", "Grpc.Net.Common.dll", "Grpc.Net.Client.dll", "Microsoft.Extensions.Logging.Abstractions.dll",
        };

        internal static IReadOnlyList<SetupCheck> Of(SetupFacts facts) => new[]
        {
            Library(facts), Platform(facts), Assemblies(facts), Duplicates(facts), Handler(facts), Define(facts),
        };

        internal static IReadOnlyList<string> MissingAssemblies(SetupFacts facts) => GrpcAssemblies.Except(facts.PrecompiledAssemblies).ToArray();

        private static SetupCheck Library(SetupFacts facts) => facts.LibraryProblem == null
            ? new SetupCheck(SetupState.Ok, "Native library", "It is present and matches the package.")
            : new SetupCheck(SetupState.Wrong, "Native library", facts.LibraryProblem.Message);

        private static SetupCheck Platform(SetupFacts facts) => facts.IsWebGl
            ? new SetupCheck(SetupState.Wrong, "Platform", "The package does not support WebGL; a manager logs this and does nothing. Use Unity's own physics queries.")
            : new SetupCheck(SetupState.Ok, "Platform", "The platform of the build settings can have a native library; the documents list the platforms that have one.");

        private static SetupCheck Assemblies(SetupFacts facts)
        {
            IReadOnlyList<string> missing = MissingAssemblies(facts);
            return missing.Count == 0
                ? new SetupCheck(SetupState.Ok, "gRPC's libraries", "They are installed.")
                : new SetupCheck(
                    SetupState.Optional, "gRPC's libraries",
                    $"Only for a daemon. Missing: {string.Join(", ", missing)}. Install Grpc.Net.Client and Google.Protobuf with a NuGet client for Unity.");
        }

        private static SetupCheck Duplicates(SetupFacts facts)
        {
            string[] twice = facts.PrecompiledAssemblies.Where(GrpcAssemblies.Contains).GroupBy(name => name).Where(group => group.Count() > 1)
                .Select(group => group.Key).ToArray();
            return twice.Length == 0
                ? new SetupCheck(SetupState.Ok, "Duplicates", "No library of gRPC is installed twice.")
                : new SetupCheck(SetupState.Wrong, "Duplicates", $"Installed twice: {string.Join(", ", twice)}. Remove one copy of each; this package does not contain any.");
        }

        private static SetupCheck Handler(SetupFacts facts)
        {
            if (facts.HasHttpHandlerPackage)
                return new SetupCheck(SetupState.Ok, "HTTP/2", "YetAnotherHttpHandler is installed.");
            return facts.HasHttpHandlerOfUnity
                ? new SetupCheck(SetupState.Ok, "HTTP/2", "Unity's own handler. A private authority or a client certificate needs the package com.cysharp.yetanotherhttphandler.")
                : new SetupCheck(SetupState.Optional, "HTTP/2", "Only for a daemon. This Unity version does not have HTTP/2; install the package com.cysharp.yetanotherhttphandler.");
        }

        private static SetupCheck Define(SetupFacts facts)
        {
            if (facts.HasGrpcDefine && MissingAssemblies(facts).Count > 0)
                return new SetupCheck(SetupState.Wrong, GrpcDefine, "It is set, but gRPC's libraries are missing: the console shows errors. Remove it below, or install them.");
            return facts.HasGrpcDefine
                ? new SetupCheck(SetupState.Ok, GrpcDefine, "It is set: the package compiles its connection to a daemon.")
                : new SetupCheck(SetupState.Optional, GrpcDefine, "Only for a daemon. Install the libraries, then set it below.");
        }
    }
}
