#nullable disable
using System.Linq;
using NUnit.Framework;
using Sweepstake.Editor;
using UnityEditor;
using UnityEngine.UIElements;

namespace Sweepstake.Tests
{
    public sealed class SetupTest
    {
        [Test]
        public void TheSetupSaysWhatIsMissingAndTheRemedy()
        {
            bool HasAll(string assembly) => true;
            AssertCheck(new SetupFacts(), "gRPC's libraries", SetupState.Optional, "Google.Protobuf");
            AssertCheck(new SetupFacts(), "gRPC's libraries", SetupState.Optional, "System.Diagnostics.DiagnosticSource");
            AssertCheck(new SetupFacts { IsLoaded = HasAll }, "gRPC's libraries", SetupState.Ok, "");
            AssertCheck(new SetupFacts { PrecompiledAssemblies = new[] { "Grpc.Core.Api.dll", "Grpc.Core.Api.dll" } }, "Duplicates", SetupState.Wrong, "Grpc.Core.Api.dll");
            AssertCheck(new SetupFacts { HasGrpcDefine = true }, "SWEEPSTAKE_GRPC", SetupState.Wrong, "Remove it");
            AssertCheck(new SetupFacts { HasGrpcDefine = true, IsLoaded = HasAll }, "SWEEPSTAKE_GRPC", SetupState.Ok, "");
            AssertCheck(new SetupFacts(), "HTTP/2", SetupState.Optional, "com.cysharp.yetanotherhttphandler");
            AssertCheck(new SetupFacts { IsLoaded = HasAll }, "HTTP/2", SetupState.Ok, "YetAnotherHttpHandler");
            AssertCheck(new SetupFacts { IsLoaded = assembly => assembly == SetupChecks.Handler }, "HTTP/2", SetupState.Wrong, "System.IO.Pipelines");
            AssertCheck(new SetupFacts { HasHttpHandlerOfUnity = true }, "HTTP/2", SetupState.Ok, "Unity's own");
            AssertCheck(new SetupFacts { LibraryProblem = new NativeLibraryException("It is gone.", "Put it back.") }, "Native library", SetupState.Wrong, "Put it back.");
        }

        [TestCase(BuildTarget.StandaloneWindows64, "A release contains it")]
        [TestCase(BuildTarget.StandaloneLinux64, "A release contains it")]
        [TestCase(BuildTarget.EmbeddedLinux, "for arm64")]
        [TestCase(BuildTarget.StandaloneOSX, "on a Mac")]
        [TestCase(BuildTarget.iOS, "on a Mac")]
        [TestCase(BuildTarget.Android, "Android NDK")]
        public void APlatformNeedsItsOwnLibrary(BuildTarget platform, string remedy)
        {
            AssertCheck(new SetupFacts { Platform = platform }, "Platform", SetupState.Wrong, remedy);
            AssertCheck(new SetupFacts { Platform = platform, HasPlatformLibrary = true, HasArchiveDefine = true }, "Platform", SetupState.Ok, platform.ToString());
        }

        [Test]
        public void AnIosBuildNeedsTheDefineToo()
        {
            AssertCheck(new SetupFacts { Platform = BuildTarget.iOS, HasPlatformLibrary = true }, "Platform", SetupState.Wrong, "SWEEPSTAKE_IOS");
        }

        [TestCase(BuildTarget.WebGL)]
        [TestCase(BuildTarget.StandaloneWindows)]
        public void OtherPlatformsAreNotSupported(BuildTarget platform)
        {
            AssertCheck(new SetupFacts { Platform = platform, HasPlatformLibrary = true }, "Platform", SetupState.Wrong, "does not support");
        }

        [Test]
        public void TheSettingsPageIsFoundBySearchWords()
        {
            SettingsProvider page = SweepstakeSettingsProvider.Create();
            Assert.That(page.settingsPath, Is.EqualTo("Project/Sweepstake"));
            Assert.That(page.keywords, Does.Contain("broad phase").And.Contain("TLS").And.Contain("daemon"));
            var root = new VisualElement();
            page.activateHandler("", root);
            Assert.That(root.Children(), Is.Not.Empty);
        }

        private static void AssertCheck(SetupFacts facts, string title, SetupState state, string text)
        {
            SetupCheck check = SetupChecks.Of(facts).Single(found => found.Title == title);
            Assert.That(check.State, Is.EqualTo(state), check.Text);
            Assert.That(check.Text, Does.Contain(text));
        }
    }
}
