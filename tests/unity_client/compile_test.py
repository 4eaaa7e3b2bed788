#!/usr/bin/env python3
"""Compiles the assemblies of the Unity package and of its samples as Unity would: by their .asmdef, for editors and players.

The C# code in the package's documents is compiled too (document_code.py). Stubs replace Unity's own assemblies (unity_client/dotnet/stubs).
Warnings are errors. C# 9, .NET Standard 2.1.

    compile_test.py ROOT BUILD     tests/unity_client/dotnet_test.sh restores the projects of unity_client/dotnet in BUILD first

Rows with gRPC need its libraries; without them they are skipped, and the last line says so.
"""

import json
import pathlib
import re
import subprocess
import sys

import document_code

PACKAGE = "unity_client/com.sweepstake.broadphase"
STUBS = "unity_client/dotnet/stubs"
# Warnings that Unity disables too. 0169 and 0649 report fields without a use or a value, so also those that only the inspector sets.
# 1701 and 1702 concern the versions of referenced assemblies.
NO_WARNING = "0169,0649,1701,1702"
DOCUMENTS = "Sweepstake.Documents"
DIRECTIVE = re.compile(r"^\s*#(?:if|elif)\s+(.*)$", re.MULTILINE)
WORD = re.compile(r"\w+")

GRPC = ["SWEEPSTAKE_GRPC"]
OLD_INPUT, NEW_INPUT = ["ENABLE_LEGACY_INPUT_MANAGER"], ["ENABLE_INPUT_SYSTEM"]
YAHA, INPUT, BURST, TESTING = "com.cysharp.yetanotherhttphandler", "com.unity.inputsystem", "com.unity.burst", "com.unity.test-framework"
URP, HDRP = "com.unity.render-pipelines.universal", "com.unity.render-pipelines.high-definition"
# The assembly of each package that has a stub.
PACKAGE_ASSEMBLIES = {YAHA: "Cysharp.Net.Http.YetAnotherHttpHandler", INPUT: "Unity.InputSystem", BURST: "Unity.Burst", TESTING: "UnityEngine.TestRunner"}


def unity(*versions):
    return ["UNITY_5_3_OR_NEWER", *(f"UNITY_{version.replace('.', '_')}_OR_NEWER" for version in versions)]


U2022, U6, U65 = unity("2022.3"), unity("2022.3", "6000.0"), unity("2022.3", "6000.0", "6000.5")
EDITOR, TESTS = ["UNITY_EDITOR"], ["UNITY_INCLUDE_TESTS"]
DESKTOP, IOS_ARCHIVE = ["UNITY_STANDALONE"], ["SWEEPSTAKE_IOS"]

