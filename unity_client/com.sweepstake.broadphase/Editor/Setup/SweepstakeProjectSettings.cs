#nullable enable
using Sweepstake.Unity;
using UnityEditor;
using UnityEngine;

namespace Sweepstake.Editor
{
    /// <summary>
    /// The package's editor settings for the project, stored in ProjectSettings: the config that new managers get. The live window reads
    /// posteriors from the daemon of this config.
    /// </summary>
    [FilePath("ProjectSettings/SweepstakeSettings.asset", FilePathAttribute.Location.ProjectFolder)]
    internal sealed class SweepstakeProjectSettings : ScriptableSingleton<SweepstakeProjectSettings>
    {
        internal const string File = "ProjectSettings/SweepstakeSettings.asset";

        [SerializeField]
        [Tooltip("The config of new managers. None: the defaults.")]
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
