#!/usr/bin/env python3
"""Fails if the Unity package names an assembly, package, library, namespace or input of others otherwise than its owner does.

    outside_names_test.py ROOT          compares with facts/packages.json and facts/unity_api.txt, and with the NuGet packages that this machine has
    outside_names_test.py --self-test   shows that one wrong letter is found in each kind of name

unity_client/tools/record_facts.py records the facts.
"""

import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

import api_facts

PACKAGE = "unity_client/com.sweepstake.broadphase"
FACTS = "tests/unity_client/facts"
WORKFLOW = ".github/workflows/unity.yml"
# Defines that Unity sets or that tests of packages use, and the package's own, which Setup sets.
CONSTRAINTS = {"UNITY_INCLUDE_TESTS", "SWEEPSTAKE_GRPC"}
PLATFORMS = {"Editor", "WebGL"}
# Packages whose content is part of .NET Standard 2.1.
IN_UNITY = {"System.Buffers", "System.Memory", "System.Numerics.Vectors", "System.Threading.Tasks.Extensions", "NETStandard.Library"}
USING = re.compile(r"^\s*using (?:static )?(?:\w+ = )?([\w.]+);", re.MULTILINE)
QUALIFIED = re.compile(r"\b((?:Cysharp|Grpc|Google|NUnit|UnityEngine|UnityEditor)(?:\.\w+)+)")
DLL = re.compile(r'"([\w.]+\.dll)"')
UPM_NAME = re.compile(r"\bcom\.(?:cysharp|unity|github-glitchenzo)\.[\w.-]+[\w]")
PACKAGE_VERSION = re.compile(r'PackageReference Include="([\w.]+)" Version="([\d.]+)"')


class Known:
    """The recorded names."""

    def __init__(self, root):
        self.facts = json.loads((root / FACTS / "packages.json").read_text(encoding="utf-8"))
        self.api = api_facts.read(root / FACTS / "unity_api.txt")
        self.assemblies = {assembly: name for name, package in self.facts["packages"].items() for assembly in package["assemblies"]}
        self.dlls = {dll: name for name, package in self.facts["nuget"].items() for dll in package["assemblies"]}
        self.types = {line.split("\t")[0].split("<")[0] for section in self.api.values() for lines in section.lines.values() for line in lines}
        self.namespaces = {name.rpartition(".")[0] for name in self.types} | {name for package in self.facts["nuget"].values() for name in package["namespaces"]}

    def modules(self):
        """Returns the packages of the modules that the types of the stub UnityEngine belong to."""
        lines = {line for lines in self.api["UnityEngine"].lines.values() for line in lines}
        names = {f"com.unity.modules.{line.partition(': module ')[2].lower()}" for line in lines if "\t: module " in line}
        return names & self.facts["unity"]["modules"].keys()


def asmdefs(package):
    return {path: json.loads(path.read_text(encoding="utf-8")) for path in sorted(package.rglob("*.asmdef"))}


def asmdef_errors(package, known):
    found = asmdefs(package)
    own = {asmdef["name"] for asmdef in found.values()}
    for path, asmdef in found.items():
        name = path.relative_to(package).as_posix()
        for reference in asmdef["references"]:
            if reference not in own | known.assemblies.keys():
                yield f"{name}: no package has the assembly '{reference}'"
        for dll in asmdef["precompiledReferences"]:
            if dll not in known.dlls:
                yield f"{name}: no NuGet package has '{dll}'"
        for constraint in asmdef["defineConstraints"]:
            if constraint.lstrip("!") not in CONSTRAINTS:
                yield f"{name}: nothing defines '{constraint}'"
        for entry in asmdef["versionDefines"]:
            if entry["name"] not in known.facts["packages"]:
                yield f"{name}: '{entry['name']}' is not a package"
            elif not any(known.assemblies.get(reference) == entry["name"] for reference in asmdef["references"]):
                yield f"{name}: sets {entry['define']} for {entry['name']}, but references no assembly of it"
        for platform in asmdef["includePlatforms"] + asmdef["excludePlatforms"]:
            if platform not in PLATFORMS:
                yield f"{name}: '{platform}' is not a platform"