# Each row has a name, a platform, defines and packages.
ROWS = [
    ("editor 2022.3, nothing else", "Editor", U2022 + EDITOR + OLD_INPUT, []),
    ("editor 2022.3, tests", "Editor", U2022 + EDITOR + OLD_INPUT + TESTS, [TESTING]),
    ("Linux 6000.5, tests", "LinuxStandalone64", U65 + DESKTOP + OLD_INPUT + TESTS, [TESTING]),
    ("editor 2022.3, gRPC, URP, new input", "Editor", U2022 + EDITOR + NEW_INPUT + GRPC, [YAHA, INPUT, BURST, URP]),
    ("editor 2022.3, gRPC, no HTTP/2", "Editor", U2022 + EDITOR + OLD_INPUT + GRPC, []),
    ("editor 2022.3, both inputs", "Editor", U2022 + EDITOR + OLD_INPUT + NEW_INPUT, [INPUT]),
    ("editor 2022.3, WebGL chosen, gRPC", "Editor", U2022 + EDITOR + OLD_INPUT + GRPC + ["UNITY_WEBGL"], [YAHA]),
    ("editor 6000.0, gRPC, HDRP, new input", "Editor", U6 + EDITOR + NEW_INPUT + GRPC, [YAHA, INPUT, BURST, HDRP]),
    ("editor 6000.5, gRPC by Unity's handler", "Editor", U65 + EDITOR + OLD_INPUT + GRPC, []),
    ("Linux 2022.3", "LinuxStandalone64", U2022 + DESKTOP + OLD_INPUT, []),
    ("Linux 2022.3, gRPC", "LinuxStandalone64", U2022 + DESKTOP + OLD_INPUT + GRPC, [YAHA]),
    ("Windows 6000.0, IL2CPP, gRPC", "WindowsStandalone64", U6 + DESKTOP + NEW_INPUT + GRPC + ["ENABLE_IL2CPP"], [YAHA, INPUT, BURST, URP]),
    ("Windows 6000.5, gRPC by Unity's handler", "WindowsStandalone64", U65 + DESKTOP + OLD_INPUT + GRPC, []),
    ("Android 6000.0, IL2CPP", "Android", U6 + NEW_INPUT + ["ENABLE_IL2CPP", "UNITY_ANDROID"], [INPUT, BURST, URP]),
    ("iOS 2022.3, IL2CPP, gRPC", "iOS", U2022 + OLD_INPUT + GRPC + ["ENABLE_IL2CPP", "UNITY_IOS"], [YAHA]),
    ("iOS 2022.3, IL2CPP, with the archive", "iOS", U2022 + OLD_INPUT + GRPC + ["ENABLE_IL2CPP", "UNITY_IOS"] + IOS_ARCHIVE, [YAHA]),
    ("WebGL 2022.3", "WebGL", U2022 + OLD_INPUT + ["ENABLE_IL2CPP", "UNITY_WEBGL"], []),
    ("WebGL 6000.0, gRPC", "WebGL", U6 + NEW_INPUT + GRPC + ["ENABLE_IL2CPP", "UNITY_WEBGL"], [YAHA, INPUT, HDRP]),
]


class Toolchain:
    """The compiler and the libraries of .NET in the folders of the SDK and NuGet."""

    def __init__(self, build):
        version, folder = re.findall(r"^(\S+) \[(.*)\]$", run("dotnet", "--list-sdks"), re.MULTILINE)[-1]
        self.compiler = pathlib.Path(folder) / version / "Roslyn" / "bincore" / "csc.dll"
        self.packages = pathlib.Path(run("dotnet", "nuget", "locals", "global-packages", "--list").split(":", 1)[1].strip())
        self.framework = sorted((self.packages / "netstandard.library.ref/2.1.0/ref/netstandard2.1").glob("*.dll"))
        # Players get no Google.Protobuf: only the editor has generated messages.
        self.grpc = self.restored(build / "dotnet/Sweepstake.GrpcNet/obj/project.assets.json")
        self.editor_grpc = sorted({*self.grpc, *self.restored(build / "dotnet/Sweepstake.Protocol/obj/project.assets.json")})
        self.nunit = self.packages / "nunit/3.14.0/lib/netstandard2.0/nunit.framework.dll"
        if not self.compiler.is_file() or not self.framework:
            raise SystemExit(f"compile_test.py: {self.compiler} or the reference of .NET Standard 2.1 is missing; run tests/unity_client/dotnet_test.sh")

    def restored(self, assets):
        if not assets.is_file():
            return []
        target = next(iter(json.loads(assets.read_text(encoding="utf-8"))["targets"].values()))
        found = [self.packages / name.lower() / file for name, library in target.items() for file in library.get("compile", {}) if library["type"] == "package"]
        # Unity's .NET Standard contains the assemblies of the reference.
        found = [path for path in found if path.name not in {file.name for file in self.framework}]
        return found if all(path.is_file() for path in found) else []


