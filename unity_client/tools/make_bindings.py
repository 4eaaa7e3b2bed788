#!/usr/bin/env python3
"""Writes the C# imports of the C ABI with their documentation, the structs of options with texts, and the checks of struct layouts.

    make_bindings.py ROOT           writes NativeMethods.cs, NativeOptions.cs and NativeLayouts.cs in Runtime/Core/LowLevel of the package
    make_bindings.py ROOT --check   fails if the files differ from what this would write

The sources are the C headers and their golden layouts. The structs of NativeOptions.cs are the native forms of the classes in OPTIONS. The
other C# structs are written by hand, with their documentation, and listed in STRUCTS. A field has the C name in PascalCase; an array of three
floats becomes three fields that end with X, Y and Z. Callbacks from the library into managed code are left out on purpose: they would
not survive a domain reload, so executors and hooks stay native.
"""

import html
import pathlib
import re
import sys
import textwrap

HEADERS = "engine_client/include/sweepstake"
GOLDEN = "tests/engine_client/c_api/golden"
OUTPUT = "unity_client/com.sweepstake.broadphase/Runtime/Core/LowLevel"

# Maps the name of each C struct to the name of its C# counterpart.
STRUCTS = {
    "swp_aabb": "Aabb", "swp_pair": "OverlapPair", "swp_world_options": "WorldOptions", "swp_counters": "WorldCounters",
    "swp_session_options": "NativeSessionOptions", "swp_frame_sample": "FrameSample", "swp_switch_command": "SwitchCommand",
    "swp_switch_outcome": "SwitchOutcome", "swp_shadow_stats": "ShadowStats", "swp_verdict": "Verdict",
    "swp_decider_options": "NativeDeciderOptions", "swp_belief": "Belief", "swp_proxies_options": "ProxySetOptions",
    "swp_filter": "ProxyFilter", "swp_proxy_options": "ProxyOptions", "swp_proxy_pair": "ProxyPair", "swp_ray": "RayQuery",
    "swp_ray_hit": "QueryHit", "swp_scene_options": "SceneOptions", "swp_link_options": "NativeLinkOptions",
    "swp_link_stats": "LinkStats", "swp_decision": "Decision", "swp_sphere": "SphereQuery", "swp_box_sweep": "BoxSweepQuery",
    "swp_reward_weights": "RewardWeights",
}
# Options with texts, which a class of the package wraps.
OPTIONS = {"swp_session_options": "SessionOptions", "swp_decider_options": "DeciderOptions", "swp_link_options": "LinkOptions"}
# Structs that contain callbacks. Functions that take them are left out of the C# imports.
LEFT_OUT = {"swp_executor", "swp_hooks"}
# Headers of libraries that the Unity package does not contain.
OTHER_LIBRARIES = {"c_daemon.h"}
HANDLES = {"swp_world", "swp_session", "swp_proxies", "swp_scene", "swp_link"}
SCALARS = {
    "void": "void", "char": "byte", "int32_t": "int", "uint32_t": "uint", "uint64_t": "ulong", "float": "float", "double": "double",
    "swp_result": "ResultCode", "swp_kind": "ObjectKind", "swp_struct": "uint", "swp_mode": "SessionMode",
    "swp_link_action": "LinkAction", "swp_link_text": "LinkText", "swp_shadow_mode": "ShadowMode",
}

# A comment and the functions without blank lines between them, which it documents.
DOCUMENTED = re.compile(r"(?:/\*((?:[^*]|\*(?!/))*)\*/\n)?((?:SWP_API [^;]*;\n)+)")
FUNCTION = re.compile(r"SWP_API ([\w ]+?\**) ?(swp_\w+)\(([^;]*?)\);", re.DOTALL)
PARAMETER = re.compile(r"^(?:const )?(\w+)( const)?(\**) ?(\w+)$")
SIZE = re.compile(r"^SIZE\((\w+), (\d+)\)")
FIELD = re.compile(r"^FIELD\((\w+), (\w+), (\d+), (.+)\)$")
STRUCT_NUMBER = re.compile(r"^VALUE\(SWP_STRUCT_(\w+), (\d+)\)")
ABI = re.compile(r"^VALUE\(SWP_ABI_VERSION, (\d+)\)")
WIDTH = 130  # of a line of documentation
KEYWORDS = {"struct", "which", "object", "params", "ref", "in", "out"} - {"which"}