def manifest_errors(package, known):
    needed = json.loads((package / "package.json").read_text(encoding="utf-8"))["dependencies"]
    for name, version in needed.items():
        versions = [known.facts["unity"]["modules"][name]] if name in known.facts["unity"]["modules"] else known.facts["packages"].get(name, {}).get("versions", [])
        if version not in versions:
            yield f"package.json: '{name}' {version} is not a recorded package"
    modules = {name for name in needed if name.startswith("com.unity.modules.")}
    yield from (f"package.json: the package uses types of {name}" for name in sorted(known.modules() - modules))
    yield from (f"package.json: the package uses no type of {name}" for name in sorted(modules - known.modules()))


def script_errors(package, known):
    """Checks the namespaces that scripts use, and the names of others that they contain."""
    for path in sorted(package.rglob("*.cs")):
        if "Generated" in path.parts:
            continue
        name, text = path.relative_to(package).as_posix(), path.read_text(encoding="utf-8-sig")
        for used in USING.findall(text):
            if not (used in known.namespaces | known.types or used.split(".")[0] in ("System", "Sweepstake", "AOT")):
                yield f"{name}: the namespace '{used}' is not known"
        for qualified in QUALIFIED.findall(text):
            if not is_known(qualified, known):
                yield f"{name}: '{qualified}' is not known"
        yield from (f"{name}: no NuGet package has '{dll}'" for dll in DLL.findall(text) if dll not in known.dlls and not dll.startswith("sweepstake"))


def is_known(qualified, known):
    """A namespace, a type, a member of one, an assembly or an assembly's file."""
    everything = known.namespaces | known.types | known.assemblies.keys() | known.dlls.keys() | known.facts["nuget"].keys()
    return any(part in everything for part in (qualified, qualified.rpartition(".")[0]))


def text_errors(root, package, known):
    """Checks the names of packages in documents and scripts."""
    registry = {f"{known.facts['registry']['scope']}.{name.lower()}" for name in known.facts["registry"]["lowest"]}
    for path in sorted([*package.rglob("*.md"), *package.rglob("*.cs"), root / "unity_client/README.md"]):
        text = path.read_text(encoding="utf-8-sig")
        for name in UPM_NAME.findall(text):
            if name not in known.facts["packages"] | known.facts["unity"]["modules"]:
                yield f"{path.name}: '{name}' is not a package"
        yield from (f"{path.name}: the registry does not list '{name}'" for name in re.findall(r"\borg\.nuget\.[\w.]+\w", text) if name not in registry)
        for repository, folder, version in re.findall(r"github\.com/([\w-]+/[\w.-]+?)\.git\?path=/?([\w./-]+)(?:#([\w.]+))?", text):
            found = [entry["versions"] for entry in known.facts["packages"].values() if (entry["repository"], entry["folder"]) == (repository, folder)]
            if not any(version in (*versions, "") for versions in found):
                yield f"{path.name}: {repository} has no package in '{folder}' {version}"


def stub_errors(root, known):
    """A stub must not replace a library that the tests can use, and is named like the real assembly."""
    for path in sorted((root / "unity_client/dotnet/stubs/packages").glob("*.cs")):
        if path.stem not in known.assemblies:
            yield f"the stub {path.name} is not named like an assembly of a package"
        if path.stem + ".dll" in known.dlls:
            yield f"the stub {path.name} replaces a library of NuGet"
    for path in sorted((root / "unity_client/dotnet").rglob("*.csproj")):
        for name, version in PACKAGE_VERSION.findall(path.read_text(encoding="utf-8")):
            if name in known.facts["nuget"] and known.facts["nuget"][name]["version"] != version:
                yield f"{path.name}: uses {name} {version}, but {known.facts['nuget'][name]['version']} is recorded"


