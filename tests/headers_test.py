#!/usr/bin/env python3
"""Fails if a game could not include a public header.

    Each header compiles alone, without exceptions and RTTI; those of the C ABI as C11 and as C++20.
    They compile after the macros of X11 and of windows.h: the macros that clash with common names, and the real headers if they are
    installed.
    They compile in Microsoft's dialect (clang for x86_64-pc-windows-msvc). Without a Windows SDK the standard library is libc++ over
    glibc's headers. This tests the dialect, the sizes of types (long has 32 bits) and our code for _WIN32 and _MSC_VER, but not
    Microsoft's own library.
    A 32-bit target is refused with a message.
    Headers of the frame path do not include <filesystem>, <iostream>, <mutex> or the like, and no header uses throw, try or catch. The C
    headers are ASCII, so that a compiler with any code page can read them.

    headers_test.py INCLUDE            checks the headers of INCLUDE/sweepstake
    headers_test.py --self-test        shows that each rule can fail

The checks of a missing compiler or library are skipped, and its name is printed.
"""

import concurrent.futures
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

# Excluded, because they need the headers of another engine; their adapters compile them.
OTHERS = {"box2d.h", "bullet.h", "ode.h"}
FRAME_PATH = ("adaptive_broad_phase.h", "broad_phase.h", "c_api.h", "hooks.h", "proxy_set.h")
HEAVY = {"filesystem", "fstream", "future", "iostream", "mutex", "regex", "sstream", "thread", "condition_variable"}
EXCEPTIONS = re.compile(r"\b(?:throw|try|catch|typeid|dynamic_cast)\b")
COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)

X11_MACROS = {
    "Status": "int", "Bool": "int", "True": "1", "False": "0", "None": "0L", "Always": "2", "Success": "0", "Above": "0",
    "Below": "1", "Complex": "0", "Convex": "2", "CurrentTime": "0L", "CursorShape": "0", "DestroyAll": "0", "FocusIn": "9",
    "FocusOut": "10", "GrayScale": "1", "KeyPress": "2", "KeyRelease": "3", "Unsorted": "0", "Expose": "12"}
WINDOWS_MACROS = {
    "min(a,b)": "(((a)<(b))?(a):(b))", "max(a,b)": "(((a)>(b))?(a):(b))", "near": "", "far": "", "IN": "", "OUT": "",
    "OPTIONAL": "", "ERROR": "0", "small": "char", "hyper": "int", "interface": "struct", "CONST": "const", "VOID": "void",
    "DELETE": "(0x00010000L)", "NO_ERROR": "0L", "STRICT": "1", "TRUE": "1", "FALSE": "0", "PASCAL": "", "CALLBACK": "",
    "GetMessage": "GetMessageA", "GetObject": "GetObjectA", "SendMessage": "SendMessageA", "CreateEvent": "CreateEventA",
    "CreateWindow": "CreateWindowA", "CreateMutex": "CreateMutexA", "GetClassName": "GetClassNameA", "Yield()": "",
    "DrawText": "DrawTextA", "LoadImage": "LoadImageA", "GetCurrentTime()": "0", "RGB(r,g,b)": "0"}
STANDARD = ("algorithm", "atomic", "cmath", "compare", "cstddef", "cstdint", "cstring", "functional", "limits", "memory",
            "optional", "span", "string", "string_view", "utility", "variant", "vector")
CXX = ["-std=c++20", "-fsyntax-only", "-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Werror"]
NO_EXCEPTIONS = ["-fno-exceptions", "-fno-rtti"]
# glibc assumes that long has 64 bits on 64-bit processors, but on Windows it has 32.
WORD_SIZE = "#define __WORDSIZE 32\n#define __WORDSIZE32_SIZE_ULONG 0\n#define __WORDSIZE32_PTRDIFF_LONG 0\n"


def including(names):
    return "".join(f'#include "sweepstake/{name}"\n' for name in names)


def defines(macros):
    return "".join(f"#define {name} {value}\n" for name, value in macros.items())


