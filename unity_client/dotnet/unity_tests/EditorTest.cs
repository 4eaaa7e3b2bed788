using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using System.Reflection;
using System.Runtime.CompilerServices;
using System.Text.RegularExpressions;
using System.Xml.Linq;
using NUnit.Framework;
using Sweepstake.Editor;
using Sweepstake.Samples;
using Sweepstake.Unity;
using UnityEditor;
using UnityEditor.Build;
using UnityEngine;
using UnityEngine.UIElements;

namespace Sweepstake.Tests
{
    public sealed class EditorTest : Stage
    {
        private const BindingFlags All = BindingFlags.Instance | BindingFlags.Static | BindingFlags.NonPublic | BindingFlags.Public;

        [Test]
        public void ChartsDrawWhateverTheSeriesHas()
        {
            Painter2D.BadPointCount = 0;
            foreach (Series series in new[] { new Series(), SeriesOf(float.NaN), SeriesOf(1), SeriesOf(1, float.NaN, 2, float.PositiveInfinity), SeriesOf(0, 0, 0) })
            {
                new LineChart("Detection", "ms").Show(series);
                var backends = new BackendChart();
                backends.Name(new[] { "SAP", "DBVT" });
                backends.Show(SeriesOf(0, 0, 1, 1, 0));
            }
            Assert.That(Painter2D.BadPointCount, Is.EqualTo(0));
            var legend = new BackendChart();
            legend.Name(new[] { "SAP", "DBVT" });
            legend.Name(new[] { "SAP", "KDTree" });
            Assert.That(Texts(legend).Where(text => text.StartsWith('■')), Is.EqualTo(new[] { "■ SAP", "■ KDTree" }), "the legend shows the backends of the current game");
            Assert.That(Texts(new LineChart("Detection", "ms")), Has.Some.EqualTo("Detection (ms)").And.Some.Contains("60 s"), "the axes have units");
        }

        [Test]
        public void TheWindowShowsAGameAndKeepsItWhenPlayModeEnds()
        {
            SweepstakeManager manager = MakeManager();
            manager.gameObject.AddComponent<ScenarioPlayer>().ObjectCount = 50;
            var window = ScriptableObject.CreateInstance<SweepstakeWindow>();
            Call(window, "CreateGUI");
            for (int tick = 0; tick < 20; ++tick)
            {
                Frames(6);
                Call(window, "Tick");
            }
            var history = (LiveHistory)window.GetType().GetField("history", All)!.GetValue(window);
            Assert.That(history!.Pairs.Count, Is.EqualTo(20));
            Assert.That(history.Fps[19], Is.EqualTo(60).Within(1));
            Assert.That(history.Backends, Is.EqualTo(SweepstakeLibrary.Backends));
            Assert.That(Texts(window.rootVisualElement), Has.Some.Contains("Offline (embedded)"));
            Player.Stop();
            Application.isPlaying = false;
            Call(window, "Tick");
            Application.isPlaying = true;
            Assert.That(history.Pairs.Count, Is.EqualTo(20));
            Assert.That(Texts(window.rootVisualElement), Has.Some.Contains("Enter play mode"));
            Call(window, "OnDisable");
        }

        [Test]
        public void TheInspectorShowsStateReasonAndWhatMayBeDone()
        {
            SweepstakeManager manager = MakeManager(config => config.daemon.address = "127.0.0.1:9");
            manager.gameObject.AddComponent<ScenarioPlayer>().ObjectCount = 50;
            Frames(3);
            SweepstakeManagerEditor inspector = InspectorOf(manager);
            VisualElement root = inspector.CreateInspectorGUI();
            Assert.That(Texts(root), Has.Some.EqualTo("Offline (embedded)").And.Some.Contains("Decision: ").And.Some.EqualTo("Connect"));
            Call(inspector, "ToggleConnection");
            Assert.That(Texts(root), Has.Some.EqualTo("Disconnect"));
            Call(inspector, "ToggleConnection");
            Assert.That(Texts(root), Has.Some.EqualTo("Connect"));
        }

