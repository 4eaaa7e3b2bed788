#!/usr/bin/env python3
"""Fails if the Unity package breaks a rule of Unity's own validation, or if its documents are wrong.

    package.json    name, version (equal to the CMake project, the commit's tag and the tag in the documents), Unity 2022.3; samples exist
    .meta           each asset has one, each belongs to an asset, each GUID is unique; an installed plug-in has one
    .asmdef         named like its file, references exist, gRPC needs SWEEPSTAKE_GRPC, no engine outside Runtime/Unity, Editor for the editor
    samples         each folder is in the manifest and has an assembly and a scene; scenes use only the package's scripts
    CHANGELOG.md    format of Keep a Changelog, newest first, begins with the package's version or with Unreleased
    paths           at most 140 characters; no link.xml, which Unity ignores in packages; no .NET library
    privacy.md      names each field that a game and the editor's window send, and no other
    proven.md       has its points once and in order, among them 1 to 47, with an existing test or with steps; the quick start has at most six steps
    links           links in the documents lead to files; the menus, fields, files and API names in them exist (document_names.py)

    package_test.py ROOT          checks the tree at ROOT
    package_test.py --self-test   shows that each rule can fail
"""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest.mock

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "unity_client" / "tools"))
import document_names  # noqa: E402
import make_metas  # noqa: E402

PACKAGE = "unity_client/com.sweepstake.broadphase"
MAX_PATH = 140
ENGINE_FREE = ("Runtime/Core", "Runtime/GrpcNet", "Editor/Generated")
GRPC = ("Runtime/GrpcNet", "Editor/Generated")
# The assemblies of other packages, which unity_client/tools/record_facts.py recorded.
FACTS = json.loads((pathlib.Path(__file__).parent / "facts/packages.json").read_text(encoding="utf-8"))
KNOWN_REFERENCES = {assembly for package in FACTS["packages"].values() for assembly in package["assemblies"]}
VERSION_HEADING = re.compile(r"^## \[(Unreleased|\d+\.\d+\.\d+)\](?: - \d{4}-\d\d-\d\d)?$")
HEADING = re.compile(r"^## .*$", re.MULTILINE)
LINK = re.compile(r"\]\(([^)#\s]+)[^)]*\)")
PROTO_MESSAGE = re.compile(r"^message (\w+) \{(.*?)^\}", re.MULTILINE | re.DOTALL)
PROTO_FIELD = re.compile(r"^\s*(?:repeated |optional )?([\w.]+) (\w+) = \d+;", re.MULTILINE)
INSTALLED_TAG = re.compile(r"#v(\d+\.\d+\.\d+)")
PRIVACY_FIELD = re.compile(r"^\| `(\w+\.\w+)` \|", re.MULTILINE)
# The messages that a game and the editor's window send.
SENT_MESSAGES = ("StreamTelemetryRequest", "WatchPosteriorsRequest", "ListPosteriorsRequest")
POINTS = 47
POINT = re.compile(r"^\| (\d+) \|([^|]+)\|([^|]*)\|([^|]*)\|$", re.MULTILINE)
TEST_NAME = re.compile(r"`(\w+Test)(?:\.(\w+))?`")
STEP = re.compile(r"^- \*\*([A-Z])\*\*", re.MULTILINE)
SCENE_SCRIPT = re.compile(r"m_Script: \{fileID: 11500000, guid: (\w+), type: 3\}")
MAX_QUICK_START_STEPS = 6


def json_of(path):
    return json.loads(path.read_text(encoding="utf-8"))


def manifest_errors(root, package):
    manifest = json_of(package / "package.json")
    version = re.search(r"project\(sweepstake VERSION ([\d.]+)", (root / "CMakeLists.txt").read_text(encoding="utf-8"))[1]
    if manifest.get("name") != package.name:
        yield f"package.json: the name is not {package.name}"
    if manifest.get("version") != version:
        yield f"package.json: the version is not {version}, the project's"
    if manifest.get("unity") != "2022.3":
        yield "package.json: the lowest Unity is 2022.3"
    for key in ("displayName", "description", "author", "license"):
        if not manifest.get(key):
            yield f"package.json: '{key}' is missing"
    for sample in manifest.get("samples", []):
        if not (package / sample["path"]).is_dir():
            yield f"package.json: the sample {sample['path']} does not exist"


