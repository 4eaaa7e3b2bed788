#nullable enable
using Sweepstake.Unity;
using UnityEditor;
using UnityEngine;

namespace Sweepstake.Editor
{
    /// <summary>Menu items that create objects.</summary>
    internal static class ObjectMenu
    {
        [MenuItem("GameObject/Sweepstake/Manager", false, 10)]
        internal static void MakeManager(MenuCommand command) => Make("Sweepstake Manager", command.context as GameObject);

        [MenuItem("GameObject/Sweepstake/Collider Tracker", false, 11)]
        internal static void MakeTracker(MenuCommand command) =>
            Make("Sweepstake Collider Tracker", command.context as GameObject).AddComponent<ColliderTracker>();

        private static GameObject Make(string name, GameObject? parent)
        {
            var made = new GameObject(name);
            made.AddComponent<SweepstakeManager>().Config = SweepstakeProjectSettings.instance.DefaultConfig;
            GameObjectUtility.SetParentAndAlign(made, parent);
            Undo.RegisterCreatedObjectUndo(made, "Create " + name);
            Selection.activeGameObject = made;
            return made;
        }
    }
}