        [Test]
        public void PriorsAreExportedOrTheReasonIsTold()
        {
            SweepstakeManager manager = MakeManager(config => config.daemon.address = "127.0.0.1:9");
            SweepstakeManagerEditor inspector = InspectorOf(manager);
            string path = Path.GetTempFileName();
            EditorUtility.ChosenFile = path;
            Call(inspector, "Export");
            Assert.That(File.ReadAllBytes(path), Is.EqualTo(manager.Decider.ExportPriors()));
            EditorUtility.ChosenFile = Path.Combine(path, "priors.bytes");
            Call(inspector, "Export");
            Assert.That(EditorUtility.LastMessage, Does.Contain("not exported").And.Contain(path), "the path of a file cannot be used as a folder");
            EditorUtility.ChosenFile = "";
            File.Delete(path);

            KillDecider(manager);
            Call(inspector, "Export");
            Assert.That(EditorUtility.LastMessage, Does.Contain("not exported").And.Contain(manager.Decider.Failure.Message));
            manager.Connect();
            Call(inspector, "Export");
            Assert.That(EditorUtility.LastMessage, Does.Contain("A daemon stores"));
        }

        private static SweepstakeManagerEditor InspectorOf(SweepstakeManager manager)
        {
            var inspector = ScriptableObject.CreateInstance<SweepstakeManagerEditor>();
            inspector.target = manager;
            return inspector;
        }

        [Test]
        public void TheSetupLooksForWhatIsReallyLoadedAndLinksWhatIsMissing()
        {
            var window = ScriptableObject.CreateInstance<SetupWindow>();
            Call(window, "CreateGUI");
            Assert.That(SetupChecks.MissingLibraries(new SetupFacts { IsLoaded = SetupWindow.CanLoad }), Is.Empty, "the libraries of this process");
            Assert.That(SetupWindow.CanLoad(SetupChecks.Handler), Is.False, "this process does not have it");
            Assert.That(Texts(window.rootVisualElement), Has.None.EqualTo("NuGetForUnity Page"));
            Assert.That(Texts(window.rootVisualElement), Has.Some.EqualTo("YetAnotherHttpHandler Page").And.Some.EqualTo("Copy Git URL"));
            window.IsLoaded = assembly => false;
            Call(window, "Refresh");
            Assert.That(Texts(window.rootVisualElement), Has.Some.EqualTo("NuGetForUnity Page").And.Some.EqualTo("UnityNuGet Page"));
        }

        [Test]
        public void TheDefineIsSetOnlyWithItsLibrariesAndIsGoneAfterTheCleanup()
        {
            var window = ScriptableObject.CreateInstance<SetupWindow>();
            window.IsLoaded = assembly => false;
            Call(window, "CreateGUI");
            NamedBuildTarget chosen = NamedBuildTarget.FromBuildTargetGroup(EditorUserBuildSettings.selectedBuildTargetGroup);
            PlayerSettings.SetScriptingDefineSymbols(chosen, "OTHER");
            PlayerSettings.SetScriptingDefineSymbols(NamedBuildTarget.Android, "SWEEPSTAKE_GRPC;OTHER");
            Call(window, "Define", true);
            Assert.That(PlayerSettings.GetScriptingDefineSymbols(chosen), Is.EqualTo("OTHER"), "without the libraries the define is not set");
            window.IsLoaded = assembly => true;
            Call(window, "Define", true);
            Assert.That(PlayerSettings.GetScriptingDefineSymbols(chosen), Is.EqualTo("OTHER;SWEEPSTAKE_GRPC"));
            Call(window, "CleanUp");
            Assert.That(PlayerSettings.GetScriptingDefineSymbols(chosen), Is.EqualTo("OTHER"));
            Assert.That(PlayerSettings.GetScriptingDefineSymbols(NamedBuildTarget.Android), Is.EqualTo("OTHER"), "the define of another platform is removed too");
        }

        [Test]
        public void MenusMakeAManagerAndATracker()
        {
            ObjectMenu.MakeManager(new MenuCommand(null));
            Assert.That(Selection.activeGameObject.GetComponent<SweepstakeManager>(), Is.Not.Null);
            ObjectMenu.MakeTracker(new MenuCommand(null));
            Assert.That(Selection.activeGameObject.GetComponent<ColliderTracker>(), Is.Not.Null);
        }

