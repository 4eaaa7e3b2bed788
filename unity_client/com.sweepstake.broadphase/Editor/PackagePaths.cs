#nullable enable
using Sweepstake.Unity;
using UnityEditor;
using UnityEngine;
using UnityEngine.UIElements;

namespace Sweepstake.Editor
{
    internal static class PackagePaths
    {
        internal const string Package = "Packages/com.sweepstake.broadphase/";
        internal const string MenuRoot = "Window/Sweepstake/";
        private const string StyleSheet = Package + "Editor/Sweepstake.uss";

        internal static void AddStyle(VisualElement root)
        {
            var sheet = AssetDatabase.LoadAssetAtPath<StyleSheet>(StyleSheet);
            if (sheet != null)
                root.styleSheets.Add(sheet);
            root.AddToClassList("sweepstake");
        }

        internal static void OpenPage(string page) => Application.OpenURL(DocumentationPageAttribute.UrlOf(page));
    }
}
