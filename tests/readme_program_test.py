#!/usr/bin/env python3
"""Tests that the program of a README is short, compiles without warnings, runs, and switches its broad phase.

    readme_program_test.py c|cpp --write README FILE    checks its length and writes it to a file, which CMake compiles
    readme_program_test.py c|cpp --run PROGRAM          runs the compiled program
"""
import pathlib
import re
import subprocess
import sys

MOST_LINES = {"c": 60, "cpp": 20}
MOST_LINES_OF_MAIN = {"c": 40, "cpp": 12}
# Which arm is active at the end, and how long it takes, depends on the machine.
ARM = r"(BruteForce|Grid|SAP|AxisSweep|DBVT|Tracy|KDTree)"
SAID = {"c": rf"[1-9]\d{{4,}} touches, 0 invalid boxes, [1-9]\d* switches, at the end with {ARM}\n"
             r"\d+\.\d{3} ms instead of \d+\.\d{3} ms per frame\n",
        "cpp": rf"({ARM}: \d+ us instead of \d+ us\n){{3}}(?!BruteForce){ARM}: \d+ us instead of \d+ us\n"}


def check_length(program, most):
    lines = program.count("\n")
    assert lines <= most, f"{lines} lines, more than {most}:\n{program}"


def write(language, readme, file):
    programs = re.findall(rf"^```{language}\n(.*?)^```$", pathlib.Path(readme).read_text(), re.S | re.M)
    assert len(programs) == 1, f"{len(programs)} programs"
    check_length(programs[0], MOST_LINES[language])
    check_length(re.search(r"^int main\(.*?\{\n(.*?)^\}$", programs[0], re.S | re.M)[1], MOST_LINES_OF_MAIN[language])
    pathlib.Path(file).write_text(programs[0])


def run(language, program):
    said = subprocess.run([program], check=True, capture_output=True, text=True, timeout=280).stdout
    assert re.fullmatch(SAID[language], said), said
    print(said, end="")


def main(language, how, *names):
    {"--write": write, "--run": run}[how](language, *names)


main(*sys.argv[1:])