        [Test]
        public void TheHudShowsAGame()
        {
            GameObject game = MakeManager().gameObject;
            game.AddComponent<ScenarioPlayer>();
            var hud = game.AddComponent<SweepstakeHud>();
            Frames(30);
            Assert.That(hud.Text, Does.Contain("3000 objects"));
            Player.CallAll("OnGUI");
        }

        [Test]
        public void TheSetupFindsTheLibraryOfTheChosenPlatform()
        {
            var window = ScriptableObject.CreateInstance<SetupWindow>();
            Call(window, "CreateGUI");
            try
            {
                EditorUserBuildSettings.activeBuildTarget = BuildTarget.Android;
                Call(window, "Refresh");
                Assert.That(Boxes(window.rootVisualElement), Has.Some.Contains("no native library for Android"));
                Assert.That(Texts(window.rootVisualElement), Has.Some.EqualTo("Native Library Page"));
                PluginImporter.Plugins.Add(("Assets/Plugins/libother.so", BuildTarget.Android));
                PluginImporter.Plugins.Add(("Packages/com.sweepstake.broadphase/Runtime/Plugins/windows-x86_64/sweepstake.dll", BuildTarget.StandaloneWindows64));
                Call(window, "Refresh");
                Assert.That(Boxes(window.rootVisualElement), Has.Some.Contains("no native library for Android"), "neither another plug-in nor that of another platform");
                PluginImporter.Plugins.Add(("Assets/Plugins/libsweepstake.so", BuildTarget.Android));
                Call(window, "Refresh");
                Assert.That(Boxes(window.rootVisualElement), Has.Some.Contains("has the native library for Android"));
            }
            finally
            {
                PluginImporter.Plugins.Clear();
                EditorUserBuildSettings.activeBuildTarget = BuildTarget.StandaloneLinux64;
            }
        }

        [Test]
        public void TheLinkersFileIsWellFormedAndNamesAssembliesThatExist()
        {
            XElement linker = XElement.Parse(LinkerProcessor.Xml);
            Assert.That(linker.Elements().Select(assembly => (string)assembly.Attribute("preserve")), Is.All.EqualTo("all"));
            Assert.That(linker.Elements().Select(assembly => (string)assembly.Attribute("fullname")), Is.EqualTo(new[] { typeof(SweepstakeLibrary).Assembly.GetName().Name }));
            string before = Directory.GetCurrentDirectory();
            DirectoryInfo folder = Directory.CreateTempSubdirectory("sweepstake");
            Directory.SetCurrentDirectory(folder.FullName);
            try
            {
                Assert.That(File.ReadAllText(new LinkerProcessor().GenerateAdditionalLinkXmlFile(null, null)), Is.EqualTo(LinkerProcessor.Xml));
            }
            finally
            {
                Directory.SetCurrentDirectory(before);
                folder.Delete(true);
            }
        }

        [Test]
        public void TheDrawerAcceptsAnyTextAndOffersTheBackends()
        {
            IReadOnlyList<string> names = SweepstakeLibrary.Backends;
            VisualElement row = new BackendNameDrawer().CreatePropertyGUI(new SerializedProperty { tooltip = "A name." });
            TextField text = row.Children().OfType<TextField>().Single();
            DropdownField choice = row.Children().OfType<DropdownField>().Single();
            Assert.That((text.tooltip, choice.choices), Is.EqualTo(("A name.", names)));
            text.value = "KdTree";
            Assert.That(text.value, Is.EqualTo("KdTree"));
            choice.value = names[1];
            Assert.That((text.value, choice.value), Is.EqualTo((names[1], "")));
            text.value = "KdTree";
            choice.value = names[1];
            Assert.That(text.value, Is.EqualTo(names[1]), "chosen again");
        }

