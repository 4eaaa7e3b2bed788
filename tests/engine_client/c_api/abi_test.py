#!/usr/bin/env python3
"""Fails if the C ABI differs from golden/: every struct, field, value and function of each c_*.h.

    abi_test.py ROOT           compares the headers of the tree at ROOT with the golden files, and requires a test for each struct with a
                               size and each function with a pointer
    abi_test.py ROOT --write   writes the golden files after an allowed change
    abi_test.py --self-test    shows that each rule can fail

Allowed are new functions, values and structs, and new fields at the end of a struct with a struct_size. The former size of such a struct
is added to kEarlierSizes (engine_client/c_api/sized_struct.h). An addition increments SWP_ABI_REVISION, once per release. All other
changes would break callers that are already compiled. Never allowed are padding, which could not be used later, and structs by value,
which Unity's Burst cannot pass.

This script computes the layouts by the rule that all our platforms share (natural alignment, 64 bits). The golden files are C and compiled
by the tests, so that each compiler confirms them.
"""

import pathlib
import re
import sys

HEADERS = "engine_client/include/sweepstake"
TESTS = "tests/engine_client/c_api"
GOLDEN = TESTS + "/golden"
EARLIER_SIZES = "engine_client/c_api/sized_struct.h"

# SWP_ABI_REVISION of the latest release. After the first release, --write refuses changes that would break its callers.
RELEASED_REVISION = None

SCALARS = {"uint32_t": 4, "int32_t": 4, "uint64_t": 8, "int64_t": 8, "float": 4, "double": 8}
POINTER = 8

COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)
DIRECTIVE = re.compile(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*$", re.MULTILINE)
CONSTANT = re.compile(r"#define (SWP_[A-Z_]+) (0x[0-9a-fA-F]+|\d+)U?\s*$", re.MULTILINE)
DECLARATION = re.compile(
    r"typedef struct (?P<struct>\w+) \{(?P<fields>.*?)\} (?P=struct);"
    r"|typedef struct (?P<handle>\w+) (?P=handle);"
    r"|enum \{(?P<values>.*?)\};"
    r"|typedef (?P<result>[\w ]+\*?) \(\*(?P<callback>\w+)\)\((?P<callback_parameters>.*?)\);"
    r"|typedef (?P<aliased>\w+) (?P<alias>\w+);"
    r"|SWP_API (?P<returned>[\w ]+?\**) ?(?P<function>\w+)\((?P<parameters>.*?)\);", re.DOTALL)
FIELD = re.compile(r"^(?P<type>.+?) ?(?P<name>\w+)(?P<array>(?:\[\d+\])*)$")
FUNCTION_FIELD = re.compile(r"^(?P<result>.+?) ?\(\*(?P<name>\w+)\)\((?P<parameters>.*)\)$")


class Broken(Exception):
    pass


def parameter_types(parameters):
    types = []
    for parameter in (part.strip() for part in parameters.split(",")):
        match = re.match(r"^(.*?[\w*]) ?\b(\w+)$", parameter)
        types.append(match.group(1).rstrip() if match and parameter != "void" else parameter)
    return ", ".join(types)


class Abi:
    """The lines of each header's golden file, computed from the texts of all headers."""

    def __init__(self, headers):
        self.aliases, self.structs, self.lines, self.revision = {}, {}, {}, 0
        for name, text in headers.items():
            self.lines[name] = list(self.header_lines(name, text))

    def header_lines(self, name, text):
        text = COMMENT.sub(" ", text)
        for constant, value in CONSTANT.findall(text):
            if constant == "SWP_ABI_REVISION":
                self.revision = int(value, 0)
            yield f"VALUE({constant}, {value})"
        text = re.sub(r"\s+", " ", DIRECTIVE.sub("", text))
        for match in DECLARATION.finditer(text):
            yield from self.declaration_lines(match)
        rest = DECLARATION.sub("", text).replace('extern "C" {', "").replace("}", "").strip()
        if rest:
            raise Broken(f"{name}: cannot parse: {rest[:200]}")

    def declaration_lines(self, match):
        if match["struct"]:
            yield from self.struct_lines(match["struct"], match["fields"])
        elif match["handle"]:
            self.structs[match["handle"]] = None
            yield f"HANDLE({match['handle']})"
        elif match["values"]:
            for value in match["values"].split(","):
                name, equals, number = value.partition("=")
                if not equals:
                    raise Broken(f"{name.strip()} needs an explicit value")
                yield f"VALUE({name.strip()}, {number.strip()})"
        elif match["callback"]:
            self.aliases[match["callback"]] = POINTER
            yield f"CALLBACK({match['callback']}, {match['result']} (*)({self.by_value(match['callback_parameters'])}))"
        elif match["alias"]:
            self.aliases[match["alias"]] = SCALARS[match["aliased"]]
            yield f"ALIAS({match['alias']}, {match['aliased']})"
        else:
            parameters = self.by_value(match["parameters"])
            if match["returned"] in self.structs:
                raise Broken(f"{match['function']} returns a struct by value")
            yield f"FUNCTION({match['function']}, {match['returned']} (*)({parameters}))"

    def by_value(self, parameters):
        types = parameter_types(parameters)
        for kind in types.split(", "):
            if kind.replace("const ", "") in self.structs:
                raise Broken(f"'{parameters}' passes a struct by value")
        return types

    def size_and_alignment(self, kind):
        if kind.endswith("*"):
            return POINTER, POINTER
        kind = kind.replace("const ", "")
        if kind in self.structs:
            return self.structs[kind]
        size = self.aliases.get(kind) or SCALARS.get(kind)
        if not size:
            raise Broken(f"the size of {kind} is not known")
        return size, size

    def struct_lines(self, struct, fields):
        offset, widest, lines = 0, 1, []
        for field in (part.strip() for part in fields.split(";")):
            if not field:
                continue
            pointer = FUNCTION_FIELD.match(field)
            match = pointer or FIELD.match(field)
            array = "" if pointer else match["array"]
            size, alignment = (POINTER, POINTER) if pointer else self.size_and_alignment(match["type"])
            for length in re.findall(r"\d+", array):
                size *= int(length)
            if offset % alignment:
                raise Broken(f"{struct} has padding before {match['name']}: name it reserved, or move the field")
            if match["name"] == "struct_size" and offset:
                raise Broken(f"struct_size must be the first field of {struct}")
            kind = f"{match['result']} (*)({parameter_types(match['parameters'])})" if pointer else match["type"] + array
            lines.append(f"FIELD({struct}, {match['name']}, {offset}, {kind})")
            offset, widest = offset + size, max(widest, alignment)
        if offset % widest:
            raise Broken(f"{struct} has padding at its end: name it reserved")
        self.structs[struct] = offset, widest
        return [f"SIZE({struct}, {offset})", *lines]


def golden_text(header, lines):
    return (f"/* {header} as it is in ABI 3. Written by abi_test.py, which says what may change. */\n"
            '#include "tests/engine_client/c_api/abi.h"\n\n/* clang-format off */\n' + "\n".join(lines) + "\n")


def golden_lines(text):
    return [line for line in text.splitlines() if re.match(r"[A-Z]+\(", line)]


def grown(line, new_lines, earlier_sizes):
    """Whether a SIZE line changed because the struct has grown at its end, and its former size is in kEarlierSizes."""
    match = re.match(r"SIZE\((\w+), (\d+)\)", line)
    return bool(match) and f"FIELD({match[1]}, struct_size, 0, uint32_t)" in new_lines and \
        int(match[2]) in earlier_sizes.get(match[1], ())


def earlier_sizes_of(text):
    """kEarlierSizes of each struct."""
    return {struct: [int(size) for size in re.findall(r"\d+", sizes)]
            for struct, sizes in re.findall(r"kEarlierSizes<(swp_\w+)>\{([^}]*)\}", text)}


def refusals(old, new, earlier_sizes, new_revision, released):
    """Returns why a change is not allowed; `old` and `new` are lines."""
    if released is None:
        return []
    errors = [f"{line}: callers of the release rely on it" for line in old
              if line not in new and not line.startswith("VALUE(SWP_ABI_REVISION") and not grown(line, new, earlier_sizes)]
    if old != new and new_revision <= released:
        errors.append(f"the release has revision {released}: raise SWP_ABI_REVISION in c_api.h")
    return errors


def differences(header, old, new):
    for line in old:
        if line not in new:
            yield f"{header}: changed or gone: {line}"
    for line in new:
        if line not in old:
            yield f"{header}: new: {line}"
    if sorted(old) == sorted(new) and old != new:
        yield f"{header}: in another order"


def read(root):
    names = ["c_api.h"] + sorted(path.name for path in (root / HEADERS).glob("c_*.h") if path.name != "c_api.h")
    return Abi({name: (root / HEADERS / name).read_text(encoding="utf-8") for name in names})


def untested(lines, tests):
    """Yields structs and functions without a test of sizes or arguments; `tests` is the text of the C tests."""
    for line in lines:
        struct = re.match(r"FIELD\((\w+), struct_size,", line)
        if struct and f"{{sizeof({struct[1]})," not in tests:
            yield f"{struct[1]} is not in structs_test.c: add a test of sizes that are shorter, longer or invalid"
        function = re.match(r"FUNCTION\((\w+), swp_result \(\*\)\(.*\*", line)
        if function and not re.search(rf"REFUSED\(\s*{function[1]}\(", tests):
            yield f"{function[1]}: add a test of NULL and invalid values to argument_test.c"


def unnamed(abi):
    """Yields structs whose size bindings of other languages cannot read from swp_struct_size."""
    for struct in (name for name, size in abi.structs.items() if size):
        constant = "SWP_STRUCT_" + struct.removeprefix("swp_").upper()
        if not any(line.startswith(f"VALUE({constant}, ") for line in abi.lines["c_api.h"]):
            yield f"{struct} has no {constant} in c_api.h and no case in swp_struct_size"


def tests_of(root):
    return "".join(path.read_text(encoding="utf-8") for path in sorted((root / TESTS).glob("*_test.c")))


def read_golden(root, header):
    path = root / GOLDEN / header.replace(".h", ".c")
    return golden_lines(path.read_text(encoding="utf-8")) if path.exists() else []


def write(root, abi):
    earlier_sizes = earlier_sizes_of((root / EARLIER_SIZES).read_text(encoding="utf-8"))
    errors = []
    for header, lines in abi.lines.items():
        errors += refusals(read_golden(root, header), lines, earlier_sizes, abi.revision, RELEASED_REVISION)
    if errors:
        return errors
    for header, lines in abi.lines.items():
        (root / GOLDEN / header.replace(".h", ".c")).write_text(golden_text(header, lines), encoding="utf-8")
    return []


ADVICE = """
The C ABI has changed. If the change adds something (a function, a value, a struct, a field at the end of a struct with struct_size):
  increment SWP_ABI_REVISION if the latest release has the current one, add the former size of a struct that grew to kEarlierSizes
  (engine_client/c_api/sized_struct.h), add new functions to the tests of tests/engine_client/c_api, and run
  python3 tests/engine_client/c_api/abi_test.py . --write
All other changes break callers that are already compiled: revert them."""


def self_test():
    def lines(text):
        return Abi({"c.h": text}).lines["c.h"]

    def is_broken(text):
        try:
            lines(text)
        except Broken:
            return True
        return False

    options = "typedef struct swp_o { uint32_t struct_size; uint32_t b; } swp_o;"
    longer = options.replace("b;", "b; uint64_t c;")
    sizes = {"swp_o": [8]}
    checks = {
        "fields have offsets": "FIELD(swp_o, c, 8, uint64_t)" in lines(longer),
        "arrays have sizes": "SIZE(swp_a, 24)" in lines("typedef struct swp_a { float min[3]; float max[3]; } swp_a;"),
        "parameters have no names": "FUNCTION(swp_f, int32_t (*)(const char*, uint32_t))" in lines("SWP_API int32_t swp_f(const char* text, uint32_t n);"),
        "padding is found": is_broken("typedef struct swp_p { uint32_t a; uint64_t b; } swp_p;"),
        "padding at the end is found": is_broken("typedef struct swp_p { uint64_t b; uint32_t a; } swp_p;"),
        "structs by value are found": is_broken(options + " SWP_API void swp_f(swp_o options);"),
        "returned structs are found": is_broken(options + " SWP_API swp_o swp_f(void);"),
        "struct_size comes first": is_broken("typedef struct swp_p { uint32_t a; uint32_t struct_size; } swp_p;"),
        "an unknown declaration is found": is_broken("union swp_u { int a; };"),
        "enum values must be explicit": is_broken("enum { SWP_A };"),
        "before a release every change is allowed": not refusals(lines(options), [], {}, 0, None),
        "an addition needs a revision": refusals(lines(options), lines(longer), sizes, 0, 0),
        "an addition with a revision is allowed": not refusals(lines(options), lines(longer), sizes, 1, 0),
        "a struct that grew needs its former size": refusals(lines(options), lines(longer), {}, 1, 0),
        "a removed field is refused": refusals(lines(longer), lines(options), sizes, 1, 0),
        "former sizes are read": earlier_sizes_of("std::array<uint32_t, 2> kEarlierSizes<swp_o>{8, 16};") == {"swp_o": [8, 16]},
        "a struct without a test is found": len(list(untested(lines(options), ""))) == 1,
        "a function without a test is found": len(list(untested(["FUNCTION(swp_f, swp_result (*)(const char*))"], "REFUSED(swp_g("))) == 1,
        "a function with a test is found": not list(untested(["FUNCTION(swp_f, swp_result (*)(const char*))"], "REFUSED(swp_f(NULL")),
        "another order is found": list(differences("c.h", ["A()", "B()"], ["B()", "A()"])),
    }
    return [f"not true: {what}" for what, holds in checks.items() if not holds]


def main(arguments):
    if arguments == ["--self-test"]:
        errors = self_test()
        print("\n".join(errors) or "each rule can fail")
        return 1 if errors else 0
    if not arguments or arguments[1:] not in ([], ["--write"]):
        print(__doc__, file=sys.stderr)
        return 2
    root = pathlib.Path(arguments[0])
    try:
        abi = read(root)
    except Broken as broken:
        print(broken)
        return 1
    if arguments[1:] == ["--write"]:
        errors = write(root, abi)
    else:
        errors = [*unnamed(abi), *untested(sum(abi.lines.values(), []), tests_of(root))]
        changes = [error for header, lines in abi.lines.items() for error in differences(header, read_golden(root, header), lines)]
        errors += [*changes, ADVICE] if changes else []
    done = "written" if arguments[1:] else "unchanged"
    print("\n".join(errors) or f"{sum(map(len, abi.lines.values()))} declarations are {done}")
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
