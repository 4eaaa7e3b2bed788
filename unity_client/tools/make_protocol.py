#!/usr/bin/env python3
"""Writes the C# messages and stubs of proto/ that the Unity package ships, with the compiler of the NuGet package Grpc.Tools.

    make_protocol.py ROOT           writes Runtime/Protocol/Generated of the package
    make_protocol.py ROOT --check   fails if the files differ from what this would write

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
OUTPUT = "unity_client/com.sweepstake.broadphase/Runtime/Protocol/Generated"
# A game uses telemetry and its imports; the editor reads posteriors and transfers priors.
FILES = ["events", "telemetry", "posteriors", "priors"]


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


def generate(root, output):
    protoc, plugin = compiler(root)
    proto = root / "proto"
    subprocess.run([protoc, f"--proto_path={proto}", f"--csharp_out={output}", f"--grpc_out={output}", "--grpc_opt=no_server",
                    f"--plugin=protoc-gen-grpc={plugin}", *(f"sweepstake/v1/{name}.proto" for name in FILES)], check=True)


def texts(folder):
    return {path.name: path.read_text(encoding="utf-8-sig").replace("\r\n", "\n") for path in sorted(pathlib.Path(folder).glob("*.cs"))}


def main(arguments):
    if not 1 <= len(arguments) <= 2 or arguments[1:] not in ([], ["--check"]):
        print(__doc__, file=sys.stderr)
        return 2
    root = pathlib.Path(arguments[0]).resolve()
    with tempfile.TemporaryDirectory() as folder:
        generate(root, folder)
        made, committed = texts(folder), texts(root / OUTPUT)
    if not arguments[1:]:
        for name in committed.keys() - made.keys():
            (root / OUTPUT / name).unlink()
        for name, text in made.items():
            (root / OUTPUT / name).write_text(text, encoding="utf-8")
        return 0
    stale = sorted(name for name in made.keys() | committed.keys() if made.get(name) != committed.get(name))
    for name in stale:
        print(f"{OUTPUT}/{name} does not match proto/; run unity_client/tools/make_protocol.py")
    return 1 if stale else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