def commit_errors(root, package):
    """Checks the tags of the commit; a tree without its history has none."""
    if not (root / ".git").exists():
        return
    try:
        asked = subprocess.run(["git", "-C", str(root), "tag", "--points-at", "HEAD", "v*"], capture_output=True, text=True, check=True)
    except subprocess.CalledProcessError as problem:
        yield f"git cannot list the tags of the commit: {problem.stderr.strip()}"
    except OSError as problem:
        yield f"git cannot be started to list the tags of the commit ({problem.strerror}): install it, and add its folder to PATH"
    else:
        yield from release_errors(package, asked.stdout.split())


def release_errors(package, tags):
    version = json_of(package / "package.json")["version"]
    yield from (f"the commit's tag is {tag}, and package.json's version {version}" for tag in tags if tag != f"v{version}")
    latest = HEADING.search((package / "CHANGELOG.md").read_text(encoding="utf-8"))
    if tags and not (latest and re.fullmatch(rf"## \[{re.escape(version)}\] - \d{{4}}-\d\d-\d\d", latest[0])):
        yield f"CHANGELOG.md: a release must begin with '## [{version}] - ' and its date"


def tag_errors(root, package):
    version = json_of(package / "package.json")["version"]
    named = [(page.name, tag) for page in sorted((root / "unity_client").rglob("*.md")) for tag in INSTALLED_TAG.findall(page.read_text(encoding="utf-8"))]
    if not named:
        yield "no document describes the installation of a release by its tag, #v1.2.3"
    yield from (f"{name}: the tag #v{tag} does not match the version {version}" for name, tag in named if tag != version)


def changelog_errors(package):
    text = (package / "CHANGELOG.md").read_text(encoding="utf-8")
    if not text.startswith("# Changelog\n"):
        yield "CHANGELOG.md: the first line must be '# Changelog'"
    headings = [line for line in text.splitlines() if line.startswith("## ")]
    if not headings:
        yield "CHANGELOG.md: the versions are missing"
    for heading in headings:
        if not VERSION_HEADING.match(heading):
            yield f"CHANGELOG.md: '{heading}' is not '## [1.2.3] - 2026-01-31' or '## [Unreleased]'"
    versions = [tuple(map(int, match[1].split("."))) for heading in headings if (match := VERSION_HEADING.match(heading)) and match[1] != "Unreleased"]
    if versions != sorted(versions, reverse=True):
        yield "CHANGELOG.md: the newest version must come first"
    version = json_of(package / "package.json")["version"]
    if headings and headings[0] != "## [Unreleased]" and not headings[0].startswith(f"## [{version}]"):
        yield f"CHANGELOG.md: begins with neither '## [Unreleased]' nor {version}, package.json's version"
    if versions and versions[0] > tuple(map(int, version.split("."))):
        yield f"CHANGELOG.md: has a version after {version}, package.json's"


def asmdef_errors(package):
    paths = sorted(package.rglob("*.asmdef"))
    names = {path.stem for path in paths}
    for path in paths:
        name, asmdef = path.relative_to(package).as_posix(), json_of(path)
        if asmdef["name"] != path.stem:
            yield f"{name}: the assembly is called '{asmdef['name']}'; it must be named like its file"
        if asmdef["includePlatforms"] and asmdef["excludePlatforms"]:
            yield f"{name}: must not both include and exclude platforms"
        for reference in asmdef["references"]:
            if reference not in names | KNOWN_REFERENCES:
                yield f"{name}: '{reference}' is not an assembly"
        if name.startswith(ENGINE_FREE) and not asmdef["noEngineReferences"]:
            yield f"{name}: must not reference UnityEngine"
        if name.startswith("Editor/") and asmdef["includePlatforms"] != ["Editor"]:
            yield f"{name}: must include the editor only"
        if not name.startswith("Editor/") and "Google.Protobuf.dll" in asmdef["precompiledReferences"]:
            yield f"{name}: a player must not need Google.Protobuf"
        if name.startswith(GRPC) and asmdef["defineConstraints"] != ["SWEEPSTAKE_GRPC"]:
            yield f"{name}: does not compile without the libraries of gRPC; add the constraint SWEEPSTAKE_GRPC"


def sample_errors(package):
    listed = {sample["path"] for sample in json_of(package / "package.json").get("samples", [])}
    scripts = {make_metas.GUID.search(meta.read_text(encoding="utf-8"))[1] for meta in package.rglob("*.cs.meta")}
    for folder in sorted(path for path in (package / "Samples~").iterdir() if path.is_dir()):
        name = folder.relative_to(package).as_posix()
        if name not in listed:
            yield f"package.json: the sample {name} is not listed"
        if not list(folder.glob("*.asmdef")) or not list(folder.glob("*.unity")):
            yield f"{name}: a sample must have an assembly and a scene"
        for scene in sorted(folder.glob("*.unity")):
            for guid in SCENE_SCRIPT.findall(scene.read_text(encoding="utf-8")):
                if guid not in scripts:
                    yield f"{scene.relative_to(package).as_posix()}: the script {guid} is not the package's"