def setup_errors(package, known):
    """Setup must list all libraries that gRPC and the HTTP handler need, and no other."""
    text = (package / "Editor/Setup/SetupChecks.cs").read_text(encoding="utf-8")
    handler = known.facts["packages"]["com.cysharp.yetanotherhttphandler.dependencies"]["dependencies"]
    upm = {f"{known.facts['registry']['scope']}.{name.lower()}": name for name in known.facts["nuget"]}
    for array, roots in (("GrpcAssemblies", ["Grpc.Net.Client", "Google.Protobuf"]), ("HandlerAssemblies", [upm[name] for name in handler])):
        listed = set(re.findall(r'"([\w.]+)"', re.search(rf"{array} =\s*\{{(.*?)\}};", text, re.DOTALL)[1]))
        needed = closure(roots, known.facts["nuget"])
        yield from (f"SetupChecks.cs: {array} lacks '{name}'" for name in sorted(needed - listed))
        yield from (f"SetupChecks.cs: {array} lists '{name}', which nothing needs" for name in sorted(listed - needed))
    links = set(re.findall(r'"https://github\.com/([\w-]+/[\w.-]+)"', text))
    expected = {known.facts["packages"][name]["repository"] for name in ("com.cysharp.yetanotherhttphandler", "com.github-glitchenzo.nugetforunity")} | {known.facts["registry"]["repository"]}
    if links != expected:
        yield f"SetupChecks.cs: links {sorted(links)}, not {sorted(expected)}"


def closure(roots, packages):
    """Returns the NuGet packages that these need, without those that Unity's .NET Standard contains."""
    found, due = set(), list(roots)
    while due:
        name = due.pop()
        if name not in found | IN_UNITY:
            found.add(name)
            due += packages[name]["dependencies"]
    return found


def workflow_errors(root, known):
    action = known.facts["action"]
    text = (root / WORKFLOW).read_text(encoding="utf-8")
    steps = re.findall(rf"uses: {re.escape(action['repository'])}@\w+  # (\S+)\n((?:\s+(?:#.*|with:|env:|[\w-]+:.*)\n)*)", text)
    if not steps:
        yield f"{WORKFLOW}: does not use {action['repository']}"
    for version, body in steps:
        if version.split(".")[0] != action["version"].split(".")[0]:
            yield f"{WORKFLOW}: uses {action['repository']} {version}, but {action['version']} is recorded"
        given = body.partition("with:")[2]
        yield from (f"{WORKFLOW}: {action['repository']} has no input '{name}'" for name in re.findall(r"^\s+(\w+):", given, re.MULTILINE) if name not in action["inputs"])
    editors = {version.rpartition(".")[0] for version in re.findall(r"^\s*-? ?\"?((?:2022|6000)\.\d+\.\d+f\d+)", text, re.MULTILINE)}
    if editors != {"2022.3", "6000.0", "6000.5"}:
        yield f"{WORKFLOW}: runs {', '.join(sorted(editors)) or 'no editor'}, not 2022.3, 6000.0 and 6000.5"


def nuget_errors(known):
    """Compares the facts with the NuGet packages of this machine; returns the number of compared packages and the errors."""
    if not shutil.which("dotnet"):
        return 0, []
    listed = subprocess.run(["dotnet", "nuget", "locals", "global-packages", "--list"], capture_output=True, text=True, check=True).stdout
    folder, count, errors = pathlib.Path(listed.split(":", 1)[1].strip()), 0, []
    for name, package in known.facts["nuget"].items():
        at = folder / name.lower() / package["version"]
        if not at.is_dir():
            continue
        count += 1
        dlls = sorted(path.name for path in (at / "lib" / package["target"]).glob("*.dll"))
        if dlls != package["assemblies"]:
            errors.append(f"{name} {package['version']} has {dlls}, but {package['assemblies']} is recorded")
        nuspec = xml.etree.ElementTree.parse(at / f"{name.lower()}.nuspec").getroot()
        known_ids = {dependency.get("id") for dependency in nuspec.iterfind(".//{*}dependency")}
        errors += [f"{name} does not depend on {other}" for other in package["dependencies"] if other not in known_ids]
    return count, errors


def check(root):
    package, known = root / PACKAGE, Known(root)
    return [*asmdef_errors(package, known), *manifest_errors(package, known), *script_errors(package, known), *text_errors(root, package, known), *setup_errors(package, known),
            *stub_errors(root, known), *workflow_errors(root, known)]


def change(root, name, old, new):
    path = root / name
    text = path.read_text(encoding="utf-8")
    assert old in text, f"{name} has no '{old}'"
    path.write_text(text.replace(old, new, 1), encoding="utf-8")


