#nullable enable
using Sweepstake.Unity;
using UnityEditor;
using UnityEditor.UIElements;
using UnityEngine;
using UnityEngine.UIElements;

namespace Sweepstake.Editor
{
    /// <summary>The page Project Settings > Sweepstake.</summary>
    internal static class SweepstakeSettingsProvider
    {
        internal const string Path = "Project/Sweepstake";
        private const string NewConfig = "Assets/SweepstakeConfig.asset";

        [SettingsProvider]
        internal static SettingsProvider Create() => new SettingsProvider(Path, SettingsScope.Project)
        {
            label = "Sweepstake",
            keywords = new[] { "Sweepstake", "broad phase", "collision", "daemon", "gRPC", "TLS", "backend", "AI Decides", "cooldown", "priors", "telemetry" },
            activateHandler = (_, root) => Build(root),
        };

        private static void Build(VisualElement root)
        {
            PackagePaths.AddStyle(root);
            var title = new Label("Sweepstake");
            title.AddToClassList("sweepstake-title");
            var settings = new VisualElement();
            var config = new ObjectField("Default Config")
            {
                objectType = typeof(SweepstakeConfig), allowSceneObjects = false, value = SweepstakeProjectSettings.instance.DefaultConfig,
                tooltip = "The config of new Sweepstake Managers. The live window reads the posteriors of its daemon. None: the defaults, and no daemon.",
            };
            config.RegisterValueChangedCallback(changed =>
            {
                SweepstakeProjectSettings.instance.DefaultConfig = (SweepstakeConfig?)changed.newValue;
                ShowConfig(settings);
            });
            var make = new Button(() => config.value = MakeConfig()) { text = "New Config", tooltip = $"Creates {NewConfig} with the defaults." };
            foreach (VisualElement part in new VisualElement[] { title, config, make, new Button(SetupWindow.Open) { text = "Setup…" }, settings })
                root.Add(part);
            ShowConfig(settings);
        }

        private static void ShowConfig(VisualElement root)
        {
            root.Clear();
            SweepstakeConfig? config = SweepstakeProjectSettings.instance.DefaultConfig;
            if (config != null)
                root.Add(new InspectorElement(config));
        }

        private static SweepstakeConfig MakeConfig()
        {
            var config = ScriptableObject.CreateInstance<SweepstakeConfig>();
            AssetDatabase.CreateAsset(config, AssetDatabase.GenerateUniqueAssetPath(NewConfig));
            AssetDatabase.SaveAssets();
            return config;
        }
    }
}
