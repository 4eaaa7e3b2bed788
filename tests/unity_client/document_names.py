"""Checks that names in the documents of the Unity package exist: labels of menus and buttons, names of the API, files."""

import json
import re

CODE_BLOCK = re.compile(r"^```.*?^```$", re.MULTILINE | re.DOTALL)
ITALIC = re.compile(r"(?<![*\w])\*([A-Z][^*]*)\*(?!\*)")
CODE = re.compile(r"`([^`\n]+)`")
API_CODE = re.compile(r"\w+(?:\.\w+)*(?:\([^)]*\))?")
FILE_NAME = re.compile(r"(?:deploy|dotnet|tests|unity_client|Runtime|Samples~|Tests|Documentation~)/[\w./~-]+")
LITERAL = re.compile(r'"([^"\\\n]+)"')
FIELD = re.compile(r"^\s+(?:\[[^\n]*\] )?(?:public|private|internal) [\w.<>\[\]?]+ (\w+)(?: = [^;]*)?;", re.MULTILINE)
# The key of a button at the beginning of its text.
KEY = re.compile(r"^\[[A-Z]\] ")
HUMP = re.compile(r"(?<=[a-z])(?=[A-Z])")
# Names of tests. They are not names of the API; package_test.py checks the tests that proven.md names.
TEST = re.compile(r"\w+Test\b")
API_WORD = re.compile(r"\b[A-Z]\w*[a-z]\w*")
COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)
# Complete paths of Unity's own menus, settings and profiler.
UNITY = {"Window > Package Management > Package Manager", "Window > Package Manager", "+ > Install package from disk", "+ > Add package from disk",
         "+ > Install package from git URL", "+ > Add package from git URL", "Samples > Import", "Project Settings > Player > Active Input Handling", "Both",
         "Project Settings > Tags and Layers", "Project Settings > Graphics > Shader Stripping > Instancing Variants", "Keep All", "High", "Reload Domain", "GC Alloc"}
# Menus and pages in which the package has entries.
PARENTS = ("Window > ", "GameObject > ", "Assets > Create > ", "Project Settings > ")
# Names of Unity, .NET and other packages that are not in a stub.
OTHERS_API = {"NuGetForUnity", "UnityNuGet", "StreamingAssets", "SocketsHttpHandler", "ComputePenetration"}
# The variable names in the documents, and the types of these objects.
OWNERS = {"manager": ("SweepstakeManager",), "tracker": ("ColliderTracker",), "session": ("BroadPhaseSession", "NativeObject"),
          "connection": ("DaemonConnection", "SessionWork")}


def shown(package, sources):
    """Returns the texts of menus, buttons and states, the inspector's names of fields, and the names of the package and its samples."""
    manifest = json.loads((package / "package.json").read_text(encoding="utf-8"))
    texts = {manifest["displayName"], *(sample["displayName"] for sample in manifest["samples"])}
    for source in sources:
        texts |= {KEY.sub("", part.rstrip("…")) for literal in LITERAL.findall(source) for part in (literal, *literal.split("/"))}
        texts |= {HUMP.sub(" ", field[0].upper() + field[1:]) for field in FIELD.findall(source)}
    return texts


def is_shown(name, texts):
    own = next((name.removeprefix(parent) for parent in PARENTS if name.startswith(parent + "Sweepstake")), name)
    return name in UNITY or (all(part in texts for part in own.split(" > ")) and (own != name or not name.startswith(PARENTS)))


def words_of(sources):
    return {word for source in sources for word in API_WORD.findall(COMMENT.sub("", source))}


def unknown_words(code, files, words):
    """Returns the unknown names in an expression, or in the members of an owner whose type is known."""
    owner, _, members = code.partition(".")
    types = OWNERS.get(owner)
    known = words_of(files[name] for name in types) if types else words
    return [word for word in API_WORD.findall(members if types else code) if word not in known]


def is_file(root, package, name):
    folders = (root, root / "unity_client", package, root / "unity_client/tools/plugin_metas")
    return any((folder / found).exists() for folder in folders for found in (name, name + ".meta"))


def errors(root, package):
    api = [path for folder in (package / "Runtime", package / "Editor", package / "Samples~") for path in sorted(folder.rglob("*.cs"))]
    files = {path.stem: path.read_text(encoding="utf-8-sig") for path in api}
    stubs = [path.read_text(encoding="utf-8-sig") for path in sorted((root / "unity_client/dotnet/stubs").rglob("*.cs"))]
    texts = shown(package, files.values())
    # The documents name messages that a player sends; only the native library has them.
    protos = [path.read_text(encoding="utf-8") for path in sorted((root / "proto").rglob("*.proto"))]
    words = words_of([*files.values(), *stubs, *protos]) | OTHERS_API
    for page in sorted((root / "unity_client").rglob("*.md")):
        text = re.sub(r"\s+", " ", CODE_BLOCK.sub("", page.read_text(encoding="utf-8")).replace("**", ""))
        for name in ITALIC.findall(CODE.sub("", text)):
            if not is_shown(name, texts):
                yield f"{page.name}: '{name}' is not a label of the package"
        for code in CODE.findall(text):
            if FILE_NAME.fullmatch(code):
                if not is_file(root, package, code):
                    yield f"{page.name}: the file {code} does not exist"
            elif API_CODE.fullmatch(code) and not TEST.match(code):
                yield from (f"{page.name}: {word} in {code} is not in the API" for word in unknown_words(code, files, words))
