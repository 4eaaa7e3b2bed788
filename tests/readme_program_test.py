#!/usr/bin/env python3
"""Tests that the program of a README is short, compiles without warnings, runs, and switches its broad phase.

    readme_program_test.py README COMPILER HEADERS LIBRARY    compiles and runs the C program
    readme_program_test.py README --write FILE                writes the C++ program to a file, which CMake compiles
    readme_program_test.py README --run PROGRAM               runs the compiled C++ program
"""
import pathlib
import re
import subprocess
import sys
import tempfile

MOST_LINES = {"c": 60, "cpp": 22}
# Which arm is active at the end, and how long it takes, depends on the machine.
ARM = r"(BruteForce|Grid|SAP|AxisSweep|DBVT|Tracy|KDTree)"
SAID = {"c": rf"[1-9]\d{{4,}} touches, 0 invalid boxes, [1-9]\d* switches, at the end with {ARM}\n"
             r"\d+\.\d{3} ms instead of \d+\.\d{3} ms per frame\n",
        "cpp": rf"(?!BruteForce){ARM} takes \d+\.\d{{3}} ms per frame instead of \d+\.\d{{3}} ms\n"}


def program_of(readme, language):
    programs = re.findall(rf"^```{language}\n(.*?)^```$", pathlib.Path(readme).read_text(), re.S | re.M)
    assert len(programs) == 1, f"{len(programs)} programs"
    lines = programs[0].count("\n")
    assert lines <= MOST_LINES[language], f"the program has {lines} lines, more than {MOST_LINES[language]}"
    return programs[0]


def run(program, language):
    said = subprocess.run([program], check=True, capture_output=True, text=True, timeout=100).stdout
    assert re.fullmatch(SAID[language], said), said
    print(said, end="")


def compile_and_run(readme, compiler, headers, library):
    with tempfile.TemporaryDirectory() as folder:
        game = pathlib.Path(folder) / "game"
        game.with_suffix(".c").write_text(program_of(readme, "c"))
        subprocess.run([compiler, "-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror", f"-I{headers}", "-o", game,
                        game.with_suffix(".c"), library, f"-Wl,-rpath,{pathlib.Path(library).parent}"], check=True)
        run(game, "c")


def main(readme, *how):
    if how[0] == "--write":
        pathlib.Path(how[1]).write_text(program_of(readme, "cpp"))
    elif how[0] == "--run":
        run(how[1], "cpp")
    else:
        compile_and_run(readme, *how)


main(*sys.argv[1:])
