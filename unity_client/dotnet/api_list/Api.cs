using System;
using System.Collections.Generic;
using System.Globalization;
using System.IO;
using System.Linq;
using Microsoft.CodeAnalysis;

namespace ApiList
{
    /// <summary>Describes what other assemblies can see of a type.</summary>
    internal static class Api
    {
        private static readonly SymbolDisplayFormat Names = new SymbolDisplayFormat(
            typeQualificationStyle: SymbolDisplayTypeQualificationStyle.NameAndContainingTypesAndNamespaces,
            genericsOptions: SymbolDisplayGenericsOptions.IncludeTypeParameters | SymbolDisplayGenericsOptions.IncludeVariance,
            miscellaneousOptions: SymbolDisplayMiscellaneousOptions.UseSpecialTypes);

        internal static bool IsVisible(ISymbol symbol) =>
            symbol.DeclaredAccessibility is Accessibility.Public or Accessibility.Protected or Accessibility.ProtectedOrInternal;

        internal static string MetadataName(INamedTypeSymbol type) => type.ContainingType is { } outer ? $"{MetadataName(outer)}+{type.MetadataName}" :
            type.ContainingNamespace.IsGlobalNamespace ? type.MetadataName : $"{Name(type.ContainingNamespace)}.{type.MetadataName}";

        /// <summary>The module, such as Physics, whose folder has the type's source, or Core.</summary>
        internal static string Module(INamedTypeSymbol type, string root)
        {
            string[] folders = Path.GetRelativePath(root, type.Locations[0].SourceTree!.FilePath).Split('/');
            return $"{Name(type)}\t: module {(folders[0] == "Modules" ? folders[1] : folders[0] == "ModuleOverrides" ? "UIElements" : "Core")}";
        }

        /// <param name="type">The type that the lines describe.</param>
        /// <param name="withInherited">True to add the members that a class inherits, as if it declared them.</param>
        internal static IEnumerable<string> OfType(INamedTypeSymbol type, bool withInherited) => Lines(type, withInherited).Select(line => $"{Name(type)}\t{line}");

        private static IEnumerable<string> Lines(INamedTypeSymbol type, bool withInherited)
        {
            yield return $": {Kind(type)}{Shape(type)}{Constraints(type.TypeParameters)}{Obsolete(type)}";
            foreach (string usage in AttributeUsage(type))
                yield return $": on {usage}";
            if (type.TypeKind == TypeKind.Delegate)
                yield break;
            IEnumerable<INamedTypeSymbol> parents = type.TypeKind == TypeKind.Class ? Ancestors(type) : Enumerable.Empty<INamedTypeSymbol>();
            IEnumerable<INamedTypeSymbol> interfaces = type.TypeKind == TypeKind.Enum ? Enumerable.Empty<INamedTypeSymbol>() : type.AllInterfaces.Where(IsVisible);
            foreach (INamedTypeSymbol parent in parents.Concat(interfaces))
                yield return $": is {Name(parent)}";
            IEnumerable<ISymbol> members = type.GetMembers();
            if (withInherited)
                members = members.Concat(parents.SelectMany(parent => parent.GetMembers()).Where(member => member.Name != ".ctor"));
            foreach (string line in members.Where(IsVisible).SelectMany(OfMember))
                yield return line;
        }

        private static IEnumerable<INamedTypeSymbol> Ancestors(INamedTypeSymbol type)
        {
            for (INamedTypeSymbol? at = type.BaseType; at != null && at.SpecialType != SpecialType.System_Object; at = at.BaseType)
                yield return at;
        }

        private static IEnumerable<string> OfMember(ISymbol member)
        {
            string before = Modifiers(member), after = Obsolete(member);
            if (member is IFieldSymbol { ContainingType: { TypeKind: TypeKind.Enum } } choice)
                yield return $"{choice.Name} = {choice.ConstantValue}{after}";
            else if (member is IFieldSymbol field)
                yield return $"{field.Name} : {before}{Name(field.Type)}{(field.HasConstantValue ? $" = {Literal(field.ConstantValue)}" : "")}{after}";
            else if (member is IEventSymbol happening)
                yield return $"{happening.Name} : {before}event {Name(happening.Type)}{after}";
            else if (member is IPropertySymbol property)
            {
                string shown = property.IsIndexer ? $"this[{Parameters(property.Parameters)}]" : property.Name;
                foreach (IMethodSymbol accessor in new[] { property.GetMethod, property.SetMethod }.OfType<IMethodSymbol>().Where(IsVisible))
                    yield return $"{shown} : {Modifiers(accessor)}{Ref(property.RefKind)}{Name(property.Type)} {(accessor.MethodKind == MethodKind.PropertyGet ? "get" : "set")}{after}{Obsolete(accessor)}";
            }
            else if (member is IMethodSymbol method && IsDescribed(method))
            {
                string generic = method.IsGenericMethod ? $"<{string.Join(", ", method.TypeParameters.Select(Name))}>" : "";
                string shown = $"{generic}({(method.IsExtensionMethod ? "this " : "")}{Parameters(method.Parameters)})";
                yield return method.MethodKind == MethodKind.Constructor ? $"new{shown}{(before.Length == 0 ? "" : $" : {before.Trim()}")}{after}" :
                    $"{method.Name}{shown} : {before}{Ref(method.RefKind)}{Name(method.ReturnType)}{Constraints(method.TypeParameters)}{after}";
            }
        }

