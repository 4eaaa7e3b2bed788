#!/usr/bin/env python3
"""Records names and signatures of Unity and of other packages, which tests/unity_client compares with this package and with its stubs.

    record_facts.py ROOT BUILD SOURCES      writes tests/unity_client/facts/{unity_api.txt,packages.json}

BUILD is a build folder in which tests/unity_client/dotnet_test.sh has restored the projects. SOURCES has a clone, or a bare clone, of each
repository below, called OWNER+NAME or OWNER+NAME/repo. The facts are names, signatures, versions and GUIDs; no text or code is copied.
"""

import json
import pathlib
import re
import subprocess
import sys
import tarfile
import tempfile
import xml.etree.ElementTree

FACTS = "tests/unity_client/facts"
UNITY = "Unity-Technologies/UnityCsReference"
UNITY_VERSIONS = ["2022.3.76f1", "6000.0.78f1", "6000.5.2f1", "6000.7.0a1"]
# The repository, the package's folder in it, its oldest and newest tag in use, and the licence.
COMPANION = "Unity Companion License"
PACKAGES = {
    "com.cysharp.yetanotherhttphandler": ("Cysharp/YetAnotherHttpHandler", "src/YetAnotherHttpHandler", ["v1.0.0", "1.11.5"], "MIT"),
    "com.cysharp.yetanotherhttphandler.dependencies": ("Cysharp/YetAnotherHttpHandler", "src/YetAnotherHttpHandler.Dependencies", ["1.11.5"], "MIT"),
    "com.github-glitchenzo.nugetforunity": ("GlitchEnzo/NuGetForUnity", "src/NuGetForUnity", ["v4.5.0"], "MIT"),
    "com.unity.burst": ("needle-mirror/com.unity.burst", "", ["1.6.0-pre.2"], COMPANION),
    "com.unity.collections": ("needle-mirror/com.unity.collections", "", ["2.6.6"], COMPANION),
    "com.unity.inputsystem": ("Unity-Technologies/InputSystem", "Packages/com.unity.inputsystem", ["1.0.0", "1.11.2"], COMPANION),
    "com.unity.mathematics": ("needle-mirror/com.unity.mathematics", "", ["1.3.3"], COMPANION),
    "com.unity.profiling.core": ("needle-mirror/com.unity.profiling.core", "", ["1.0.2"], COMPANION),
    "com.unity.test-framework": ("needle-mirror/com.unity.test-framework", "", ["1.4.6"], COMPANION),
}
# The project names the NuGet packages and their versions.
RESTORED_BY = "unity_client/dotnet/facts/Sweepstake.Facts.csproj"
ACTION = ("game-ci/unity-test-runner", "v4.3.1")
REGISTRY = ("xoofx/UnityNuGet", "HEAD")
# The assembly of each stub belongs to the package or is part of Unity.
STUB_PACKAGES = {"Cysharp.Net.Http.YetAnotherHttpHandler": "com.cysharp.yetanotherhttphandler", "Unity.Burst": "com.unity.burst",
                 "Unity.InputSystem": "com.unity.inputsystem", "Unity.Profiling.Core": "com.unity.profiling.core",
                 "UnityEngine.TestRunner": "com.unity.test-framework"}
# What the source lacks or does not show: the documentation's page (docs.unity3d.com) and what it says. UnityAction is generated.
DOCUMENTED = {
    # ScriptReference/Events.UnityAction_2, 2020.2 and 6000.7
    "UnityEngine.Events.UnityAction<T0, T1>\t: delegate void(T0 arg0, T1 arg1)": "",
    "UnityEngine.Events.UnityAction<T0, T1>\t: module Core": "",
    "UnityEngine.SceneManagement.SceneManager\tsceneLoaded : static event UnityEngine.Events.UnityAction<UnityEngine.SceneManagement.Scene, UnityEngine.SceneManagement.LoadSceneMode>": "",
    # ScriptReference/GameObject-isStatic, 2018.1: editor only, although players compile it
    "UnityEngine.GameObject\tisStatic : bool get": " @editor",
    "UnityEngine.GameObject\tisStatic : bool set": " @editor",
}
COMPILE_ITEM = re.compile(r'<Compile Include="([^"]+)"')
DEFINES = re.compile(r"DefineConstants>\$\(DefineConstants\);([^<]*)<")
MODULE = re.compile(r'"(com\.unity\.modules\.\w+)": *"([\d.]+)"')


