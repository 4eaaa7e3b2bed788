#!/usr/bin/env python3
"""Fails if a stub of unity_client/dotnet/stubs has a public type or member that the real assembly lacks or declares otherwise.

    stubs_test.py ROOT BUILD           compares with facts/unity_api.txt, for each Unity version, in the editor and in players
    stubs_test.py ROOT BUILD --lines   prints the API of the stubs, for unity_client/tools/record_facts.py

tests/unity_client/dotnet_test.sh restores the projects of unity_client/dotnet in BUILD first. What only tests use must be internal in a stub.
Each public line of a stub must be a fact; a stub may have fewer members than the real type.
"""

import pathlib
import sys

import api_facts
import compile_test

FACTS = "tests/unity_client/facts/unity_api.txt"
# The stubs of UPM packages are compiled once, with this version of Unity.
NEWEST = compile_test.U65


class Stubs:
    """Compiles the stubs and lists their API."""

    def __init__(self, root, build):
        self.lister = api_facts.Lister(root, build)
        self.compiler = compile_test.Compiler(compile_test.Toolchain(build), build / "dotnet/stubs_test")
        self.assemblies = compile_test.stub_assemblies(root / compile_test.STUBS)

    def lines(self, name, defines, kind):
        """Returns the API of a stub as a set of lines, and the metadata names of its types."""
        given = [*defines, *compile_test.OLD_INPUT, *(compile_test.EDITOR if kind == "editor" else [])]
        path, references = self.compile(name, given)
        printed = self.lister.lines([*(f"reference {file}" for file in [*self.compiler.tools.framework, *references]), f"assembly {path}"])
        return {line for line in printed if "\t" in line}, [line for line in printed if "\t" not in line]

    def compile(self, name, defines):
        assembly = self.assemblies[name]
        references = [self.compile(other, defines)[0] for other in compile_test.reference_names(assembly, self.assemblies, {})]
        references += compile_test.precompiled(self.compiler.tools, assembly, defines)
        path = self.compiler.compile(assembly, assembly.defines(defines, []), references)
        if path is None:
            raise SystemExit(f"stubs_test.py: the stub {name} does not compile")
        return path, references


def versions_of(name, facts):
    """Yields the version of the facts, the defines and the kind of each comparison."""
    if name not in ("UnityEngine", "UnityEditor"):
        yield from ((version, NEWEST, "editor") for version in facts.versions)
        return
    for version in facts.versions:
        for kind in ("editor", "player") if name == "UnityEngine" else ("editor",):
            yield version, defines_of(version), kind


def defines_of(version):
    """The defines of a version such as 6000.0.78f1."""
    number = tuple(int(part) for part in version.split(".")[:2])
    return compile_test.unity(*(known for known in ("2022.3", "6000.0", "6000.5") if tuple(map(int, known.split("."))) <= number))


def errors(stubs, facts):
    yield from (f"{name}: no facts are recorded" for name in sorted(stubs.assemblies.keys() - facts.keys()))
    yield from (f"{name}: facts are recorded, but no stub exists" for name in sorted(facts.keys() - stubs.assemblies.keys()))
    for name in sorted(stubs.assemblies.keys() & facts.keys()):
        wrong = {}
        for version, defines, kind in versions_of(name, facts[name]):
            for line in stubs.lines(name, defines, kind)[0] - facts[name].of(version, kind):
                wrong.setdefault(line, []).append(f"{version} {kind}")
        yield from (f"{name}: '{line.replace(chr(9), ' ')}' is not a fact of {', '.join(where)}" for line, where in sorted(wrong.items()))


def print_lines(stubs):
    for name in sorted(stubs.assemblies):
        found, types = set(), set()
        for defines in (compile_test.U2022, compile_test.U6, compile_test.U65):
            for kind in ("editor", "player") if name == "UnityEngine" else ("editor",):
                lines, names = stubs.lines(name, defines, kind)
                found |= lines
                types |= set(names)
        print(f"[{name}]", *sorted(types), *sorted(found), sep="\n")


def main(arguments):
    if len(arguments) not in (2, 3) or arguments[2:] not in ([], ["--lines"]):
        print(__doc__, file=sys.stderr)
        return 2
    root, build = (pathlib.Path(argument).resolve() for argument in arguments[:2])
    stubs = Stubs(root, build)
    if arguments[2:]:
        print_lines(stubs)
        return 0
    facts = api_facts.read(root / FACTS)
    found = list(errors(stubs, facts))
    print("\n".join(found) or f"{len(stubs.assemblies)} stubs match the recorded API of {sum(len(section.versions) for section in facts.values())} versions")
    if found:
        print("Correct the stub. After adding API to a stub, record its facts: unity_client/tools/record_facts.py")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