class Checks:
    """The compilations. They are collected first, so that they can run in parallel."""

    def __init__(self, include, work):
        self.include = pathlib.Path(include)
        self.work = pathlib.Path(work)
        self.headers = sorted(path.name for path in (self.include / "sweepstake").glob("*.h"))
        self.headers = [name for name in self.headers if name not in OTHERS]
        self.c_headers = [name for name in self.headers if name.startswith("c_")]
        self.jobs = []
        self.left_out = []

    def add(self, name, command, source, suffix=".cc", fails_with=None):
        self.jobs.append((name, command, source, suffix, fails_with))

    def find(self, *programs):
        for program in programs:
            if path := shutil.which(program):
                return path
        self.left_out.append(f"no {' or '.join(programs)}")
        return None

    def text(self, name):
        return (self.include / "sweepstake" / name).read_text(encoding="utf-8")

    def add_alone(self, cc, cxx):
        for name in self.headers:
            self.add(f"{name} alone", [cxx, *CXX, *NO_EXCEPTIONS], including([name]))
        for name in self.c_headers:
            flags = ["-std=c11", "-fsyntax-only", "-Wall", "-Wextra", "-Wpedantic", "-Werror"]
            self.add(f"{name} alone in C11", [cc, *flags], including([name]), ".c")

    def add_behind_macros(self, cxx, mingw):
        everything = including(self.headers)
        standard = "".join(f"#include <{name}>\n" for name in STANDARD)
        for owner, macros in (("X11", X11_MACROS), ("windows.h", WINDOWS_MACROS)):
            self.add(f"all behind the macros of {owner}", [cxx, *CXX], standard + defines(macros) + everything)
        # The macros that names/begin.h sets aside must be restored.
        status = "Status is_an_int = 0;\nint main() { return is_an_int; }\n"
        if pathlib.Path("/usr/include/X11/Xlib.h").exists():
            self.add("all behind X11/Xlib.h", [cxx, *CXX], "#include <X11/Xlib.h>\n" + everything + status)
        else:
            self.left_out.append("no X11/Xlib.h")
        if mingw and pathlib.Path("/usr/x86_64-w64-mingw32/include/windows.h").exists():
            self.add("all behind windows.h", [mingw, "--target=x86_64-w64-mingw32", *CXX],
                     standard + "#include <windows.h>\n" + everything)
        else:
            self.left_out.append("no windows.h of MinGW for clang-19")

    def foreign(self, clang, target):
        """Returns the command for a target whose standard library is not installed."""
        libcxx = sorted(pathlib.Path("/usr/lib").glob("llvm-*/include/c++/v1"))
        glibc = [path for path in ("/usr/include", f"/usr/include/{os.uname().machine}-linux-gnu")]
        if not clang or not libcxx:
            self.left_out.append(f"no clang and libc++ for {target}")
            return None
        overlay = self.work / "overlay/bits"
        overlay.mkdir(parents=True, exist_ok=True)
        (overlay / "wordsize.h").write_text(WORD_SIZE)
        folders = [str(libcxx[0]), str(overlay.parent), *glibc]
        return [clang, f"--target={target}", "-fms-compatibility", "-fms-extensions", *CXX, *NO_EXCEPTIONS, "-U_WIN32", "-U_WIN64",
                "-U_MSC_VER", "-U__ILP32__", "-D__linux__", "-D__gnu_linux__", "-D__unix__", "-D__ELF__", "-D__x86_64__",
                "-D_LIBCPP_OBJECT_FORMAT_COFF=1", "-D_GNU_SOURCE", "-Wno-macro-redefined", "-nostdinc++",
                *(word for folder in folders for word in ("-isystem", folder))]

    def add_foreign(self, clang):
        standard = "".join(f"#include <{name}>\n" for name in STANDARD)
        microsoft = ("#define _WIN32 1\n#define _WIN64 1\n#define _MSC_VER 1940\n"
                     "#undef UINTPTR_MAX\n#define UINTPTR_MAX UINT64_MAX\n")
        if command := self.foreign(clang, "x86_64-pc-windows-msvc"):
            self.add("all in Microsoft's dialect", command,
                     standard + defines(WINDOWS_MACROS) + microsoft + including(self.headers))
        if command := self.foreign(clang, "i686-pc-windows-msvc"):
            self.add("32 bits in C++", command, standard + including(["aabb.h"]), fails_with="needs a 64-bit target")
            self.add("32 bits in C", [clang, "--target=i386-pc-linux-gnu", "-ffreestanding", "-fsyntax-only"],
                     including(["c_api.h"]), ".c", fails_with="needs a 64-bit target")

    def run(self, job):
        """Returns the error of one compilation, or None."""
        name, command, source, suffix, fails_with = job
        done = subprocess.run([*command, f"-I{self.include}", "-x", "c" if suffix == ".c" else "c++", "-"], input=source,
                              capture_output=True, text=True, check=False)
        if fails_with is None:
            return f"{name}:\n{done.stderr[:3000]}" if done.returncode else None
        if done.returncode and fails_with in done.stderr:
            return None
        return f"{name}: should fail with '{fails_with}':\n{done.stderr[:3000]}"

    def heavy_errors(self, cxx):
        for name in FRAME_PATH:
            if name not in self.headers:
                continue
            done = subprocess.run([cxx, "-std=c++20", "-M", "-x", "c++", f"-I{self.include}", "-"], input=including([name]),
                                  capture_output=True, text=True, check=False)
            heavy = {pathlib.PurePath(path).name for path in done.stdout.replace("\\\n", " ").split()} & HEAVY
            if heavy:
                yield f"{name} brings <{'>, <'.join(sorted(heavy))}>"

    def text_errors(self):
        for name in self.headers:
            text = self.text(name)
            if found := EXCEPTIONS.search(COMMENT.sub("", text)):
                yield f"{name} contains '{found.group()}', which a game without exceptions and RTTI cannot compile"
            if name in self.c_headers and not text.isascii():
                yield f"{name} is not ASCII"


