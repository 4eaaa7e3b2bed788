#!/usr/bin/env python3
"""Fails if a source of the libraries for games does not compile with another standard library or without exceptions.

    portable_sources_test.py BUILD     BUILD/compile_commands.json lists the sources and their definitions

clang checks the syntax of each source with libc++, without exceptions and RTTI, with all warnings, and for one instruction set of
the kernels. tests/portable.sh calls this test.
"""

import concurrent.futures
import json
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys

LIBRARIES = re.compile(r"sweepstake_(?:adaptive|broad_phase|c_objects|decider|embedded|embedded_decider|math|scene|text)\.dir/")
KEPT = re.compile(r"-(?:D|I|isystem$|std=|fexceptions$)")
# clang reports that libc++ and Eigen themselves use features that C++20 deprecates.
FLAGS = ["-stdlib=libc++", "-fno-exceptions", "-fno-rtti", "-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Wno-deprecated-declarations",
         "-Werror", "-fsyntax-only", "-DHWY_COMPILE_ONLY_STATIC"]


def command_of(clang, entry):
    kept = []
    words = iter(shlex.split(entry["command"]))
    for word in words:
        if KEPT.match(word):
            kept.append(word)
        if word == "-isystem":
            kept.append(next(words))
    return [clang, *FLAGS, *kept, entry["file"]]


def error_of(command, folder):
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    return f"{command[-1]}:\n{done.stderr[:2000]}" if done.returncode else None


def main():
    clang = shutil.which("clang++")
    if not clang or not list(pathlib.Path("/usr").glob("lib/llvm-*/include/c++/v1")):
        sys.exit("clang++ or libc++ is missing, so nothing was checked: install clang and libc++-dev")
    entries = json.loads((pathlib.Path(sys.argv[1]) / "compile_commands.json").read_text(encoding="utf-8"))
    entries = [entry for entry in entries if LIBRARIES.search(entry["command"])]
    if len(entries) < 80:
        sys.exit(f"only {len(entries)} sources were found: adapt LIBRARIES to the names of the libraries")
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        errors = list(filter(None, pool.map(lambda entry: error_of(command_of(clang, entry), entry["directory"]), entries)))
    print(f"{len(entries)} sources")
    if errors:
        sys.exit("\n".join(errors))


main()