def path_errors(package):
    for path in sorted(package.rglob("*")):
        name = path.relative_to(package).as_posix()
        if len(f"{package.name}/{name}") > MAX_PATH:
            yield f"{name}: the path has more than {MAX_PATH} characters"
        if path.name == "link.xml":
            yield f"{name}: Unity ignores it in a package"
        if path.suffix == ".dll" and not make_metas.template(name).is_file():
            yield f"{name}: a .NET library would conflict with another copy in the project"


def document_errors(package):
    for name in ("LICENSE.md", "Third Party Notices.md", "README.md", "Documentation~/index.md"):
        if not (package / name).is_file():
            yield f"{name} is missing"
    for path in sorted(package.rglob("*.md")):
        for link in LINK.findall(path.read_text(encoding="utf-8")):
            if "://" not in link and not (path.parent / link).exists():
                yield f"{path.relative_to(package).as_posix()}: the link to {link} leads nowhere"


def sent_fields(proto):
    """Returns Message.field for all fields that these requests may contain."""
    messages = {name: PROTO_FIELD.findall(body) for name, body in PROTO_MESSAGE.findall(proto)}
    due, seen, fields = list(SENT_MESSAGES), set(), set()
    while due:
        message = due.pop()
        if message in seen:
            continue
        seen.add(message)
        for kind, name in messages[message]:
            due += [kind] if kind in messages else []
            fields.add(f"{message}.{name}")
    return {field for field in fields if not field.startswith("StreamTelemetryRequest.") or field.endswith(".sequence")}


def privacy_errors(root, package):
    told = set(PRIVACY_FIELD.findall((package / "Documentation~/privacy.md").read_text(encoding="utf-8")))
    sent = sent_fields("".join((root / f"proto/sweepstake/v1/{name}.proto").read_text(encoding="utf-8") for name in ("telemetry", "posteriors")))
    for field in sorted(sent - told):
        yield f"Documentation~/privacy.md: `{field}` is sent, but not listed"
    for field in sorted(told - sent):
        yield f"Documentation~/privacy.md: `{field}` is listed, but not sent"


