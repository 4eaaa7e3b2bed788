#nullable enable
using System.IO;
using UnityEditor.Build;
using UnityEditor.Build.Reporting;
using UnityEditor.UnityLinker;

namespace Sweepstake.Editor
{
    /// <summary>Keeps the structs of the C ABI, which native code reads, when code is stripped. Unity ignores a link.xml in a package.</summary>
    internal sealed class LinkerProcessor : IUnityLinkerProcessor
    {
        internal const string Folder = "Library/com.sweepstake.broadphase";
        internal const string Xml = "<linker><assembly fullname=\"Sweepstake.Core\" preserve=\"all\"/></linker>\n";

        public int callbackOrder => 0;

        public string GenerateAdditionalLinkXmlFile(BuildReport report, UnityLinkerBuildPipelineData data)
        {
            Directory.CreateDirectory(Folder);
            string path = Path.GetFullPath(Path.Combine(Folder, "link.xml"));
            File.WriteAllText(path, Xml);
            return path;
        }
    }
}