UNITY_ASMDEF = f"{PACKAGE}/Runtime/Unity/Sweepstake.Unity.asmdef"
# A file, a name in it, a wrong spelling, and a part of the error that it must cause.
BAD = [
    (UNITY_ASMDEF, "Cysharp.Net.Http.YetAnotherHttpHandler", "Cysharp.Net.Http.YetAnotherHttpHandle", "no package has the assembly"),
    (UNITY_ASMDEF, "com.cysharp.yetanotherhttphandler", "com.cysharp.yetanotherhttphandle", "is not a package"),
    (UNITY_ASMDEF, '"Cysharp.Net.Http.YetAnotherHttpHandler"', '"Unity.Burst"', "references no assembly of it"),
    (f"{PACKAGE}/Runtime/GrpcNet/Sweepstake.GrpcNet.asmdef", "Grpc.Net.Client.dll", "Grpc.Net.Clien.dll", "no NuGet package has"),
    (f"{PACKAGE}/Runtime/GrpcNet/Sweepstake.GrpcNet.asmdef", '"SWEEPSTAKE_GRPC"', '"SWEEPSTAKE_GPRC"', "nothing defines"),
    (f"{PACKAGE}/Runtime/GrpcNet/Sweepstake.GrpcNet.asmdef", '"WebGL"', '"WebGl"', "is not a platform"),
    (f"{PACKAGE}/package.json", "com.unity.modules.physics", "com.unity.modules.physic", "is not a recorded package"),
    (f"{PACKAGE}/package.json", '    "com.unity.modules.imgui": "1.0.0",\n', "", "uses types of com.unity.modules.imgui"),
    (f"{PACKAGE}/package.json", '"com.unity.modules.imgui"', '"com.unity.modules.audio"', "uses no type of com.unity.modules.audio"),
    (f"{PACKAGE}/Editor/Setup/SetupWindow.cs", "using UnityEditor.Compilation;", "using UnityEditor.Compilations;", "the namespace 'UnityEditor.Compilations'"),
    (f"{PACKAGE}/Editor/Setup/SetupChecks.cs", "Grpc.Net.Common", "Grpc.Net.Comon", "Grpc.Net.Comon"),
    (f"{PACKAGE}/Runtime/Unity/Session/DaemonTransport.cs", "new Cysharp.Net.Http.YetAnother", "new Cysharp.Net.Http.Yet.Another", "is not known"),
    (f"{PACKAGE}/Documentation~/daemon.md", "com.cysharp.yetanotherhttphandler", "com.cysharp.yetanotherhttphandlers", "is not a package"),
    (f"{PACKAGE}/Editor/Setup/SetupChecks.cs", "path=src/YetAnotherHttpHandler", "path=source/YetAnotherHttpHandler", "has no package in"),
    (f"{PACKAGE}/Editor/Setup/SetupChecks.cs", '"System.Diagnostics.DiagnosticSource", ', "", "lacks 'System.Diagnostics.DiagnosticSource'"),
    (f"{PACKAGE}/Editor/Setup/SetupChecks.cs", "GlitchEnzo/NuGetForUnity\"", "GlitchEnzo/NugetForUnity\"", "links"),
    ("unity_client/dotnet/grpc_net/Sweepstake.GrpcNet.csproj", "2.85.0", "2.61.0", "but 2.85.0 is recorded"),
    (WORKFLOW, "packageMode:", "packagesMode:", "has no input 'packagesMode'"),
    (WORKFLOW, "6000.5.", "6000.4.", "not 2022.3, 6000.0 and 6000.5"),
]


def self_test(root):
    missed = []
    for name, old, new, error in BAD:
        with tempfile.TemporaryDirectory() as folder:
            copy = pathlib.Path(folder)
            for tree in ("unity_client", FACTS, ".github"):
                shutil.copytree(root / tree, copy / tree)
            change(copy, name, old, new)
            errors = check(copy)
            if not any(error in found for found in errors):
                missed.append(f"'{new}' in {name} did not cause '{error}', but: {errors}")
    return missed


def main(arguments):
    if arguments == ["--self-test"]:
        errors = self_test(pathlib.Path(__file__).resolve().parents[2])
        print("\n".join(errors) or f"{len(BAD)} wrong names were each found")
    elif len(arguments) == 1:
        root = pathlib.Path(arguments[0]).resolve()
        count, errors = nuget_errors(Known(root))
        errors = check(root) + errors
        print("\n".join(errors) or f"all outside names are known; {count} NuGet packages of this machine match the facts")
    else:
        print(__doc__, file=sys.stderr)
        return 2
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