def errors_of(include):
    with tempfile.TemporaryDirectory() as work:
        checks = Checks(include, work)
        cxx = checks.find("g++", "clang++")
        cc = checks.find("gcc", "clang")
        clang = checks.find("clang++-19")
        checks.add_alone(cc, cxx)
        checks.add_behind_macros(cxx, clang)
        checks.add_foreign(clang)
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            results = list(pool.map(checks.run, checks.jobs))
        for missing in checks.left_out:
            print(f"LEFT OUT: {missing}")
        print(f"{len(checks.jobs)} compilations of {len(checks.headers)} headers")
        return [error for error in results if error] + [*checks.heavy_errors(cxx), *checks.text_errors()]


# Trees with errors, and the errors that the rules must find in them.
AABB = 'static_assert(sizeof(void*) == 8, "needs a 64-bit target");'
BROKEN = [
    ({"broad_phase.h": "inline std::string Name();", "c_api.h": "/* \u00b5 */", "hooks.h": "#include <mutex>"},
     ["broad_phase.h alone", "c_api.h is not ASCII", "hooks.h brings <mutex>"]),
    ({"broad_phase.h": "class Status {};", "c_api.h": "inline int F(int x = 1);"}, ["behind the macros of X11", "c_api.h alone in C11"]),
    ({"broad_phase.h": "inline int F() { return std::numeric_limits<int>::max(); }"}, ["behind the macros of windows.h"]),
    ({"broad_phase.h": "inline void F() { throw static_cast<char>(1); }"}, ["contains 'throw'", "broad_phase.h alone"]),
]
# Checked if a clang for the target is installed.
BROKEN_FOREIGN = [
    ({"broad_phase.h": "static_assert(sizeof(long) == 8);"}, ["in Microsoft's dialect"]),
    ({"aabb.h": "struct Box {};"}, ["should fail with 'needs a 64-bit target'"]),
]


def self_test():
    broken = BROKEN + (BROKEN_FOREIGN if shutil.which("clang++-19") else [])
    for lines, rules in broken:
        with tempfile.TemporaryDirectory() as root:
            folder = pathlib.Path(root) / "sweepstake"
            folder.mkdir()
            for name, line in ({"aabb.h": AABB, "c_api.h": ""} | lines).items():
                (folder / name).write_text(f"#pragma once\n{line}\n", encoding="utf-8")
            errors = errors_of(root)
            for rule in rules:
                if not any(rule in error for error in errors):
                    sys.exit(f"{lines} should give '{rule}', gives {errors}")
    print(f"{sum(len(rules) for _, rules in broken)} rules can fail")


def main():
    if sys.argv[1] == "--self-test":
        self_test()
        return
    errors = errors_of(sys.argv[1])
    if errors:
        sys.exit("\n".join(errors))


main()
