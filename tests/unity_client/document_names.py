"""What the documents of the Unity package name, looked for in the package: words that a person clicks, names of the API, files."""

import json
import re

CODE_BLOCK = re.compile(r"^```.*?^```$", re.MULTILINE | re.DOTALL)
ITALIC = re.compile(r"(?<![*\w])\*([A-Z][^*]*)\*(?!\*)")
CODE = re.compile(r"`([^`\n]+)`")
API_CODE = re.compile(r"\w+(?:\.\w+)*(?:\([^)]*\))?")
FILE_NAME = re.compile(r"(?:deploy|dotnet|tests|unity_client|Runtime|Samples~|Tests|Documentation~)/[\w./~-]+")
LITERAL = re.compile(r'"([^"\\\n]+)"')
FIELD = re.compile(r"^\s+(?:\[[^\n]*\] )?(?:public|private|internal) [\w.<>\[\]?]+ (\w+)(?: = [^;]*)?;", re.MULTILINE)
HUMP = re.compile(r"(?<=[a-z])(?=[A-Z])")
API_WORD = re.compile(r"\b[A-Z]\w*[a-z]\w*")
# What Unity itself shows, in its menus, its settings and its profiler.
UNITY = {"Window", "GameObject", "Assets", "Create", "Project Settings", "Package Manager", "+", "Install package from disk", "Add package from disk",
         "Samples", "Import", "Graphics", "Shader Stripping", "Instancing Variants", "Keep All", "High", "Reload Domain", "GC Alloc"}
# Of Unity, .NET and other packages, as far as no stub has it.
OTHERS_API = {"NuGetForUnity", "UnityNuGet", "StreamingAssets"}


def shown(package, sources):
    """The texts of menus, buttons and states, the names that an inspector gives to fields, those of the package and its samples."""
    manifest = json.loads((package / "package.json").read_text(encoding="utf-8"))
    texts = {manifest["displayName"], *(sample["displayName"] for sample in manifest["samples"])}
    for source in sources:
        texts |= {part.rstrip("…") for literal in LITERAL.findall(source) for part in (literal, *literal.split("/"))}
        texts |= {HUMP.sub(" ", field[0].upper() + field[1:]) for field in FIELD.findall(source)}
    return texts | UNITY


def is_file(root, package, name):
    folders = (root, root / "unity_client", package, root / "unity_client/tools/plugin_metas")
    return any((folder / found).exists() for folder in folders for found in (name, name + ".meta"))


def errors(root, package):
    sources = [path.read_text(encoding="utf-8-sig") for path in sorted(package.rglob("*.cs"))]
    stubs = [path.read_text(encoding="utf-8-sig") for path in sorted((root / "unity_client/dotnet").rglob("*.cs"))]
    texts = shown(package, sources)
    words = {word for source in sources + stubs for word in API_WORD.findall(source)} | OTHERS_API
    for page in sorted((root / "unity_client").rglob("*.md")):
        text = re.sub(r"\s+", " ", CODE_BLOCK.sub("", page.read_text(encoding="utf-8")).replace("**", ""))
        for name in ITALIC.findall(CODE.sub("", text)):
            yield from (f"{page.name}: nothing is called '{part}'" for part in name.split(" > ") if part not in texts)
        for code in CODE.findall(text):
            if FILE_NAME.fullmatch(code):
                if not is_file(root, package, code):
                    yield f"{page.name}: there is no file {code}"
            elif API_CODE.fullmatch(code):
                yield from (f"{page.name}: the API has no {word}, of {code}" for word in API_WORD.findall(code) if word not in words)
