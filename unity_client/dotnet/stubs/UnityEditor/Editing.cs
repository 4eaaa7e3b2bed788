using System;
using System.Collections.Generic;
using System.Linq;
using UnityEngine;
using UnityEngine.UIElements;
using Object = UnityEngine.Object;

namespace UnityEditor
{
    [AttributeUsage(AttributeTargets.Class)]
    public class InitializeOnLoadAttribute : Attribute
    {
    }

    [AttributeUsage(AttributeTargets.Method, AllowMultiple = true)]
    public sealed class MenuItem : Attribute
    {
        public string menuItem;
        public int priority;

        public MenuItem(string itemName)
        {
            menuItem = itemName;
        }

        public MenuItem(string itemName, bool isValidateFunction, int priority)
        {
            menuItem = itemName;
            this.priority = priority;
        }
    }

    public sealed class MenuCommand
    {
        public Object context;

        public MenuCommand(Object inContext)
        {
            context = inContext;
        }
    }

    [AttributeUsage(AttributeTargets.Class)]
    public class CustomEditor : Attribute
    {
        public CustomEditor(Type inspectedType)
        {
        }
    }

    [AttributeUsage(AttributeTargets.Class)]
    public sealed class CanEditMultipleObjects : Attribute
    {
    }

    [AttributeUsage(AttributeTargets.Class, AllowMultiple = true)]
    public sealed class CustomPropertyDrawer : Attribute
    {
        public CustomPropertyDrawer(Type type)
        {
        }
    }

    public class SerializedObject
    {
        internal SerializedObject()
        {
        }

        public bool isEditingMultipleObjects => false;
    }

    public class SerializedProperty
    {
        internal SerializedProperty()
        {
        }

        public string stringValue { get; set; } = "";
        public string displayName { get; internal set; } = "";
        public string tooltip { get; internal set; } = "";
    }

    public abstract class PropertyDrawer
    {
        public virtual VisualElement CreatePropertyGUI(SerializedProperty property) => null;
    }

    public class Editor : ScriptableObject
    {
        public Object target { get; set; }
        public SerializedObject serializedObject { get; } = new SerializedObject();

        public virtual VisualElement CreateInspectorGUI() => null;
    }

    public class EditorWindow : ScriptableObject
    {
        public GUIContent titleContent { get; set; }
        public Vector2 minSize { get; set; }
        public VisualElement rootVisualElement { get; } = new VisualElement();

        public static T GetWindow<T>()
            where T : EditorWindow => CreateInstance<T>();
    }

    public enum PlayModeStateChange
    {
        EnteredEditMode,
        ExitingEditMode,
        EnteredPlayMode,
        ExitingPlayMode,
    }

    public sealed class EditorApplication
    {
        public static bool isPaused { get; set; }

        public static event Action quitting;
        public static event Action<PlayModeStateChange> playModeStateChanged;

        /// <summary>For tests: raises the event.</summary>
        internal static void Say(PlayModeStateChange change) => playModeStateChanged?.Invoke(change);
        internal static void SayQuitting() => quitting?.Invoke();
    }

    public static class AssemblyReloadEvents
    {
        public delegate void AssemblyReloadCallback();

        public static event AssemblyReloadCallback beforeAssemblyReload;

        /// <summary>For tests: raises the event.</summary>
        internal static void SayReload() => beforeAssemblyReload?.Invoke();
    }

    public class EditorUtility
    {
        /// <summary>For tests: the latest message, and the file that dialogs select.</summary>
        internal static string LastMessage { get; private set; } = "";
        internal static string ChosenFile { get; set; } = "";

        public static bool DisplayDialog(string title, string message, string ok)
        {
            LastMessage = message;
            return true;
        }

        public static string SaveFilePanel(string title, string directory, string defaultName, string extension) => ChosenFile;
    }

    public sealed class AssetDatabase
    {
        public static T LoadAssetAtPath<T>(string assetPath)
            where T : Object => null;

        public static void CreateAsset(Object asset, string path)
        {
        }

        public static string GenerateUniqueAssetPath(string path) => path;

        public static void SaveAssets()
        {
        }

        public static void Refresh()
        {
        }
    }

    public class AssetImporter : Object
    {
        public string assetPath { get; internal set; } = "";
    }

    public sealed class PluginImporter : AssetImporter
    {
        /// <summary>For tests: the plug-ins of the project, and the platform of each.</summary>
        internal static List<(string Path, BuildTarget Platform)> Plugins { get; } = new List<(string, BuildTarget)>();

        public static PluginImporter[] GetImporters(BuildTarget platform) =>
            Plugins.Where(plugin => plugin.Platform == platform).Select(plugin => new PluginImporter { assetPath = plugin.Path }).ToArray();
    }

    public class Undo
    {
        public static void RegisterCreatedObjectUndo(Object objectToUndo, string name)
        {
        }
    }

    public sealed class Selection
    {
        public static GameObject activeGameObject { get; set; }
    }

    public sealed class GameObjectUtility
    {
        public static void SetParentAndAlign(GameObject child, GameObject parent)
        {
        }
    }

    public class FileUtil
    {
        public static bool DeleteFileOrDirectory(string path) => false;
    }
}
