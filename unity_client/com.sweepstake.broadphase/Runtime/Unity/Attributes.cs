#nullable enable
using System;
using System.IO;
using UnityEngine;

namespace Sweepstake.Unity
{
    /// <summary>The help button of a component opens a page of the package's documentation on disk, without a network.</summary>
    [AttributeUsage(AttributeTargets.Class)]
    public sealed class DocumentationPageAttribute : HelpURLAttribute
    {
        private const string Folder = "Packages/com.sweepstake.broadphase/Documentation~/";

        /// <param name="page">A file in Documentation~, such as "components.md".</param>
        public DocumentationPageAttribute(string page)
            : base(UrlOf(page))
        {
            Page = page;
        }

        public string Page { get; }

        /// <summary>Returns the URL of a page on disk. The editor resolves paths that begin with Packages.</summary>
        public static string UrlOf(string page) => new Uri(Path.GetFullPath(Folder + page)).AbsoluteUri;
    }

    /// <summary>The inspector offers the names of the library's backends.</summary>
    public sealed class BackendNameAttribute : PropertyAttribute
    {
    }
}