def proof_errors(root, package):
    page = (package / "Documentation~/proven.md").read_text(encoding="utf-8")
    steps = set(STEP.findall(page))
    rows = POINT.findall(page)
    points = [int(row[0]) for row in rows]
    if points[:POINTS] != list(range(1, POINTS + 1)) or points != sorted(set(points)):
        yield f"Documentation~/proven.md: the points 1 to {POINTS} must have one row each, in order"
    tests = {path.stem: path.read_text(encoding="utf-8") for path in sorted((root / "unity_client").rglob("*Test.cs"))}
    for number, _, proof, editor in rows:
        if not proof.strip() and not editor.strip():
            yield f"Documentation~/proven.md: point {number} has neither a test nor steps"
        for name, method in TEST_NAME.findall(proof):
            if f" {method}(" not in tests.get(name, "") and not (name in tests and not method):
                yield f"Documentation~/proven.md: the test {name}.{method} does not exist"
        if editor.strip() and editor.strip()[0] not in steps:
            yield f"Documentation~/proven.md: the steps {editor.strip()[0]} do not exist"
    quick_start = re.search(r"^## Quick start\n(.*?)^## ", (package / "Documentation~/index.md").read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    if not quick_start or not 1 <= len(re.findall(r"^\d+\. ", quick_start[1], re.MULTILINE)) <= MAX_QUICK_START_STEPS:
        yield f"Documentation~/index.md: the quick start must have at most {MAX_QUICK_START_STEPS} steps"


def check(root):
    package = root / PACKAGE
    return [*manifest_errors(root, package), *commit_errors(root, package), *tag_errors(root, package), *make_metas.errors(package), *changelog_errors(package), *asmdef_errors(package),
            *sample_errors(package), *path_errors(package), *document_errors(package), *document_names.errors(root, package), *privacy_errors(root, package), *proof_errors(root, package)]


def edit(package, name, old, new):
    path = package / name
    text = path.read_text(encoding="utf-8")
    assert old in text, f"{name} has no '{old}'"
    path.write_text(text.replace(old, new, 1), encoding="utf-8")


def edit_by(package, name, pattern, new):
    path = package / name
    text, count = pattern.subn(new, path.read_text(encoding="utf-8"), count=1)
    assert count == 1, f"{name} has no '{pattern.pattern}'"
    path.write_text(text, encoding="utf-8")


def place(package, name):
    path = package / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.unlink(missing_ok=True)
    path.touch()


# Changes of a copy of the package, and a part of the error that each must cause.
BAD = [
    (lambda p: edit(p, "package.json", '"version": "', '"version": "9'), "the version is not"),
    (lambda p: edit_by(p, "Documentation~/index.md", INSTALLED_TAG, "#v99.0.0"), "index.md: the tag #v99"),
    (lambda p: edit_by(p, "Documentation~/index.md", INSTALLED_TAG, "the tag"), "no document describes the installation"),
    (lambda p: edit_by(p, "CHANGELOG.md", HEADING, "## [0.0.9] - 2026-01-01"), "begins with neither"),
    (lambda p: edit_by(p, "CHANGELOG.md", HEADING, "## [Unreleased]\n\n## [99.0.0] - 2026-01-01"), "has a version after"),
    (lambda p: edit(p, "package.json", '"2022.3"', '"2019.4"'), "the lowest Unity"),
    (lambda p: edit(p, "package.json", "Samples~/QuickStart", "Samples~/None"), "Samples~/None does not exist"),
    (lambda p: edit(p, "package.json", "Samples~/QuickStart", "Samples~/None"), "the sample Samples~/QuickStart is not listed"),
    (lambda p: (p / "Samples~/QuickStart/QuickStart.unity").unlink(), "a sample must have an assembly and a scene"),
    (lambda p: edit(p, "Samples~/QuickStart/QuickStart.unity", "11500000, guid: ", "11500000, guid: 0"), "is not the package's"),
    (lambda p: edit(p, "Editor/Sweepstake.Editor.asmdef", '["Editor"]', "[]"), "must include the editor only"),
    (lambda p: edit(p, "Runtime/GrpcNet/Sweepstake.GrpcNet.asmdef", '"Grpc.Core.Api.dll"', '"Google.Protobuf.dll"'), "a player must not need Google.Protobuf"),
    (lambda p: edit(p, "Documentation~/proven.md", "| 7 |", "| 77 |"), "the points 1 to 47"),
    (lambda p: edit(p, "Documentation~/proven.md", "`SecurityTest`", "`InsecurityTest`"), "the test InsecurityTest. does not exist"),
    (lambda p: edit(p, "Documentation~/proven.md", "- **G**", "- **X**"), "the steps G do not exist"),
    (lambda p: edit(p, "Documentation~/proven.md", "| G |", "| |"), "point 25 has neither a test nor steps"),
    (lambda p: edit(p, "Documentation~/index.md", "## Quick start\n", "## Quick start\n\n1. a\n2. b\n"), "at most 6 steps"),
    (lambda p: edit(p, "Documentation~/privacy.md", "| `ListPosteriorsRequest.page_size` |", "| |"), "`ListPosteriorsRequest.page_size` is sent, but not listed"),
    (lambda p: (p / "README.md.meta").unlink(), "README.md.meta is missing"),
    (lambda p: (p / "Gone.md.meta").write_text("guid: " + "0" * 32 + "\n"), "Gone.md.meta belongs to no file or folder"),
    (lambda p: shutil.copy(p / "README.md.meta", p / "LICENSE.md.meta"), "has the GUID of"),
    (lambda p: place(p, "Runtime/Plugins/linux-x86_64/libsweepstake.so"), "Runtime/Plugins/linux-x86_64/libsweepstake.so.meta is missing"),
    (lambda p: place(p, "Runtime/Plugins/linux-x86_64/libsweepstake.so.meta"), "Runtime/Plugins/linux-x86_64/libsweepstake.so.meta belongs to no file or folder"),
    (lambda p: edit_by(p, "CHANGELOG.md", HEADING, "## Unreleased"), "is not '## [1.2.3]"),
    (lambda p: edit_by(p, "CHANGELOG.md", HEADING, "## [0.1.0] - 2026-01-01\n\n## [0.2.0] - 2026-01-01"), "the newest version must come first"),
    (lambda p: place(p.parents[1], ".git"), "git cannot list the tags"),
    (lambda p: edit(p, "Runtime/Core/Sweepstake.Core.asmdef", '"Sweepstake.Core"', '"Core"'), "is called 'Core'"),
    (lambda p: edit(p, "Runtime/Core/Sweepstake.Core.asmdef", '"noEngineReferences": true', '"noEngineReferences": false'), "must not reference UnityEngine"),
    (lambda p: edit(p, "Runtime/GrpcNet/Sweepstake.GrpcNet.asmdef", '"SWEEPSTAKE_GRPC"', ""), "without the libraries of gRPC"),
    (lambda p: edit(p, "Runtime/GrpcNet/Sweepstake.GrpcNet.asmdef", '"Sweepstake.Core"', '"Sweepstake.Kern"'), "'Sweepstake.Kern' is not an assembly"),
    (lambda p: (p / "Documentation~" / ("x" * MAX_PATH)).write_text(""), "more than 140 characters"),
    (lambda p: (p / "Documentation~/link.xml").write_text(""), "Unity ignores it"),
    (lambda p: (p / "Documentation~/Google.Protobuf.dll").write_text(""), "conflict with another copy"),
    (lambda p: (p / "Documentation~/privacy.md").write_text("| `Hello.shoe_size` | |\n"), "`Hello.shoe_size` is listed, but not sent"),
    (lambda p: edit(p, "Documentation~/privacy.md", "| `Hello.machine_class` |", "| |"), "`Hello.machine_class` is sent, but not listed"),
    (lambda p: edit(p, "Documentation~/setup.md", "*Set Define*", "*Set a Define*"), "setup.md: 'Set a Define' is not a label of the package"),
    (lambda p: edit(p, "Documentation~/components.md", "`Connect()`", "`Conect()`"), "components.md: Conect in Conect() is not in the API"),
    (lambda p: edit(p, "Documentation~/native-library.md", "`tests/cross.sh`", "`tests/crass.sh`"), "the file tests/crass.sh does not exist"),
    (lambda p: edit(p, "Documentation~/samples.md", "Window > Package Manager", "Window > Package Managing"), "samples.md: 'Window > Package Managing' is not a label"),
    (lambda p: edit(p, "Documentation~/samples.md", "Package Management > Package Manager", "Package Manager > Samples"), "'Window > Package Manager > Samples' is not a label"),
    (lambda p: edit(p, "Documentation~/daemon.md", "`manager.Connect()`", "`manager.OverlapBox()`"), "daemon.md: OverlapBox in manager.OverlapBox() is not in the API"),
    (lambda p: edit(p, "Documentation~/components.md", "`Connect()`", "`Assert()`"), "components.md: Assert in Assert() is not in the API"),
    (lambda p: edit(p, "README.md", "index.md", "gone.md"), "the link to Documentation~/gone.md leads nowhere"),
]


def release_misses(package):
    version = json_of(package / "package.json")["version"]
    with tempfile.TemporaryDirectory() as folder:
        copy = pathlib.Path(folder)
        for name in ("package.json", "CHANGELOG.md"):
            shutil.copy(package / name, copy)
        edit_by(copy, "CHANGELOG.md", HEADING, f"## [{version}] - 2026-01-01")
        if list(release_errors(copy, ["v" + version])):
            yield "a valid release was refused"
        if not list(release_errors(copy, ["v99.0.0"])):
            yield "a commit's tag of another version was not found"
        for heading in ("## [Unreleased]", f"## [{version}]", "## [99.0.0] - 2026-01-01"):
            edit_by(copy, "CHANGELOG.md", HEADING, heading)
            if not list(release_errors(copy, ["v" + version])):
                yield f"a release with '{heading}' was not found"


def git_misses(package):
    with tempfile.TemporaryDirectory() as folder, unittest.mock.patch.dict(os.environ, {"PATH": folder}):
        place(pathlib.Path(folder), ".git")
        if not any("git cannot be started" in error for error in commit_errors(pathlib.Path(folder), package)):
            yield "a missing git was not reported"


def self_test(root):
    missed = [*release_misses(root / PACKAGE), *git_misses(root / PACKAGE)]
    for change, error in BAD:
        with tempfile.TemporaryDirectory() as folder:
            copy = pathlib.Path(folder)
            shutil.copytree(root / "unity_client", copy / "unity_client")
            shutil.copytree(root / "proto", copy / "proto", ignore=shutil.ignore_patterns("node_modules"))
            shutil.copy(root / "CMakeLists.txt", copy)
            change(copy / PACKAGE)
            errors = check(copy)
            if not any(error in found for found in errors):
                missed.append(f"'{error}' was not reported, but: {errors}")
    return missed


def main(arguments):
    if arguments == ["--self-test"]:
        errors = self_test(pathlib.Path(__file__).resolve().parents[2])
        print("\n".join(errors) or f"{len(BAD)} broken rules were each found")
    elif len(arguments) == 1:
        errors = check(pathlib.Path(arguments[0]))
        print("\n".join(errors) or "the package keeps the rules")
    else:
        print(__doc__, file=sys.stderr)
        return 2
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