        private static bool IsDescribed(IMethodSymbol method)
        {
            if (method.MethodKind == MethodKind.Constructor && method.ContainingType.TypeKind != TypeKind.Enum)
                return !(method.ContainingType.TypeKind == TypeKind.Struct && method.Parameters.IsEmpty);
            if (method.ContainingType.TypeKind == TypeKind.Enum || !(method.MethodKind is MethodKind.Ordinary or MethodKind.UserDefinedOperator or MethodKind.Conversion))
                return false;
            IMethodSymbol first = method;
            while (first.OverriddenMethod is { } overridden)
                first = overridden;
            return first.ContainingType.SpecialType is not (SpecialType.System_Object or SpecialType.System_ValueType);
        }

        private static string Name(ISymbol symbol) => symbol.ToDisplayString(Names);

        private static string Kind(INamedTypeSymbol type) => type.TypeKind switch
        {
            TypeKind.Delegate => "delegate",
            TypeKind.Enum => "enum",
            TypeKind.Interface => "interface",
            TypeKind.Struct => type.IsRefLikeType ? "ref struct" : "struct",
            _ => $"{(type.IsStatic ? "static " : type.IsAbstract ? "abstract " : type.IsSealed ? "sealed " : "")}class",
        };

        private static string Shape(INamedTypeSymbol type) => type.TypeKind switch
        {
            TypeKind.Delegate => $" {Name(type.DelegateInvokeMethod!.ReturnType)}({Parameters(type.DelegateInvokeMethod.Parameters)})",
            TypeKind.Enum => $" {Name(type.EnumUnderlyingType!)}",
            _ => "",
        };

        private static string Modifiers(ISymbol member) =>
            (member.DeclaredAccessibility == Accessibility.Public ? "" : "protected ") +
            (member.ContainingType.TypeKind == TypeKind.Interface ? "" :
                member is IFieldSymbol { IsConst: true } ? "const " : member.IsStatic ? "static " : member.IsAbstract ? "abstract " : member.IsOverride ? "override " : member.IsVirtual ? "virtual " : "") +
            (member is IFieldSymbol { IsReadOnly: true } ? "readonly " : "");

        private static string Parameters(IEnumerable<IParameterSymbol> parameters) => string.Join(", ", parameters.Select(
            parameter => $"{(parameter.IsParams ? "params " : "")}{Ref(parameter.RefKind)}{Name(parameter.Type)} {parameter.Name}{(parameter.HasExplicitDefaultValue ? $" = {Literal(parameter.ExplicitDefaultValue)}" : "")}"));

        private static string Ref(RefKind kind) => kind switch { RefKind.Ref => "ref ", RefKind.Out => "out ", RefKind.In => "in ", _ => "" };

        private static string Literal(object? value) => value switch
        {
            null => "default",
            bool truth => truth ? "true" : "false",
            string text => $"\"{text}\"",
            _ => Convert.ToString(value, CultureInfo.InvariantCulture)!,
        };

        private static string Constraints(IEnumerable<ITypeParameterSymbol> parameters) => string.Concat(parameters.Select(parameter =>
        {
            string[] own = new[]
            {
                parameter.HasReferenceTypeConstraint ? "class" : "", parameter.HasUnmanagedTypeConstraint ? "unmanaged" : parameter.HasValueTypeConstraint ? "struct" : "",
            }.Concat(parameter.ConstraintTypes.Select(Name)).Append(parameter.HasConstructorConstraint ? "new()" : "").Where(part => part.Length > 0).ToArray();
            return own.Length == 0 ? "" : $" where {parameter.Name} : {string.Join(", ", own)}";
        }));

        private static string Obsolete(ISymbol symbol)
        {
            AttributeData? mark = symbol.GetAttributes().FirstOrDefault(attribute => attribute.AttributeClass?.ToDisplayString() == "System.ObsoleteAttribute");
            if (mark == null)
                return "";
            return mark.ConstructorArguments.Any(argument => argument.Value is true) ? " obsolete, an error" : " obsolete";
        }

        /// <summary>Yields the targets of an attribute class, and "several" if an element may have several; nothing for other classes.</summary>
        private static IEnumerable<string> AttributeUsage(INamedTypeSymbol type)
        {
            INamedTypeSymbol[] classes = Ancestors(type).Prepend(type).ToArray();
            if (classes[^1].ToDisplayString() != "System.Attribute")
                yield break;
            AttributeData? usage = classes.SelectMany(at => at.GetAttributes()).FirstOrDefault(attribute => attribute.AttributeClass?.ToDisplayString() == "System.AttributeUsageAttribute");
            var targets = (AttributeTargets)(usage?.ConstructorArguments.FirstOrDefault().Value as int? ?? (int)AttributeTargets.All);
            foreach (AttributeTargets target in Enum.GetValues<AttributeTargets>().Where(target => target != AttributeTargets.All && targets.HasFlag(target)))
                yield return target.ToString();
            if (usage?.NamedArguments.Any(pair => pair.Key == "AllowMultiple" && pair.Value.Value is true) == true)
                yield return "several";
        }
    }
}
