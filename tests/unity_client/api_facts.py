"""Recorded facts about the API that the stubs of unity_client/dotnet/stubs imitate: the format of facts/unity_api.txt, and how to list an API.

A section per stub assembly names the source and its versions, oldest first. In it, each type is followed by its members, one per line and indented.
A line that begins with ":" describes the type itself; other lines have a member's name, signature and accessor. At the end of a line, "@1.2+" means
since this version, "@-1.2" up to this version, "@1.2..1.4" both, "@editor" only in the editor, and "@documented" that documentation was read instead of source.
"""

import re
import subprocess
import sys
import tempfile

PROJECT = "unity_client/dotnet/api_list"
SECTION = re.compile(r"^\[(\S+) (.*)\]$")
MARK = re.compile(r" @(\S+)")


class Facts:
    """The versions, and for each version and kind ("editor" or "player") the lines "type<tab>line" that hold."""

    def __init__(self):
        self.versions, self.lines = [], {}

    def add(self, line, versions, kinds):
        for version in versions:
            for kind in kinds:
                self.lines.setdefault((version, kind), set()).add(line)

    def of(self, version, kind):
        return self.lines.get((version, kind), set())


def read(path):
    """Returns the facts by stub assembly."""
    found, section, kind = {}, None, ""
    for line in path.read_text(encoding="utf-8").splitlines():
        heading = SECTION.match(line)
        if heading:
            section = found[heading[1]] = Facts()
            section.versions = heading[2].split()[1:]
        elif line.startswith("  "):
            marks = MARK.findall(line)
            kinds = ["editor"] if "editor" in marks else ["editor", "player"]
            section.add(f"{kind}\t{MARK.sub('', line.strip())}", span(section.versions, marks), kinds)
        elif line and not line.startswith("#"):
            kind = line
    return found


def span(versions, marks):
    first, last = versions[0], versions[-1]
    for mark in marks:
        if mark.endswith("+"):
            first = mark[:-1]
        elif mark.startswith("-"):
            last = mark[1:]
        elif ".." in mark:
            first, last = mark.split("..")
    return versions[versions.index(first):versions.index(last) + 1]


class Lister:
    """Prints APIs with the project api_list, which it builds."""

    def __init__(self, root, build):
        folder = build / "dotnet"
        subprocess.run(["dotnet", "build", str(root / PROJECT), "--configuration", "Release", "--nologo", "--verbosity", "quiet", f"-p:BuildFolder={folder}/", "-nodeReuse:false"],
                       stdout=sys.stderr, check=True)
        self.program = folder / "ApiList/bin/Release/net10.0/ApiList.dll"

    def lines(self, arguments):
        """Returns the printed lines of the arguments that api_list/Program.cs describes."""
        with tempfile.NamedTemporaryFile("w", encoding="utf-8", suffix=".txt") as file:
            file.writelines(f"{argument}\n" for argument in arguments)
            file.flush()
            return subprocess.run(["dotnet", "exec", str(self.program), file.name], capture_output=True, text=True, check=True).stdout.splitlines()