HEAD = """\
// Written by unity_client/tools/make_bindings.py from the headers of the C ABI.
#nullable enable
"""
METHODS_HEAD = HEAD.replace("#nullable", """\
// The following condition alone decides which builds import the native library. The import of a missing shared library fails at run time. On
// iOS the library is an archive, and without it the imports would break the link of each build. Define SWEEPSTAKE_IOS if the archive is there.
#if !UNITY_5_3_OR_NEWER || UNITY_EDITOR || UNITY_STANDALONE || UNITY_EMBEDDED_LINUX || UNITY_ANDROID || (UNITY_IOS && SWEEPSTAKE_IOS)
#define HAS_LIBRARY
#endif
#nullable""")


def pascal(name):
    return "".join(part[:1].upper() + part[1:] for part in name.split("_"))


def camel(name):
    name = pascal(name)
    name = name[:1].lower() + name[1:]
    return "@" + name if name in KEYWORDS else name


def managed_type(kind, stars):
    if kind in HANDLES:
        return "IntPtr" + stars[1:]
    if kind == "swp_proxy":
        return "ProxyHandle" + stars if stars else "ulong"
    if kind in STRUCTS:
        return STRUCTS[kind] + stars
    return SCALARS[kind] + stars


def parameters(text):
    text = " ".join(text.split())
    if text == "void":
        return ""
    result = []
    for part in text.split(","):
        kind, _, stars, name = PARAMETER.match(part.strip().replace("const ", "")).groups()
        result.append(f"{managed_type(kind, stars)} {camel(name)}")
    return ", ".join(result)


def documentation(comment, header, name):
    """Returns the lines of a function's summary: the text of its comment in the C header."""
    text = " ".join(re.sub(r"^ *\* ?", "", comment, flags=re.MULTILINE).split())
    if not text:
        raise SystemExit(f"make_bindings.py: {header}: write a comment about {name}")
    one_line = f"<summary>{html.escape(text, quote=False)}</summary>"
    lines = [one_line] if len(one_line) <= WIDTH else ["<summary>", *textwrap.wrap(html.escape(text, quote=False), WIDTH), "</summary>"]
    return "".join(f"        /// {line}\n" for line in lines)


def functions(root):
    """Yields (documentation, return type, name, parameters) of each function without callbacks."""
    for header in sorted((root / HEADERS).glob("c_*.h")):
        if header.name in OTHER_LIBRARIES:
            continue
        for comment, declarations in DOCUMENTED.findall(header.read_text(encoding="utf-8")):
            for returned, name, arguments in FUNCTION.findall(declarations):
                if any(left_out in arguments for left_out in LEFT_OUT):
                    continue
                kind, stars = re.match(r"(?:const )?(\w+) ?(\**)", returned).groups()
                yield documentation(comment, header.name, name), managed_type(kind, stars), name, parameters(arguments)


def methods_file(root):
    lines = [METHODS_HEAD + """\
using System;
using System.Runtime.InteropServices;

namespace Sweepstake.LowLevel
{
    /// <summary>
    /// The functions of the C ABI under their own names, for jobs and Burst, with the comments of the C headers. c_api.h has the rules for
    /// threads, ownership, units and errors. The functions use pointers and scalars only, so nothing is marshalled and nothing allocates. All
    /// other code uses the classes of <see cref="Sweepstake"/>, which check results and own the native objects. In a build without the
    /// library, they throw <see cref="NotSupportedException"/>.
    /// </summary>
    public static unsafe class NativeMethods
    {
#if HAS_LIBRARY
        internal static bool HasLibrary => true;
#if UNITY_IOS && !UNITY_EDITOR
        private const string Library = "__Internal";
#else
        private const string Library = "sweepstake";
#endif
"""]
    imports = list(functions(root))
    for summary, returned, name, arguments in imports:
        lines.append(f"""
{summary}        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern {returned} {name}({arguments});
""")
    lines.append("""#else
        internal static bool HasLibrary => false;

        private static NotSupportedException Missing() => new NotSupportedException("Sweepstake has no native library for this platform.");

""")
    lines += [f"        public static {returned} {name}({arguments}) => throw Missing();\n" for _, returned, name, arguments in imports]
    return "".join(lines) + "#endif\n    }\n}\n"


