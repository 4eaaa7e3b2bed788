using UnityEditor.PackageManager.Requests;

namespace UnityEditor.PackageManager
{
    public sealed class PackageInfo
    {
        internal PackageInfo() { }

        public string packageId { get; private set; } = "";
        public string resolvedPath { get; private set; } = "";

        /// <summary>For tests: what FindForAssembly returns; null as for an assembly in Assets.</summary>
        internal static PackageInfo Found { get; private set; }

        public static PackageInfo FindForAssembly(System.Reflection.Assembly assembly) => Found;

        /// <summary>For tests.</summary>
        internal static void Install(string packageId, string resolvedPath) => Found = new PackageInfo { packageId = packageId, resolvedPath = resolvedPath };
    }

    public static class Client
    {
        /// <summary>For tests: the package that was added last.</summary>
        internal static string Added { get; private set; } = "";

        public static AddRequest Add(string identifier)
        {
            Added = identifier;
            return new AddRequest();
        }
    }
}

namespace UnityEditor.PackageManager.Requests
{
    public abstract class Request
    {
        internal Request() { }
    }

    public abstract class Request<T> : Request
    {
        internal Request() { }
    }

    public sealed class AddRequest : Request<PackageInfo>
    {
        internal AddRequest() { }
    }
}
