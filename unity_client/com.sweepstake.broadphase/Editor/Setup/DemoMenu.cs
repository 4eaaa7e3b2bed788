#nullable enable
using Sweepstake.Unity;
using UnityEditor;
using UnityEditor.SceneManagement;
using UnityEngine;

namespace Sweepstake.Editor
{
    /// <summary>Menu items that create objects and a demo scene.</summary>
    internal static class DemoMenu
    {
        [MenuItem("GameObject/Sweepstake/Manager", false, 10)]
        internal static void MakeManager(MenuCommand command) => Make("Sweepstake Manager", command.context as GameObject);

        [MenuItem("GameObject/Sweepstake/Collider Tracker", false, 11)]
        internal static void MakeTracker(MenuCommand command) =>
            Make("Sweepstake Collider Tracker", command.context as GameObject).AddComponent<ColliderTracker>();

        /// <summary>Creates a scene with a camera, a light and a scenario.</summary>
        [MenuItem(PackagePaths.MenuRoot + "New Demo Scene", priority = 4)]
        internal static void MakeDemoScene()
        {
            if (!EditorSceneManager.SaveCurrentModifiedScenesIfUserWantsTo())
                return;
            EditorSceneManager.NewScene(NewSceneSetup.DefaultGameObjects, NewSceneMode.Single);
            GameObject demo = Make("Sweepstake Demo", null);
            demo.AddComponent<ScenarioPlayer>();
            demo.AddComponent<PairGizmos>();
            demo.AddComponent<SweepstakeHud>();
            Camera camera = Camera.main;
            if (camera == null)
                return;
            camera.transform.position = new Vector3(0, 70, -110);
            camera.transform.LookAt(Vector3.zero);
        }

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
