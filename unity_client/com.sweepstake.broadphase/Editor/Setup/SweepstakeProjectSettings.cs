#nullable enable
using Sweepstake.Unity;
using UnityEditor;
using UnityEngine;

namespace Sweepstake.Editor
{
    /// <summary>What the editor keeps for the project, in ProjectSettings: the config that new managers get, and that the window asks the daemon of.</summary>
    [FilePath("ProjectSettings/SweepstakeSettings.asset", FilePathAttribute.Location.ProjectFolder)]
    internal sealed class SweepstakeProjectSettings : ScriptableSingleton<SweepstakeProjectSettings>
    {
        internal const string File = "ProjectSettings/SweepstakeSettings.asset";

        [SerializeField]
        [Tooltip("The config that a new manager gets. None: the defaults.")]
        private SweepstakeConfig? defaultConfig;

        internal SweepstakeConfig? DefaultConfig
        {
            get => defaultConfig;
            set
            {
                defaultConfig = value;
                Save(true);
            }
        }

        internal SweepstakeConfig ConfigOrDefault() => defaultConfig != null ? defaultConfig : CreateInstance<SweepstakeConfig>();
    }
}
