#nullable enable
using System;
using System.Collections.Generic;
using System.Linq;

namespace Sweepstake.Editor
{
    internal enum SetupState
    {
        Ok,
        /// <summary>Without it the package works, but for what the text says.</summary>
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
        /// <summary>What it is for and, if it is not well, what to do.</summary>
        internal string Text { get; }
    }

    /// <summary>What the editor knows of the project, for the checks.</summary>
    internal sealed class SetupFacts
    {
        /// <summary>Null: the native library is there and fits.</summary>
        internal NativeLibraryException? LibraryProblem { get; set; }
        internal bool IsWebGl { get; set; }
        internal bool HasGrpcDefine { get; set; }
        /// <summary>Files such as Google.Protobuf.dll; a name that is there twice stands there twice.</summary>
        internal IReadOnlyList<string> PrecompiledAssemblies { get; set; } = Array.Empty<string>();
        internal bool HasHttpHandlerPackage { get; set; }
        internal bool HasHttpHandlerOfUnity { get; set; }
    }

    /// <summary>What is well with a project, what is missing, and the remedy.</summary>
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
            ? new SetupCheck(SetupState.Ok, "Native library", "It is there and fits.")
            : new SetupCheck(SetupState.Wrong, "Native library", facts.LibraryProblem.Message);

        private static SetupCheck Platform(SetupFacts facts) => facts.IsWebGl
            ? new SetupCheck(SetupState.Wrong, "Platform", "There is no native library for WebGL; a manager says so there and does nothing. Use Unity's own physics queries.")
            : new SetupCheck(SetupState.Ok, "Platform", "The platform of the build settings is no obstacle; the documents say for which ones there is a native library.");

        private static SetupCheck Assemblies(SetupFacts facts)
        {
            IReadOnlyList<string> missing = MissingAssemblies(facts);
            return missing.Count == 0
                ? new SetupCheck(SetupState.Ok, "gRPC's libraries", "They are there.")
                : new SetupCheck(
                    SetupState.Optional, "gRPC's libraries",
                    $"Only for a daemon. Missing: {string.Join(", ", missing)}. Install Grpc.Net.Client and Google.Protobuf with a NuGet client for Unity.");
        }

        private static SetupCheck Duplicates(SetupFacts facts)
        {
            string[] twice = facts.PrecompiledAssemblies.Where(GrpcAssemblies.Contains).GroupBy(name => name).Where(group => group.Count() > 1)
                .Select(group => group.Key).ToArray();
            return twice.Length == 0
                ? new SetupCheck(SetupState.Ok, "Duplicates", "No library of gRPC is there twice.")
                : new SetupCheck(SetupState.Wrong, "Duplicates", $"There twice: {string.Join(", ", twice)}. Remove one of each; this package brings none.");
        }

        private static SetupCheck Handler(SetupFacts facts)
        {
            if (facts.HasHttpHandlerPackage)
                return new SetupCheck(SetupState.Ok, "HTTP/2", "YetAnotherHttpHandler is there.");
            return facts.HasHttpHandlerOfUnity
                ? new SetupCheck(SetupState.Ok, "HTTP/2", "Unity's own handler. A private authority or a client certificate needs the package com.cysharp.yetanotherhttphandler.")
                : new SetupCheck(SetupState.Optional, "HTTP/2", "Only for a daemon. This Unity has none; install the package com.cysharp.yetanotherhttphandler.");
        }

        private static SetupCheck Define(SetupFacts facts)
        {
            if (facts.HasGrpcDefine && MissingAssemblies(facts).Count > 0)
                return new SetupCheck(SetupState.Wrong, GrpcDefine, "It is set, and gRPC's libraries are missing: the console shows errors. Remove it below, or install them.");
            return facts.HasGrpcDefine
                ? new SetupCheck(SetupState.Ok, GrpcDefine, "It is set: the package compiles its connection to a daemon.")
                : new SetupCheck(SetupState.Optional, GrpcDefine, "Only for a daemon. Once the libraries are there, set it below.");
        }
    }
}