        [Test]
        public void EachFieldOfTheInspectorHasATooltipAndEachComponentAPageThatExists()
        {
            foreach (Type type in Ours().Where(type => typeof(MonoBehaviour).IsAssignableFrom(type) || typeof(SweepstakeConfig) == type || (type.Namespace == "Sweepstake.Unity" && type.Name.EndsWith("Settings"))))
            {
                foreach (FieldInfo field in type.GetFields(All).Where(IsOfInspector))
                    Assert.That(field.GetCustomAttribute<TooltipAttribute>()?.tooltip, Does.EndWith("."), $"{type.Name}.{field.Name} has no tooltip");
            }
            string documents = Path.Combine(PackageFolder(), "Documentation~");
            foreach (Type type in Ours().Where(type => type.Namespace != "Sweepstake.Samples" && typeof(MonoBehaviour).IsAssignableFrom(type) || typeof(EditorWindow).IsAssignableFrom(type) || type == typeof(SweepstakeConfig)))
            {
                var page = type.GetCustomAttribute<DocumentationPageAttribute>();
                Assert.That(page, Is.Not.Null, $"{type.Name} has no page");
                Assert.That(File.Exists(Path.Combine(documents, page!.Page)), Is.True, page.Page);
                Assert.That(page.URL, Does.StartWith("file:///").And.EndsWith(page.Page));
            }
        }

        [Test]
        public void EachMenuThatTheDocumentsNameExists()
        {
            var menus = Ours().SelectMany(type => type.GetMethods(All)).SelectMany(method => method.GetCustomAttributes<MenuItem>()).Select(menu => menu.menuItem).ToList();
            menus.Add("Project Settings/Sweepstake");
            int found = 0;
            foreach (string document in Directory.GetFiles(Path.Combine(PackageFolder(), "Documentation~"), "*.md"))
            {
                string text = Regex.Replace(File.ReadAllText(document), @"\s+", " ");
                foreach (Match named in Regex.Matches(text, @"\*((?:Window|GameObject|Project Settings) > Sweepstake[^*]*)\*"))
                {
                    string path = named.Groups[1].Value.Replace(" > ", "/");
                    Assert.That(menus.Exists(menu => path == menu || path.StartsWith(menu + "/")), Is.True, $"{Path.GetFileName(document)}: {path}");
                    ++found;
                }
            }
            Assert.That(found, Is.GreaterThan(10));
        }

        [Test]
        public void EachClassThatTheStyleSheetIsAskedForIsInIt()
        {
            string sheet = File.ReadAllText(Path.Combine(PackageFolder(), "Editor/Sweepstake.uss"));
            foreach (string source in Directory.GetFiles(Path.Combine(PackageFolder(), "Editor"), "*.cs", SearchOption.AllDirectories))
            {
                foreach (Match used in Regex.Matches(File.ReadAllText(source), "\"(sweepstake-[a-z-]+[a-z])\""))
                    Assert.That(sheet, Does.Contain("." + used.Groups[1].Value), source);
            }
            Assert.That(sheet, Does.Contain("var(--unity-colors-"), "the colours come from the theme");
        }

        private static IEnumerable<Type> Ours() => typeof(EditorTest).Assembly.GetTypes().Where(type =>
            type.Namespace is "Sweepstake.Unity" or "Sweepstake.Editor" or "Sweepstake.Samples");

        private static bool IsOfInspector(FieldInfo field) =>
            !field.IsStatic && !field.IsInitOnly && (field.GetCustomAttribute<SerializeField>() != null || (field.IsPublic && !typeof(Delegate).IsAssignableFrom(field.FieldType)));

        private static Series SeriesOf(params float[] values)
        {
            var series = new Series();
            foreach (float value in values)
                series.Add(value);
            return series;
        }

        private static void Call(object owner, string method, params object[] arguments) => owner.GetType().GetMethod(method, All)!.Invoke(owner, arguments);

        private static IEnumerable<string> Boxes(VisualElement root) =>
            root.Children().SelectMany(child => child is HelpBox box ? new[] { box.text } : Boxes(child));

        private static IEnumerable<string> Texts(VisualElement root)
        {
            foreach (VisualElement child in root.Children())
            {
                if (child is TextElement text)
                    yield return text.text;
                foreach (string below in Texts(child))
                    yield return below;
            }
        }

        /// <summary>The package's folder, found from this source file, so that it does not depend on the build folder.</summary>
        internal static string PackageFolder([CallerFilePath] string thisFile = "") =>
            Path.GetFullPath(Path.Combine(Path.GetDirectoryName(thisFile)!, "../../com.sweepstake.broadphase"));
    }
}
