using System.IO;
using System.Linq;
using NUnit.Framework;
using Sweepstake.Editor;
using UnityEditor.PackageManager;
using UnityEngine;
using UnityEngine.UIElements;

namespace Sweepstake.Tests
{
    /// <summary>Tests what Setup offers to a project without the native library.</summary>
    public sealed class LibraryRemedyTest
    {
        private const string Repository = "https://example.org/games/sweepstake.git";
        private const string Name = "com.sweepstake.broadphase@";
        private static readonly NativeLibraryException Missing = new NativeLibraryException("It is missing.", "Get it.");

        [TestCase("?path=/unity_client/com.sweepstake.broadphase")]
        [TestCase("?path=/unity_client/com.sweepstake.broadphase#main")]
        [TestCase("#v0.1.0")]
        [TestCase("")]
        public void APackageFromAGitUrlTakesTheReleaseOrBuildsACloneOfTheSameRepository(string rest)
        {
            var remedy = new LibraryRemedy(Name + Repository + rest, "/game/Library/PackageCache/com.sweepstake.broadphase", "/my game/Assets/Plugins", true);
            Assert.That(remedy.ReleaseUrl, Is.EqualTo(Repository + "#upm"));
            Assert.That(remedy.BuildCommand, Is.EqualTo($"git clone {Repository} sweepstake && sweepstake/unity_client/tools/build_plugin.sh \"/my game/Assets/Plugins\""));
        }

        [Test]
        public void APackageInACheckoutIsBuiltByTheScriptThatIsThere()
        {
            string package = EditorTest.PackageFolder();
            var remedy = new LibraryRemedy(Name + "file:" + package, package, "/game/Assets/Plugins", true);
            Assert.That((remedy.ReleaseUrl, File.Exists(remedy.BuildCommand.Trim('"'))), Is.EqualTo(("", true)), remedy.BuildCommand);
            remedy = new LibraryRemedy(Name + "file:/packages/sweepstake.tgz", "/game/Library/PackageCache/com.sweepstake.broadphase", "/game/Assets/Plugins", true);
            Assert.That((remedy.ReleaseUrl, remedy.BuildCommand), Is.EqualTo(("", "")));
        }

        [Test]
        public void AnEditorOnAnotherSystemOffersTheReleaseAndNoCommandForLinux()
        {
            var remedy = new LibraryRemedy(Name + Repository, "/game/Library/PackageCache/com.sweepstake.broadphase", "/game/Assets/Plugins", false);
            Assert.That((remedy.ReleaseUrl, remedy.BuildCommand), Is.EqualTo((Repository + "#upm", "")));
            string package = EditorTest.PackageFolder();
            remedy = new LibraryRemedy(Name + "file:" + package, package, "/game/Assets/Plugins", false);
            Assert.That((remedy.ReleaseUrl, remedy.BuildCommand), Is.EqualTo(("", "")));
        }

        [Test]
        public void SetupOffersTheRemediesInOneClickOnlyIfTheLibraryHasAProblem()
        {
            PackageInfo.Install(Name + Repository + "#main", "/game/Library/PackageCache/com.sweepstake.broadphase");
            var fine = new VisualElement();
            LibraryRemedy.AddTo(fine, null);
            Assert.That(fine.Children(), Is.Empty);
            var lacking = new VisualElement();
            LibraryRemedy.AddTo(lacking, Missing);
            Button[] buttons = lacking.Children().Single().Children().Cast<Button>().ToArray();
            Assert.That(buttons.Select(button => button.text), Is.EqualTo(new[] { "Take the Release", "Copy Build Command", "Platforms" }));
            buttons[0].Click();
            Assert.That(Client.Added, Is.EqualTo(Repository + "#upm"));
            buttons[1].Click();
            Assert.That(GUIUtility.systemCopyBuffer, Does.StartWith("git clone " + Repository));
        }
    }
}