def run(*command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


class Assembly:
    """Sources and the content of the .asmdef; a stub has none."""

    def __init__(self, name, sources, asmdef=None):
        self.name, self.asmdef = name, asmdef or {}
        self.sources = sources
        text = "\n".join(path.read_text(encoding="utf-8-sig") for path in sources)
        self.words = {word for condition in DIRECTIVE.findall(text) for word in WORD.findall(condition)}

    def is_for(self, platform, defines):
        included, excluded = self.asmdef.get("includePlatforms", []), self.asmdef.get("excludePlatforms", [])
        return (not included or platform in included) and platform not in excluded and set(self.asmdef.get("defineConstraints", [])) <= set(defines)

    def defines(self, defines, packages):
        own = {entry["define"] for entry in self.asmdef.get("versionDefines", []) if entry["name"] in packages}
        return sorted((set(defines) | own) & self.words)


def package_assemblies(package):
    found = {}
    asmdefs = sorted(package.rglob("*.asmdef"))
    folders = {path.parent for path in asmdefs}
    for path in asmdefs:
        others = [folder for folder in folders if folder != path.parent and path.parent in folder.parents]
        sources = [source for source in sorted(path.parent.rglob("*.cs")) if not any(other in source.parents for other in others)]
        asmdef = json.loads(path.read_text(encoding="utf-8"))
        found[asmdef["name"]] = Assembly(asmdef["name"], sources, asmdef)
    return found


def document_assembly(root, folder):
    """Returns the assembly of the documents' code, for the rows with all packages that the documents use."""
    sources = [*document_code.write(root / "unity_client", folder), *sorted((root / "tests/unity_client/documents").glob("*.cs"))]
    return Assembly(DOCUMENTS, sources, {
        "noEngineReferences": False, "overrideReferences": False, "includePlatforms": ["Editor"], "defineConstraints": [*GRPC, *NEW_INPUT],
        "references": ["Sweepstake.Core", "Sweepstake.Unity", "Sweepstake.GrpcNet", PACKAGE_ASSEMBLIES[YAHA]]})


def stub_assemblies(stubs):
    found = {path.name: Assembly(path.name, sorted(path.glob("*.cs"))) for path in stubs.iterdir() if path.is_dir() and path.name != "packages"}
    return found | {path.stem: Assembly(path.stem, [path]) for path in sorted((stubs / "packages").glob("*.cs"))}


class Compiler:
    def __init__(self, tools, output):
        self.tools, self.output, self.made, self.count = tools, output, {}, 0

    def compile(self, assembly, defines, references):
        """Returns the path of the assembly; compiles equal assemblies of several rows once."""
        key = (assembly.name, tuple(defines), tuple(references))
        if key not in self.made:
            folder = self.output / str(len(self.made))
            folder.mkdir(parents=True, exist_ok=True)
            path = folder / f"{assembly.name}.dll"
            arguments = ["-nologo", "-noconfig", "-nostdlib", "-target:library", "-langversion:9", "-warnaserror", f"-nowarn:{NO_WARNING}", "-deterministic",
                         *(["-unsafe"] if assembly.asmdef.get("allowUnsafeCode", True) else []), f"-out:{path}",
                         *(f"-define:{define}" for define in defines), *(f"-r:{file}" for file in [*self.tools.framework, *references]),
                         *(str(source) for source in assembly.sources)]
            response = folder / "arguments.rsp"
            response.write_text("\n".join(f'"{argument}"' if " " in argument else argument for argument in arguments), encoding="utf-8")
            done = subprocess.run(["dotnet", "exec", str(self.tools.compiler), "-shared", "-keepalive:20", f"@{response}"], capture_output=True, text=True, check=False)
            self.count += 1
            self.made[key] = path if done.returncode == 0 else None
            if done.returncode:
                print(f"{assembly.name}, with {' '.join(defines) or 'no define'}:\n{done.stdout}{done.stderr}")
        return self.made[key]


def compile_row(compiler, package, stubs, row):
    """Returns the paths of the package's assemblies that were compiled, and the names of those that failed."""
    _, platform, defines, packages = row
    present = {name: stub for name, stub in stubs.items() if platform == "Editor" or name != "UnityEditor"}
    present = {name: stub for name, stub in present.items() if name not in PACKAGE_ASSEMBLIES.values() or any(PACKAGE_ASSEMBLIES.get(p) == name for p in packages)}
    due = {name: assembly for name, assembly in package.items() if assembly.is_for(platform, defines)}
    paths, failed = {}, []

    def path_of(name):
        if name not in paths:
            assembly = due.get(name) or present[name]
            references = [path_of(other) for other in reference_names(assembly, present, due)]
            if None not in references:
                references += precompiled(compiler.tools, assembly, defines)
            paths[name] = None if None in references else compiler.compile(assembly, assembly.defines(defines, packages), references)
            if paths[name] is None:
                failed.append(name)
        return paths[name]

    for name in sorted(due):
        path_of(name)
    return {name: paths[name] for name in due}, failed


def reference_names(assembly, present, due):
    """Returns the names of referenced assemblies; missing ones are skipped, as in Unity."""
    if not assembly.asmdef:
        return [] if assembly.name in ("UnityEngine", PACKAGE_ASSEMBLIES[YAHA]) else ["UnityEngine"]
    engine = [] if assembly.asmdef["noEngineReferences"] else [name for name in ("UnityEngine", "UnityEditor") if name in present]
    return engine + [name for name in assembly.asmdef["references"] if name in due or name in present]


def precompiled(tools, assembly, defines):
    if not assembly.asmdef:
        return [tools.nunit] if assembly.name == PACKAGE_ASSEMBLIES[TESTING] else []
    grpc = tools.editor_grpc if EDITOR[0] in defines else tools.grpc
    there = [*(grpc if GRPC[0] in defines else []), *([tools.nunit] if TESTS[0] in defines else [])]
    return [path for path in there if not assembly.asmdef["overrideReferences"] or path.name in assembly.asmdef["precompiledReferences"]]


def expectation_errors(row, compiled):
    """Yields assemblies that were not compiled but should have been, and vice versa."""
    name, platform, defines, _ = row
    has_grpc = GRPC[0] in defines and platform != "WebGL"
    due = {"Sweepstake.Core", "Sweepstake.Unity"} | {n for n in ("Sweepstake.Editor",) if platform == "Editor"}
    due |= {"Sweepstake.GrpcNet"} if has_grpc else set()
    due |= {"Sweepstake.Protocol"} if has_grpc and platform == "Editor" else set()
    due |= {"Sweepstake.Core.Tests", "Sweepstake.Components.Tests"} | ({"Sweepstake.Editor.Tests"} if platform == "Editor" else set()) if TESTS[0] in defines else set()
    due |= {DOCUMENTS} if platform == "Editor" and set(GRPC + NEW_INPUT) <= set(defines) else set()
    never = {"Sweepstake.Editor", "Sweepstake.Editor.Tests", "Sweepstake.Protocol"} if platform != "Editor" else set()
    never |= {"Sweepstake.Protocol", "Sweepstake.GrpcNet"} if not has_grpc else set()
    yield from (f"{name}: {missing} was not compiled" for missing in sorted(due - set(compiled)))
    yield from (f"{name}: {extra} was compiled" for extra in sorted(never & set(compiled)))
    if sum(assembly.startswith("Sweepstake.Samples.") for assembly in compiled) != 5:
        yield f"{name}: the five samples were not all compiled"


def imports_of(path):
    """Returns the name of the native library that the assembly imports; "" if it imports none."""
    content = path.read_bytes()
    return next((name for name in ("sweepstake", "__Internal") if f"\0{name}\0".encode() in content), "")


def import_errors(row, core):
    """Yields an error if Sweepstake.Core imports functions that the link of this build may not find."""
    name, platform, defines, _ = row
    due = {"WebGL": "", "iOS": "__Internal" if IOS_ARCHIVE[0] in defines else ""}.get(platform, "sweepstake")
    if imports_of(core) != due:
        yield f"{name}: Sweepstake.Core imports '{imports_of(core)}', and must import '{due}'"


def main(arguments):
    if len(arguments) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    root, build = (pathlib.Path(argument).resolve() for argument in arguments)
    tools = Toolchain(build)
    compiler = Compiler(tools, build / "dotnet/compile_test")
    package, stubs = package_assemblies(root / PACKAGE), stub_assemblies(root / STUBS)
    package[DOCUMENTS] = document_assembly(root, build / "dotnet/compile_test/documents")
    errors, left_out = [], 0
    for row in ROWS:
        if GRPC[0] in row[2] and not tools.grpc:
            left_out += 1
            continue
        compiled, failed = compile_row(compiler, package, stubs, row)
        errors += [f"{row[0]}: {name} does not compile" for name in failed] + list(expectation_errors(row, compiled))
        errors += import_errors(row, compiled["Sweepstake.Core"]) if "Sweepstake.Core" not in failed else []
    print("\n".join(errors) or f"{len(ROWS) - left_out} rows compile, {compiler.count} compilations")
    if left_out:
        print(f"******** LEFT OUT: {left_out} rows with gRPC, whose libraries were not restored ********")
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
