#nullable enable
using Sweepstake.Unity;
using UnityEditor;

namespace Sweepstake.Editor
{
    /// <summary>Ends the native objects before a domain reload, at the end of play mode, and when the editor quits.</summary>
    [InitializeOnLoad]
    internal static class EditorLifetime
    {
        static EditorLifetime()
        {
            AssemblyReloadEvents.beforeAssemblyReload += SweepstakeManager.Shutdown;
            EditorApplication.quitting += SweepstakeManager.Shutdown;
            EditorApplication.playModeStateChanged += change =>
            {
                if (change == PlayModeStateChange.EnteredEditMode)
                    SweepstakeManager.Shutdown();
            };
        }
    }
}