class Sources:
    def __init__(self, folder):
        self.folder = folder

    def repository(self, name):
        for found in (self.folder / name.replace("/", "+") / "repo", self.folder / name.replace("/", "+")):
            if found.is_dir():
                return found
        raise SystemExit(f"record_facts.py: {self.folder} has no clone of {name}")

    def git(self, name, *arguments):
        return subprocess.run(["git", "-C", str(self.repository(name)), *arguments], capture_output=True, text=True, check=True).stdout

    def text(self, name, tag, path):
        return self.git(name, "show", f"{tag}:{path}").removeprefix("\ufeff")

    def files(self, name, tag, folder, suffix):
        listed = self.git(name, "ls-tree", "-r", "--name-only", tag, *([folder + "/"] if folder else [])).splitlines()
        return [path for path in listed if path.endswith(suffix)]

    def extract(self, name, tag, target, folders, suffixes):
        archive = subprocess.Popen(["git", "-C", str(self.repository(name)), "archive", tag, *folders], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        with tarfile.open(fileobj=archive.stdout, mode="r|") as packed:
            for member in packed:
                if member.isfile() and member.name.endswith(suffixes):
                    packed.extract(member, target, filter="data")
        if archive.wait():
            raise SystemExit(f"record_facts.py: {name} has no {tag} with {' '.join(folders)}")


class UnityApi:
    """Lists types of one version of Unity."""

    def __init__(self, sources, version, folder, lister, framework):
        self.root, self.lister, self.framework = folder, lister, framework
        sources.extract(UNITY, version, folder, [":(glob)**/*.cs", "Projects/CSharp"], (".cs", ".csproj"))

    def arguments(self, is_editor):
        """The sources and defines of Unity's own project files; a player has no UNITY_EDITOR."""
        items, defines = [], []
        for project in ("UnityEngine", "UnityEditor") if is_editor else ("UnityEngine",):
            text = (self.root / f"Projects/CSharp/{project}.csproj").read_text(encoding="utf-8-sig")
            items += COMPILE_ITEM.findall(text)
            defines += DEFINES.search(text)[1].split(";")
        paths = dict.fromkeys((self.root / "Projects/CSharp" / item.replace("\\", "/")).resolve() for item in items)
        yield from (f"define {define}" for define in sorted(set(defines)) if is_editor or not define.startswith("UNITY_EDITOR"))
        yield from (f"source {path}" for path in paths)
        yield from (f"reference {path}" for path in self.framework)
        yield f"root {self.root}"

    def lines(self, types, is_editor, more=()):
        return set(self.lister.lines([*self.arguments(is_editor), *more, *types]))


def stub_lines(root, build):
    """Returns for each stub assembly the lines "type NAME" and the lines of its API."""
    printed = subprocess.run([sys.executable, str(root / "tests/unity_client/stubs_test.py"), str(root), str(build), "--lines"], capture_output=True, text=True, check=True).stdout
    found = {}
    for line in printed.splitlines():
        if line.startswith("["):
            types, lines = found[line[1:-1]] = [], []
        else:
            (lines if "\t" in line else types).append(line)
    return found


def mark(holds, versions, kinds):
    """Returns the mark of a line that holds for these pairs of version and kind; None if it never holds."""
    with_it = [version for version in versions if any((version, kind) in holds for kind in kinds)]
    if not with_it:
        return None
    first, last = versions.index(with_it[0]), versions.index(with_it[-1])
    if len(with_it) != last - first + 1:
        raise SystemExit(f"record_facts.py: an API came, went and came again: {with_it}")
    only_editor = "player" in kinds and not any((version, "player") in holds for version in with_it)
    since = f"{versions[first]}" if first else ""
    until = f"{versions[last]}" if last < len(versions) - 1 else ""
    return (f" @{since}..{until}" if since and until else f" @{since}+" if since else f" @-{until}" if until else "") + (" @editor" if only_editor else "")


def section(name, source, versions, kinds, stub, listed):
    """Yields the section of a stub assembly; `listed` has the API of each version and kind."""
    yield f"[{name} {source} {' '.join(versions)}]"
    needed = set(stub) | {line for lines in listed.values() for line in lines if "\t: module " in line}
    found = {}
    for line in needed:
        documented = DOCUMENTED.get(line)
        holds = mark({key for key, lines in listed.items() if line in lines}, versions, kinds)
        if documented is not None:
            found[line] = documented + " @documented"
        elif holds is not None:
            found[line] = holds
        else:
            kind, member = line.split("\t")
            word = re.match(r"[:\w\[]+", member)[0]
            like = {other for lines in listed.values() for other in lines if other.startswith(f"{kind}\t{word}")}
            print(f"{name}: the stub's '{line.replace(chr(9), ' ')}' does not exist; Unity has: {' | '.join(sorted(like)) or 'nothing'}", file=sys.stderr)
    kind = None
    for line in sorted(found):
        if line.split("\t")[0] != kind:
            kind = line.split("\t")[0]
            yield kind
        yield "  " + line.split("\t")[1] + found[line]


def unity_api(root, build, sources, lister, framework):
    stubs = stub_lines(root, build)
    wanted = [kind for name in ("UnityEngine", "UnityEditor") for kind in stubs[name][0]]
    yield "# Written by unity_client/tools/record_facts.py; tests/unity_client/api_facts.py describes the format."
    yield "# Facts about interfaces, taken from Unity's C# reference source (Unity Reference-Only License) and from packages; see packages.json."
    listed = {}
    with tempfile.TemporaryDirectory() as folder:
        for version in UNITY_VERSIONS:
            api = UnityApi(sources, version, pathlib.Path(folder).resolve() / version, lister, framework)
            for kind in ("editor", "player"):
                listed[version, kind] = api.lines(wanted, kind == "editor")
        yield from section("UnityEngine", UNITY, UNITY_VERSIONS, ["editor", "player"], stubs["UnityEngine"][1],
                           {key: {line for line in lines if not line.startswith(("UnityEditor.", "Unity.Profiling.Editor."))} for key, lines in listed.items()})
        yield from section("UnityEditor", UNITY, UNITY_VERSIONS, ["editor"], stubs["UnityEditor"][1],
                           {key: {line for line in lines if line.startswith(("UnityEditor.", "Unity.Profiling.Editor."))} for key, lines in listed.items() if key[1] == "editor"})
        for name, package in sorted(STUB_PACKAGES.items()):
            yield from package_section(name, package, stubs[name], sources, api, pathlib.Path(folder))


def package_section(name, package, stub, sources, api, folder):
    """Compiles the package's sources together with the newest Unity's, whose types they use."""
    repository, path, tags, _ = PACKAGES[package]
    listed = {}
    for tag in tags:
        target = folder / package / tag
        sources.extract(repository, tag, target, [f":(glob){path + '/' if path else ''}**/*.cs"], (".cs",))
        files = [f"source {file}" for file in target.rglob("*.cs") if "Tests" not in file.parts and "Editor" not in file.parts]
        defines = [f"define {define}" for define in ("UNITY_5_3_OR_NEWER", "UNITY_2021_3_OR_NEWER", "UNITY_2022_3_OR_NEWER", "ENABLE_PROFILER")]
        listed[tag, "editor"] = {line for line in api.lines(stub[0], False, [*defines, *files]) if "\t: module " not in line}
    yield from section(name, package, tags, ["editor"], stub[1], listed)


def assemblies(sources, repository, tag, folder):
    """Returns the GUIDs of the package's assembly definitions by assembly name, without tests and samples."""
    found = {}
    for path in sources.files(repository, tag, folder, ".asmdef"):
        if not re.search(r"(^|/)(Samples~|source~|\w*\.?Tests(\.\w+)?|\w+\.PerformanceTests)/", path.removeprefix(folder)):
            guid = re.search(r"^guid: (\w+)", sources.text(repository, tag, path + ".meta"), re.MULTILINE)[1]
            found[json.loads(sources.text(repository, tag, path))["name"]] = guid
    return found


def upm_package(sources, name):
    repository, folder, tags, licence = PACKAGES[name]
    at = f"{folder}/" if folder else ""
    manifest = json.loads(sources.text(repository, tags[-1], at + "package.json"))
    if manifest["name"] != name:
        raise SystemExit(f"record_facts.py: {repository} is {manifest['name']}, not {name}")
    found = assemblies(sources, repository, tags[-1], folder)
    for tag in tags[:-1]:
        found = {name: guid for name, guid in found.items() if assemblies(sources, repository, tag, folder).get(name) == guid}
    return {"repository": repository, "folder": folder, "versions": tags, "licence": licence, "dependencies": manifest.get("dependencies", {}), "assemblies": found}


def nuget_package(name, version, packages, lister):
    folder = packages / name.lower() / version
    nuspec = xml.etree.ElementTree.parse(folder / f"{name.lower()}.nuspec").getroot()
    target = next(target for target in ("netstandard2.1", "netstandard2.0") if (folder / "lib" / target).is_dir())
    groups = {re.sub(r"^\.?NETStandard", "netstandard", group.get("targetFramework")): group for group in nuspec.iterfind(".//{*}dependencies/{*}group")}
    needs = {dependency.get("id"): dependency.get("version") for dependency in groups.get(target, ())}
    dlls = sorted(path.name for path in (folder / "lib" / target).glob("*.dll"))
    namespaces = set()
    for dll in dlls:
        names = [line.split(" ")[1] for line in lister.lines([f"assembly {folder / 'lib' / target / dll}"]) if line.startswith("type ")]
        namespaces |= {name.rpartition(".")[0] for name in names if "+" not in name and "." in name}
    return {"version": version, "target": target, "dependencies": needs, "assemblies": dlls, "namespaces": sorted(namespaces)}


def modules(sources):
    found = {}
    for name in {repository for repository, _, _, _ in PACKAGES.values()} | {ACTION[0]}:
        for path in sources.files(name, "HEAD", "", ("package.json", "manifest.json")):
            found |= dict(MODULE.findall(sources.text(name, "HEAD", path)))
    return dict(sorted(found.items()))


def action(sources):
    name, tag = ACTION
    text = sources.text(name, tag, "action.yml").split("\ninputs:")[1].split("\noutputs:")
    return {"repository": name, "version": tag, "licence": "MIT", "inputs": re.findall(r"^  (\w+):$", text[0], re.MULTILINE), "outputs": re.findall(r"^  (\w+):", text[1].split("\nbranding")[0], re.MULTILINE)}


def registry(sources, nuget):
    name, tag = REGISTRY
    listed = {package.lower(): entry["version"] for package, entry in json.loads(sources.text(name, tag, "registry.json")).items() if entry.get("listed")}
    return {"repository": name, "commit": sources.git(name, "rev-parse", tag).strip(), "licence": "BSD-2-Clause", "scope": "org.nuget",
            "lowest": {package: listed[package.lower()] for package in nuget if package.lower() in listed}}


def packages_facts(root, sources, lister, packages):
    nuget = dict(re.findall(r'Include="([\w.]+)" Version="([\d.]+)"', (root / RESTORED_BY).read_text(encoding="utf-8")))
    return {"unity": {"repository": UNITY, "versions": UNITY_VERSIONS, "licence": "Unity Reference-Only License", "modules": modules(sources)},
            "packages": {name: upm_package(sources, name) for name in PACKAGES},
            "nuget": {name: nuget_package(name, version, packages, lister) for name, version in nuget.items()},
            "action": action(sources), "registry": registry(sources, nuget)}


def json_lines(facts):
    """Returns JSON with a line per entry of each part."""
    parts = [f' "{name}": {{\n' + ",\n".join(f"  {json.dumps(key)}: {json.dumps(value)}" for key, value in part.items()) + "\n }" for name, part in facts.items()]
    return "{\n" + ",\n".join(parts) + "\n}\n"


def main(arguments):
    if len(arguments) != 3:
        print(__doc__, file=sys.stderr)
        return 2
    root, build, folder = (pathlib.Path(argument).resolve() for argument in arguments)
    sys.path.insert(0, str(root / "tests/unity_client"))
    import api_facts  # noqa: PLC0415
    import compile_test  # noqa: PLC0415
    tools, sources, lister = compile_test.Toolchain(build), Sources(folder), api_facts.Lister(root, build)
    written = root / FACTS
    written.mkdir(exist_ok=True)
    (written / "packages.json").write_text(json_lines(packages_facts(root, sources, lister, tools.packages)), encoding="utf-8")
    (written / "unity_api.txt").write_text("".join(f"{line}\n" for line in unity_api(root, build, sources, lister, [*tools.framework, tools.nunit])), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
