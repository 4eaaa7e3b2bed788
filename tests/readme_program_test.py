#!/usr/bin/env python3
"""Tests that the C program of engine_client/c_api/README.md is short, compiles without warnings, runs, and prints its result.

    readme_program_test.py README COMPILER HEADERS LIBRARY
"""
import pathlib
import re
import subprocess
import sys
import tempfile

MOST_LINES = 60


def main(readme, compiler, headers, library):
    programs = re.findall(r"^```c\n(.*?)^```$", pathlib.Path(readme).read_text(), re.S | re.M)
    assert len(programs) == 1, f"{len(programs)} programs"
    lines = programs[0].count("\n")
    assert lines <= MOST_LINES, f"the program has {lines} lines, more than {MOST_LINES}"
    with tempfile.TemporaryDirectory() as folder:
        game = pathlib.Path(folder) / "game"
        game.with_suffix(".c").write_text(programs[0])
        subprocess.run([compiler, "-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror", f"-I{headers}", "-o", game,
                        game.with_suffix(".c"), library, f"-Wl,-rpath,{pathlib.Path(library).parent}"], check=True)
        said = subprocess.run([game], check=True, capture_output=True, text=True, timeout=100).stdout
    assert re.fullmatch(r"600 frames, [1-9]\d{4,} touches, at the end with (SAP|DBVT|KDTree)\n", said), said
    print(said, end="")


main(*sys.argv[1:])
