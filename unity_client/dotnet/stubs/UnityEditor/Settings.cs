using System;
using System.Collections.Generic;
using UnityEditor.Build;
using UnityEngine;
using UnityEngine.UIElements;

namespace UnityEditor
{
    [AttributeUsage(AttributeTargets.Class)]
    public class FilePathAttribute : Attribute
    {
        public FilePathAttribute(string relativePath, Location location)
        {
        }

        public enum Location
        {
            PreferencesFolder,
            ProjectFolder,
        }
    }

    public class ScriptableSingleton<T> : ScriptableObject
        where T : ScriptableObject
    {
        private static T made;

        protected ScriptableSingleton()
        {
        }

        public static T instance => made ??= CreateInstance<T>();

        protected virtual void Save(bool saveAsText)
        {
        }
    }

    public enum SettingsScope
    {
        User,
        Project,
    }

    [AttributeUsage(AttributeTargets.Method)]
    public sealed class SettingsProviderAttribute : Attribute
    {
    }

    public class SettingsProvider
    {
        public SettingsProvider(string path, SettingsScope scopes, IEnumerable<string> keywords = null)
        {
            this.keywords = keywords;
            settingsPath = path;
        }

        public string settingsPath { get; }
        public string label { get; set; }
        public IEnumerable<string> keywords { get; set; }
        public Action<string, VisualElement> activateHandler { get; set; }
    }

    public enum BuildTarget
    {
        StandaloneOSX = 2,
        StandaloneWindows = 5,
        iOS = 9,
        Android = 13,
        StandaloneWindows64 = 19,
        WebGL = 20,
        StandaloneLinux64 = 24,
        EmbeddedLinux = 45,
    }

    public enum BuildTargetGroup
    {
        Standalone = 1,
    }

    public class EditorUserBuildSettings : UnityEngine.Object
    {
        internal EditorUserBuildSettings()
        {
        }

        public static BuildTarget activeBuildTarget { get; internal set; } = BuildTarget.StandaloneLinux64;
        public static BuildTargetGroup selectedBuildTargetGroup => BuildTargetGroup.Standalone;
    }

    public sealed class PlayerSettings : UnityEngine.Object
    {
        internal PlayerSettings()
        {
        }

        private static readonly Dictionary<string, string> Defines = new Dictionary<string, string>();

        public static string GetScriptingDefineSymbols(NamedBuildTarget buildTarget) => Defines.GetValueOrDefault(buildTarget.TargetName, "");
        public static void SetScriptingDefineSymbols(NamedBuildTarget buildTarget, string defines) => Defines[buildTarget.TargetName] = defines;
    }
}

namespace UnityEditor.Build
{
    public struct NamedBuildTarget
    {
        public static readonly NamedBuildTarget Standalone = new NamedBuildTarget("Standalone");
        public static readonly NamedBuildTarget Server = new NamedBuildTarget("Server");
        public static readonly NamedBuildTarget EmbeddedLinux = new NamedBuildTarget("EmbeddedLinux");
        public static readonly NamedBuildTarget Android = new NamedBuildTarget("Android");
        public static readonly NamedBuildTarget iOS = new NamedBuildTarget("iPhone");

        private NamedBuildTarget(string targetName)
        {
            TargetName = targetName;
        }

        public string TargetName { get; }

        public static NamedBuildTarget FromBuildTargetGroup(BuildTargetGroup buildTargetGroup) => Standalone;
    }

    public interface IOrderedCallback
    {
        int callbackOrder { get; }
    }

    public interface IUnityLinkerProcessor : IOrderedCallback
    {
        string GenerateAdditionalLinkXmlFile(Reporting.BuildReport report, UnityLinker.UnityLinkerBuildPipelineData data);
    }
}

namespace UnityEditor.Build.Reporting
{
    public sealed class BuildReport : UnityEngine.Object
    {
        internal BuildReport()
        {
        }
    }
}

namespace UnityEditor.UnityLinker
{
    public sealed class UnityLinkerBuildPipelineData
    {
        internal UnityLinkerBuildPipelineData()
        {
        }
    }
}

namespace UnityEditor.Compilation
{
    public static class CompilationPipeline
    {
        public static string[] GetPrecompiledAssemblyNames() => Array.Empty<string>();
    }
}

namespace UnityEditor.UIElements
{
    public class ObjectField : BaseField<UnityEngine.Object>
    {
        public ObjectField(string label)
            : base(label, null)
        {
        }

        public Type objectType { get; set; }
        public bool allowSceneObjects { get; set; }
    }

    public class InspectorElement : BindableElement
    {
        public InspectorElement(UnityEngine.Object obj)
        {
        }

        public static void FillDefaultInspector(VisualElement container, SerializedObject serializedObject, Editor editor)
        {
        }
    }

    public static class BindingExtensions
    {
        public static void BindProperty(this IBindable field, SerializedProperty property)
        {
        }
    }
}

namespace Unity.Profiling.Editor
{
    [AttributeUsage(AttributeTargets.Class)]
    public class ProfilerModuleMetadataAttribute : Attribute
    {
        public ProfilerModuleMetadataAttribute(string displayName)
        {
        }
    }

    public readonly struct ProfilerCounterDescriptor
    {
        public ProfilerCounterDescriptor(string name, ProfilerCategory category)
        {
            Name = name;
        }

        public string Name { get; }
    }

    public enum ProfilerModuleChartType
    {
        Line,
        StackedTimeArea,
    }

    public abstract class ProfilerModule
    {
        protected ProfilerModule(
            ProfilerCounterDescriptor[] chartCounters, ProfilerModuleChartType defaultChartType = ProfilerModuleChartType.Line, string[] autoEnabledCategoryNames = null)
        {
        }
    }
}
