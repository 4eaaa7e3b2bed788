#nullable enable
using System.IO;
using System.Runtime.InteropServices;
using UnityEditor.PackageManager;
using UnityEngine;
using UnityEngine.UIElements;
using PackageInfo = UnityEditor.PackageManager.PackageInfo;

namespace Sweepstake.Editor
{
    /// <summary>
    /// How a project without the native library gets it: from the release, or by one command that builds it on this machine. The main branch
    /// of the repository has no library; its branch `upm` has the package with the libraries of the latest release.
    /// </summary>
    internal sealed class LibraryRemedy
    {
        internal const string ReleaseBranch = "upm";
        internal const string Script = "unity_client/tools/build_plugin.sh";

        /// <param name="packageId">Name and source of the package, as the Package Manager has them: name@source.</param>
        /// <param name="packageFolder">The folder of the package on this machine.</param>
        /// <param name="pluginFolder">The project's own folder of plug-ins.</param>
        /// <param name="isLinux">Whether the editor runs on Linux. The command builds the library for Linux only.</param>
        internal LibraryRemedy(string packageId, string packageFolder, string pluginFolder, bool isLinux)
        {
            string repository = RepositoryOf(packageId);
            string checkout = Path.GetFullPath(Path.Combine(packageFolder, "../.."));
            if (repository.Length > 0)
                ReleaseUrl = $"{repository}#{ReleaseBranch}";
            if (!isLinux)
                return;
            if (repository.Length > 0)
                BuildCommand = $"git clone {repository} sweepstake && sweepstake/{Script} \"{pluginFolder}\"";
            else if (File.Exists(Path.Combine(checkout, Script)))
                BuildCommand = $"\"{Path.Combine(checkout, Script)}\"";
        }

        /// <summary>The git URL of the release; "" if the package was not installed from a git URL.</summary>
        internal string ReleaseUrl { get; } = "";
        /// <summary>A command for a shell on Linux; "" on other systems, or if the package is neither from a git URL nor in a checkout of the repository.</summary>
        internal string BuildCommand { get; } = "";

        /// <summary>Adds a button for each remedy, if the library has a problem.</summary>
        internal static void AddTo(VisualElement parent, NativeLibraryException? problem)
        {
            PackageInfo? package = PackageInfo.FindForAssembly(typeof(SweepstakeLibrary).Assembly);
            if (problem == null || package == null)
                return;
            var remedy = new LibraryRemedy(
                package.packageId, package.resolvedPath, Path.GetFullPath("Assets/Plugins"), RuntimeInformation.IsOSPlatform(OSPlatform.Linux));
            var row = new VisualElement();
            row.AddToClassList("sweepstake-row");
            if (remedy.ReleaseUrl.Length > 0)
            {
                row.Add(new Button(() => Client.Add(remedy.ReleaseUrl))
                {
                    text = "Take the Release", tooltip = $"Replaces this package by {remedy.ReleaseUrl}, which contains the libraries.",
                });
            }
            if (remedy.BuildCommand.Length > 0)
            {
                row.Add(new Button(() => GUIUtility.systemCopyBuffer = remedy.BuildCommand)
                {
                    text = "Copy Build Command", tooltip = $"For a shell on Linux. Quit the editor, run it, and open the project again: {remedy.BuildCommand}",
                });
            }
            row.Add(new Button(() => PackagePaths.OpenPage("native-library.md")) { text = "Platforms", tooltip = "The page about the native library: platforms, and builds for other systems." });
            parent.Add(row);
        }

        private static string RepositoryOf(string packageId)
        {
            string source = packageId.Substring(packageId.IndexOf('@') + 1);
            int end = source.IndexOfAny(new[] { '?', '#' });
            string address = end < 0 ? source : source.Substring(0, end);
            return address.EndsWith(".git", System.StringComparison.Ordinal) ? address : "";
        }
    }
}
