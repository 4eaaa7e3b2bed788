#!/usr/bin/env python3
"""Writes the C# messages and stubs that the editor of the Unity package needs, with the compiler of the NuGet package Grpc.Tools.

    make_protocol.py ROOT           writes Editor/Generated of the package
    make_protocol.py ROOT --check   fails if the files differ from what this would write, or if they have more than 12,000 lines

Players need none of these messages: the native library encodes telemetry. Of proto/, the output has only the methods in METHODS and the
messages and enums that these use. Code for compilers before C# 7.2 is left out, because the package needs C# 9.

`dotnet restore unity_client/dotnet/protocol` installs Grpc.Tools; that project sets its version.
"""

import os
import pathlib
import platform
import re
import subprocess
import sys
import tempfile

PROJECT = "unity_client/dotnet/protocol/Sweepstake.Protocol.csproj"
OUTPUT = "unity_client/com.sweepstake.broadphase/Editor/Generated"
MAX_LINES = 12_000
# The methods that the editor and its tools call. Administration of a store is left out: the program `sweepstake` does that.
METHODS = {
    "posteriors": ["ListPosteriors", "GetPosterior", "WatchPosteriors"],
    "priors": ["ExportPriors", "ImportPriors"],
    "sessions": ["ListSessions", "WatchSessions"],
}
# The files that the others import.
IMPORTED = ["events", "telemetry"]

# A message, enum or service with its comment. Each begins in the first column, and ends with a brace there or on its first line.
BLOCK = re.compile(r"^(?://[^\n]*\n)*(message|enum|service) (\w+) \{(?:\}|.*?^\})\n", re.MULTILINE | re.DOTALL)
METHOD = re.compile(r"^(?:  //[^\n]*\n)*  rpc (\w+)\([^\n]*;\n", re.MULTILINE)
IMPORT = re.compile(r'^import "sweepstake/v1/(\w+)\.proto";\n', re.MULTILINE)
COMMENT = re.compile(r"//[^\n]*")
WORD = re.compile(r"\b[A-Z]\w+")
OLD_COMPILERS = "#if !GOOGLE_PROTOBUF_REFSTRUCT_COMPATIBILITY_MODE"


def words_of(block):
    return set(WORD.findall(COMMENT.sub("", block)))


def pruned(protos):
    """Returns the files with the methods in METHODS and what these need. `protos` has the text of each file by its name."""
    protos = {name: METHOD.sub(lambda found: found[0] if found[1] in METHODS.get(name, []) else "", text) for name, text in protos.items()}
    blocks = {found[2]: found[0] for text in protos.values() for found in BLOCK.finditer(text)}
    needed, due = set(), {found[2] for name in METHODS for found in BLOCK.finditer(protos[name]) if found[1] == "service"}
    while due:
        needed |= due
        due = {word for block in due for word in words_of(blocks[block]) if word in blocks} - needed
    kept = {name: BLOCK.sub(lambda found: found[0] if found[2] in needed else "", text) for name, text in protos.items()}
    owners = {found[2]: name for name, text in kept.items() for found in BLOCK.finditer(text)}
    return {name: IMPORT.sub(lambda found: found[0] if any(owners.get(word) == found[1] for word in words_of(text)) else "", text)
            for name, text in kept.items()}


def without_old_compilers(text):
    """Removes the branches of code for old compilers, which are never compiled here."""
    lines, branches = [], []
    for line in text.splitlines(keepends=True):
        word = line.strip()
        if word.startswith("#if "):
            branches.append("new" if word == OLD_COMPILERS else "other")
        elif word == "#else" and branches[-1] == "new":
            branches[-1] = "old"
        elif word == "#endif" and branches.pop() != "other":
            continue
        if not branches or (branches[-1] != "old" and word != OLD_COMPILERS):
            lines.append(line)
    return "".join(lines)


def packages_folder():
    listed = subprocess.run(["dotnet", "nuget", "locals", "global-packages", "--list"], capture_output=True, text=True, check=True)
    return pathlib.Path(listed.stdout.split(":", 1)[1].strip())


def compiler(root):
    version = re.search(r'Include="Grpc.Tools" Version="([^"]+)"', (root / PROJECT).read_text(encoding="utf-8"))[1]
    system = {"Linux": "linux", "Darwin": "macosx", "Windows": "windows"}[platform.system()]
    processor = "arm64" if platform.machine().lower() in ("aarch64", "arm64") and system == "linux" else "x64"
    folder = packages_folder() / "grpc.tools" / version / "tools" / f"{system}_{processor}"
    if not folder.is_dir():
        raise SystemExit(f"make_protocol.py: {folder} is missing; run: dotnet restore unity_client/dotnet/protocol")
    suffix = ".exe" if system == "windows" else ""
    for name in ("protoc", "grpc_csharp_plugin"):
        os.chmod(folder / (name + suffix), 0o755)
    return folder / ("protoc" + suffix), folder / ("grpc_csharp_plugin" + suffix)


def generated(root):
    """Returns the text of each file by its name."""
    protoc, plugin = compiler(root)
    names = [*IMPORTED, *METHODS]
    protos = pruned({name: (root / f"proto/sweepstake/v1/{name}.proto").read_text(encoding="utf-8") for name in names})
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        (folder / "sweepstake/v1").mkdir(parents=True)
        for name, text in protos.items():
            (folder / f"sweepstake/v1/{name}.proto").write_text(text, encoding="utf-8")
        subprocess.run([protoc, f"--proto_path={folder}", f"--csharp_out={folder}", f"--grpc_out={folder}", "--grpc_opt=no_server",
                        f"--plugin=protoc-gen-grpc={plugin}", *(f"sweepstake/v1/{name}.proto" for name in names)], check=True)
        return {name: without_old_compilers(text) for name, text in texts(folder).items()}


def texts(folder):
    return {path.name: path.read_text(encoding="utf-8-sig").replace("\r\n", "\n") for path in sorted(pathlib.Path(folder).glob("*.cs"))}


def main(arguments):
    if not 1 <= len(arguments) <= 2 or arguments[1:] not in ([], ["--check"]):
        print(__doc__, file=sys.stderr)
        return 2
    root = pathlib.Path(arguments[0]).resolve()
    made, committed = generated(root), texts(root / OUTPUT)
    if not arguments[1:]:
        for name in committed.keys() - made.keys():
            (root / OUTPUT / name).unlink()
        for name, text in made.items():
            (root / OUTPUT / name).write_text(text, encoding="utf-8")
        return 0
    stale = sorted(name for name in made.keys() | committed.keys() if made.get(name) != committed.get(name))
    for name in stale:
        print(f"{OUTPUT}/{name} does not match proto/; run unity_client/tools/make_protocol.py")
    lines = sum(text.count("\n") for text in committed.values())
    if lines > MAX_LINES:
        print(f"{OUTPUT} has {lines:,} lines; at most {MAX_LINES:,} are allowed. Shorten METHODS of make_protocol.py")
    return 1 if stale or lines > MAX_LINES else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
