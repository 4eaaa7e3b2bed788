// Prints the public API of an assembly or of C# sources: the type, a tab, and one line per type, interface, member or accessor.
//
//   ApiList ARGUMENTS-FILE
//
// The file has one argument per line:
//   assembly PATH    prints all types of this assembly, and a line "type " with the metadata name of each
//   source PATH      adds a source file; a file that is missing is skipped
//   define NAME      defines a preprocessor symbol for the sources
//   reference PATH   an assembly that the sources or the assembly need
//   type NAME        prints this type of the sources, by its metadata name such as Unity.Collections.NativeArray`1
//   root PATH        the folder of the sources; the line of a type's module then shows the folder of its file
//
// Equal API gives equal lines, whether it comes from an assembly or from sources. Bodies are not compiled, so that sources may miss some references.
using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using Microsoft.CodeAnalysis;
using Microsoft.CodeAnalysis.CSharp;

namespace ApiList
{
    internal static class Program
    {
        private static int Main(string[] arguments)
        {
            if (arguments.Length != 1)
            {
                Console.Error.WriteLine("usage: ApiList ARGUMENTS-FILE");
                return 2;
            }
            ILookup<string, string> given = File.ReadLines(arguments[0]).Select(line => line.Split(' ', 2)).ToLookup(pair => pair[0], pair => pair[1]);
            List<MetadataReference> references = given["reference"].Select(path => (MetadataReference)MetadataReference.CreateFromFile(path)).ToList();
            var lines = new SortedSet<string>(StringComparer.Ordinal);
            foreach (string path in given["assembly"])
                AddAssembly(lines, path, references);
            CSharpCompilation sources = Compile(given["source"], given["define"], references);
            foreach (string name in given["type"])
            {
                if (sources.Assembly.GetTypeByMetadataName(name) is { } type)
                    lines.UnionWith(Api.OfType(type, true).Append(Api.Module(type, given["root"].First())));
            }
            foreach (string line in lines)
                Console.WriteLine(line);
            return 0;
        }

        private static void AddAssembly(ISet<string> lines, string path, IEnumerable<MetadataReference> references)
        {
            MetadataReference own = MetadataReference.CreateFromFile(path);
            CSharpCompilation compilation = CSharpCompilation.Create("reader", references: references.Append(own));
            var assembly = (IAssemblySymbol)compilation.GetAssemblyOrModuleSymbol(own)!;
            foreach (INamedTypeSymbol type in AllTypes(assembly.GlobalNamespace))
            {
                lines.UnionWith(Api.OfType(type, false));
                lines.Add($"type {Api.MetadataName(type)}");
            }
        }

        private static CSharpCompilation Compile(IEnumerable<string> paths, IEnumerable<string> defines, IEnumerable<MetadataReference> references)
        {
            var options = new CSharpParseOptions(LanguageVersion.Preview, DocumentationMode.None, preprocessorSymbols: defines);
            IEnumerable<SyntaxTree> trees = paths.Where(File.Exists).AsParallel().AsOrdered().Select(path => CSharpSyntaxTree.ParseText(File.ReadAllText(path), options, path));
            return CSharpCompilation.Create("sources", trees, references, new CSharpCompilationOptions(OutputKind.DynamicallyLinkedLibrary, allowUnsafe: true));
        }

        private static IEnumerable<INamedTypeSymbol> AllTypes(INamespaceOrTypeSymbol container) =>
            container.GetMembers().OfType<INamespaceOrTypeSymbol>().SelectMany(
                member => member is INamedTypeSymbol type ? Api.IsVisible(type) ? AllTypes(type).Prepend(type) : Enumerable.Empty<INamedTypeSymbol>() : AllTypes(member));
    }
}
