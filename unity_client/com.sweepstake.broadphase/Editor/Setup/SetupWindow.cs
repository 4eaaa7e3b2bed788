#nullable enable
using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using System.Reflection;
using Sweepstake.Unity;
using UnityEditor;
using UnityEditor.Build;
using UnityEditor.Compilation;
using UnityEngine;
using UnityEngine.UIElements;

namespace Sweepstake.Editor
{
    /// <summary>
    /// Shows which parts are missing and how to get them, sets the define SWEEPSTAKE_GRPC, and cleans up before the package is removed.
    /// </summary>
    [DocumentationPage("setup.md")]
    internal sealed class SetupWindow : EditorWindow
    {
        /// <summary>The platforms for which a native library can exist.</summary>
        private static readonly NamedBuildTarget[] Targets =
        {
            NamedBuildTarget.Standalone, NamedBuildTarget.Server, NamedBuildTarget.EmbeddedLinux, NamedBuildTarget.Android, NamedBuildTarget.iOS,
        };

        private VisualElement? checks;

        /// <summary>Tests replace it.</summary>
        internal Func<string, bool> IsLoaded { get; set; } = CanLoad;

        [MenuItem(PackagePaths.MenuRoot + "Setup", priority = 2)]
        internal static void Open()
        {
            SetupWindow window = GetWindow<SetupWindow>();
            window.titleContent = new GUIContent("Sweepstake Setup");
            window.minSize = new Vector2(320, 240);
        }

        [MenuItem(PackagePaths.MenuRoot + "Documents", priority = 3)]
        internal static void OpenDocuments() => PackagePaths.OpenPage("index.md");

        private void CreateGUI()
        {
            var scroll = new ScrollView();
            PackagePaths.AddStyle(scroll);
            rootVisualElement.Add(scroll);
            checks = new VisualElement();
            scroll.Add(checks);
            var buttons = new VisualElement();
            buttons.AddToClassList("sweepstake-row");
            buttons.Add(new Button(Refresh) { text = "Check Again" });
            buttons.Add(new Button(() => Define(true)) { text = "Set Define", tooltip = $"Sets {SetupChecks.GrpcDefine} for the platform of the build settings, if gRPC's libraries are installed." });
            buttons.Add(new Button(() => Define(false)) { text = "Remove Define" });
            buttons.Add(new Button(CleanUp) { text = "Clean Up", tooltip = "Use it before you remove the package: removes the package's project settings, and the define for all platforms that may have the native library and for the platform of the build settings." });
            scroll.Add(buttons);
            Refresh();
        }

        private void OnFocus() => Refresh();

        private void Refresh()
        {
            if (checks == null)
                return;
            checks.Clear();
            LibraryRemedy.AddTo(checks, SweepstakeLibrary.FindProblem());
            foreach (SetupCheck check in SetupChecks.Of(Facts()))
            {
                HelpBoxMessageType kind = check.State == SetupState.Ok ? HelpBoxMessageType.None :
                    check.State == SetupState.Optional ? HelpBoxMessageType.Info : HelpBoxMessageType.Error;
                checks.Add(new HelpBox($"{check.Title}: {check.Text}", kind));
                foreach (SetupLink link in check.Links)
                    checks.Add(RowOf(link));
            }
        }

        private static VisualElement RowOf(SetupLink link)
        {
            var row = new VisualElement();
            row.AddToClassList("sweepstake-row");
            row.Add(new Button(() => Application.OpenURL(link.Page)) { text = $"{link.Name} Page", tooltip = link.Page });
            if (link.GitUrl.Length > 0)
                row.Add(new Button(() => GUIUtility.systemCopyBuffer = link.GitUrl) { text = "Copy Git URL", tooltip = link.GitUrl });
            return row;
        }

        /// <summary>Whether the editor has loaded an assembly or can load it.</summary>
        internal static bool CanLoad(string assembly)
        {
            try
            {
                return Assembly.Load(assembly) != null;
            }
            catch (Exception problem) when (problem is IOException || problem is BadImageFormatException)
            {
                return false;
            }
        }

        private void Define(bool isSet)
        {
            if (isSet && SetupChecks.MissingLibraries(Facts()).Count > 0)
            {
                EditorUtility.DisplayDialog("Sweepstake", "Install gRPC's libraries first; without them the define causes errors.", "OK");
                return;
            }
            SetDefine(Target, isSet);
            Refresh();
        }

        private void CleanUp()
        {
            foreach (NamedBuildTarget target in Targets.Append(Target))
                SetDefine(target, false);
            FileUtil.DeleteFileOrDirectory(SweepstakeProjectSettings.File);
            FileUtil.DeleteFileOrDirectory(LinkerProcessor.Folder);
            Refresh();
        }

        private SetupFacts Facts() => new SetupFacts
        {
            LibraryProblem = SweepstakeLibrary.FindProblem(),
            Platform = EditorUserBuildSettings.activeBuildTarget,
            HasPlatformLibrary = PluginImporter.GetImporters(EditorUserBuildSettings.activeBuildTarget).Any(plugin => SetupChecks.IsLibrary(plugin.assetPath)),
            HasArchiveDefine = Defines(NamedBuildTarget.iOS).Contains(SetupChecks.ArchiveDefine),
            HasGrpcDefine = Defines(Target).Contains(SetupChecks.GrpcDefine),
            IsLoaded = IsLoaded,
            PrecompiledAssemblies = CompilationPipeline.GetPrecompiledAssemblyNames(),
#if UNITY_6000_5_OR_NEWER
            HasHttpHandlerOfUnity = true,
#endif
        };

        private static NamedBuildTarget Target => NamedBuildTarget.FromBuildTargetGroup(EditorUserBuildSettings.selectedBuildTargetGroup);

        private static List<string> Defines(NamedBuildTarget target) =>
            PlayerSettings.GetScriptingDefineSymbols(target).Split(new[] { ';' }, StringSplitOptions.RemoveEmptyEntries).ToList();

        private static void SetDefine(NamedBuildTarget target, bool isSet)
        {
            List<string> defines = Defines(target);
            if (defines.Contains(SetupChecks.GrpcDefine) == isSet)
                return;
            if (isSet)
                defines.Add(SetupChecks.GrpcDefine);
            else
                defines.Remove(SetupChecks.GrpcDefine);
            PlayerSettings.SetScriptingDefineSymbols(target, string.Join(";", defines));
        }
    }
}