class Layouts:
    def __init__(self, root):
        self.sizes, self.fields, self.numbers, self.abi = {}, {}, {}, None
        for golden in sorted((root / GOLDEN).glob("*.c")):
            if golden.stem + ".h" in OTHER_LIBRARIES:
                continue
            for line in golden.read_text(encoding="utf-8").splitlines():
                self.read(line)

    def read(self, line):
        if match := SIZE.match(line):
            self.sizes[match[1]] = int(match[2])
        elif match := FIELD.match(line):
            self.fields.setdefault(match[1], []).append((match[2], int(match[3]), match[4]))
        elif match := STRUCT_NUMBER.match(line):
            self.numbers["swp_" + match[1].lower()] = int(match[2])
        elif match := ABI.match(line):
            self.abi = int(match[1])

    def grows(self, struct):
        return self.fields[struct][0][0] == "struct_size"


def field_line(field, kind):
    base, stars = re.match(r"(?:const )?(\w+)(\**)$", kind).groups()
    managed = "IntPtr" if base in LEFT_OUT else managed_type(base, stars)
    return f"        {'internal' if field == 'reserved' else 'public'} {managed} {pascal(field)};\n"


def options_file(root):
    layouts = Layouts(root)
    text = HEAD + """\
using System;
using System.Runtime.InteropServices;

namespace Sweepstake.LowLevel
{
"""
    for struct, wrapper in OPTIONS.items():
        text += f"""\
    /// <summary>The native form of <see cref="{wrapper}"/>, which documents the fields. Texts are UTF-8 with a terminating 0.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public unsafe struct {STRUCTS[struct]}
    {{
"""
        text += "".join(field_line(field, kind) for field, _, kind in layouts.fields[struct]) + "    }\n\n"
    return text.rstrip("\n") + "\n}\n"


def struct_check(layouts, struct):
    name = STRUCTS[struct]
    yield f"            var {camel(name)} = default({name});\n"
    yield f"            start = (byte*)&{camel(name)};\n"
    yield (f"            problems.Size(\"{name}\", {layouts.numbers[struct]}, sizeof({name}), {layouts.sizes[struct]}, "
           f"{'true' if layouts.grows(struct) else 'false'});\n")
    for field, offset, kind in layouts.fields[struct]:
        member, take = pascal(field), "&"
        if kind == "float[3]":
            member += "X"
        elif kind.endswith("]"):
            take = ""
        yield f"            problems.Field(\"{name}.{member}\", (byte*){take}{camel(name)}.{member} - start, {offset});\n"


def layouts_file(root):
    layouts = Layouts(root)
    unknown = set(layouts.sizes) - set(STRUCTS) - LEFT_OUT
    if unknown:
        raise SystemExit(f"make_bindings.py: add the C# structs of {', '.join(sorted(unknown))} to STRUCTS")
    structs = [struct for struct in sorted(layouts.sizes, key=layouts.numbers.get) if struct in STRUCTS]
    text = HEAD + f"""\
namespace Sweepstake.LowLevel
{{
    /// <summary>The offset of each field in C, to compare with this runtime and with the loaded library.</summary>
    internal static unsafe class NativeLayouts
    {{
        /// <summary>SWP_ABI_VERSION of the headers.</summary>
        internal const uint AbiVersion = {layouts.abi};

        internal static void Check(LayoutProblems problems)
        {{
"""
    text += "".join(f"            Check{STRUCTS[struct]}(problems);\n" for struct in structs) + "        }\n"
    for struct in structs:
        text += f"\n        private static void Check{STRUCTS[struct]}(LayoutProblems problems)\n        {{\n            byte* start;\n"
        text += "".join(struct_check(layouts, struct)) + "        }\n"
    return text + "    }\n}\n"


def main(arguments):
    if not 1 <= len(arguments) <= 2 or arguments[1:] not in ([], ["--check"]):
        print(__doc__, file=sys.stderr)
        return 2
    root, check = pathlib.Path(arguments[0]), len(arguments) == 2
    stale = 0
    for name, text in (("NativeMethods.cs", methods_file(root)), ("NativeOptions.cs", options_file(root)), ("NativeLayouts.cs", layouts_file(root))):
        path = root / OUTPUT / name
        if not check:
            path.write_text(text, encoding="utf-8")
        elif not path.is_file() or path.read_text(encoding="utf-8") != text:
            print(f"{path} does not match the C headers; run unity_client/tools/make_bindings.py {root}")
            stale = 1
    return stale


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
