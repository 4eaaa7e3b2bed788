using System.Collections.Generic;
using UnityEngine.Events;

namespace UnityEngine.Events
{
    public delegate void UnityAction<T0, T1>(T0 arg0, T1 arg1);
}

namespace UnityEngine.SceneManagement
{
    public enum LoadSceneMode
    {
        Single,
        Additive,
    }

    internal sealed class SceneContent
    {
        internal List<GameObject> Roots { get; } = new List<GameObject>();
    }

    public struct Scene
    {
        internal SceneContent Content { get; set; }

        public string name { get; set; }
        public bool isLoaded => Content != null;

        public void GetRootGameObjects(List<GameObject> rootGameObjects)
        {
            rootGameObjects.Clear();
            rootGameObjects.AddRange(Content.Roots);
        }
    }

    public class SceneManager
    {
        internal static List<Scene> Loaded { get; } = new List<Scene> { Made("level") };
        internal static Scene Active { get; private set; } = Loaded[0];

        /// <summary>The scene of DontDestroyOnLoad objects, which is not one of the loaded scenes.</summary>
        internal static Scene Lasting { get; } = Made("DontDestroyOnLoad");

        public static int sceneCount => Loaded.Count;

        public static event UnityAction<Scene, LoadSceneMode> sceneLoaded;

        public static Scene GetSceneAt(int index) => Loaded[index];

        /// <summary>Loads a scene additively; new objects belong to it.</summary>
        internal static Scene Add(string name)
        {
            Active = Made(name);
            Loaded.Add(Active);
            return Active;
        }

        internal static void SayLoaded(Scene scene) => sceneLoaded?.Invoke(scene, LoadSceneMode.Additive);

        internal static void Reset()
        {
            Loaded.RemoveRange(1, Loaded.Count - 1);
            Active = Loaded[0];
        }

        private static Scene Made(string name) => new Scene { name = name, Content = new SceneContent() };
    }
}
