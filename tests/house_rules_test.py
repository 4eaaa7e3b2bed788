#!/usr/bin/env python3
"""Fails if a file breaks a rule of CONTRIBUTING.md that a program can check.

    A folder contains at most 30 files (except for test data: corpus/, golden/, logs/, results/).
    A source file has at most 800 lines (except for generated code: Generated/).
    In the command line only io/ uses the standard streams; a *_command.cc parses options and calls functions.
    A status that the daemon sends has a reason of errors.proto: services create it with Refused.
    Each path in a document, in backticks or as a link, exists. A folder such as `common/` in a table row exists in the
    document's folder or in a folder that the row's first cell names.
    Comments and strings are in plain English: a few patterns that readers did not understand are rejected.

include_direction_test.py checks which folder may include which.

    house_rules_test.py ROOT          checks the files in git at ROOT
    house_rules_test.py --self-test   shows that each rule can fail
"""

import collections
import fnmatch
import pathlib
import posixpath
import re
import subprocess
import sys
import tempfile

MAX_FOLDER_FILES = 30
MAX_LINES = 800

DATA_FOLDERS = {"corpus", "golden", "logs", "results", "Generated"}
SOURCE_SUFFIXES = (".h", ".cc", ".c", ".cs", ".ts", ".tsx", ".js", ".mjs", ".css", ".py", ".sh", ".proto")

# Functions that write to a stream. snprintf and the like write to memory and are allowed.
PRINTING = re.compile(r"\bstd::(?:cout|cerr|clog)\b|(?<![\w.])(?:std::)?(?:f?printf|f?puts|f?putc|putchar|perror|fwrite)\s*\(")
PRINTING_COMMAND = re.compile(r"\bterminal\.(?:out|err)\s*<<")
# Cancelled is allowed: its client has gone and does not receive it.
BARE_STATUS = re.compile(r"\babsl::(?!Cancelled)\w+Error\(|\bgrpc::StatusCode::")
COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)

CODE_BLOCK = re.compile(r"^```.*?^```", re.DOTALL | re.MULTILINE)
QUOTED = re.compile(r"`([^`\n]+)`")
ROW = re.compile(r"^\|([^|\n]*)\|(.*)$", re.MULTILINE)
QUOTED_FOLDER = re.compile(r"`([\w.-]+(?:/[\w.-]+)*/)`")
LINK = re.compile(r"\]\(([^)#\s]+)[^)]*\)")
PATH = re.compile(r"^[\w.*@-]+(?:/[\w.*@-]+)*/?$")
FILE_SUFFIX = re.compile(r"\.(?:h|cc|c|cs|ts|py|sh|proto|toml|cmake|md|txt|json)$")
# Paths that a build or a run creates, or that belong to another program.
MADE = re.compile(r"^(?:build|node_modules|results|usr|etc|var)/|^(?:CMakeLists\.txt|compile_commands\.json|manifest\.json)$")


def is_data(path):
    return any(part in DATA_FOLDERS for part in path.split("/")[:-1])


def folder_errors(files):
    counts = collections.Counter(posixpath.dirname(path) for path in files if not path.endswith(".meta"))
    for folder, count in sorted(counts.items()):
        if count > MAX_FOLDER_FILES and not is_data(folder + "/file"):
            yield f"{folder or '.'}: {count} files; a folder contains at most {MAX_FOLDER_FILES}"


def length_errors(path, text):
    count = text.count("\n")
    if path.endswith(SOURCE_SUFFIXES) and not is_data(path) and count > MAX_LINES:
        yield f"{path}: {count} lines; a source has at most {MAX_LINES}"


def printing_errors(path, text):
    cli = "engine_client/cli/"
    if not path.startswith(cli) or not path.endswith((".h", ".cc")):
        return
    if path.startswith(cli + "io/"):
        return
    patterns = [PRINTING] + ([PRINTING_COMMAND] if path.endswith("_command.cc") else [])
    code = COMMENT.sub(lambda match: "\n" * match.group().count("\n"), text)
    for pattern in patterns:
        for match in pattern.finditer(code):
            line = code.count("\n", 0, match.start()) + 1
            yield f"{path}:{line}: '{match.group()}' prints; move it to engine_client/cli/io"


def status_errors(path, text):
    if not path.startswith(("server/rpc/services/", "server/sessions/", "server/rpc/common/message_validation")):
        return
    for match in BARE_STATUS.finditer(text):
        line = text.count("\n", 0, match.start()) + 1
        yield f"{path}:{line}: '{match.group()}' has no reason; use Refused (server/rpc/common/error_reasons.h)"


# Patterns that a comment block or a string may not begin with, and patterns that it may not contain.
LANGUAGE_SUFFIXES = SOURCE_SUFFIXES + (".cmake", ".txt")
ODD_BEGINNING = re.compile(r"(?:Of |Those of|That of|What is|What was|Who |Whom |Whose |Not where|Likewise)")
ODD_WORDS = re.compile(
    r"so many,|of so many|at most so|\b(?:is|are|was) told|tells of|\banew\b|(?<!there )\bis no |\bit it\b|\bthat that\b|which it has|of it it")
STRING = re.compile(r'"((?:[^"\\]|\\.)*)"')
# Files that are not checked, each with the reason. At most ten.
LANGUAGE_EXCEPTIONS = {
    "tests/house_rules_test.py": "it holds the patterns",
}
# Folders whose language has not been rewritten yet.
LANGUAGE_PENDING = ()


def language_errors(path, text):
    """Checks comment blocks and strings line by line. A block begins if the line before is not a comment."""
    if not path.endswith(LANGUAGE_SUFFIXES) or path in LANGUAGE_EXCEPTIONS or is_data(path) or path.startswith(LANGUAGE_PENDING):
        return
    marks = r"#+" if path.endswith((".py", ".sh", ".cmake", ".txt")) else r"(?://+|/?\*+)"
    comment = re.compile(r"^(.*?)(?:^|\s|\{)" + marks + r"(?:\s+(.*))?$")
    in_block = False
    for number, line in enumerate(text.splitlines(), 1):
        match = comment.match(line)
        words = (match.group(2) or "") if match else ""
        starts = [words] if match and not (in_block and not match.group(1).strip()) else []
        strings = STRING.findall(match.group(1) if match else line)
        in_block = bool(match) and not match.group(1).strip()
        for found in [*filter(None, map(ODD_BEGINNING.match, [*starts, *strings])), *filter(None, map(ODD_WORDS.search, [words, *strings]))]:
            yield f"{path}:{number}: '{found.group()}' is not plain English; write subject, verb, object"


class Tree:
    """The paths that a document may name: files and folders in git."""

    def __init__(self, files):
        self.paths = set(files)
        for path in files:
            while path := posixpath.dirname(path):
                self.paths.add(path)
        self.tops = {path.split("/")[0] for path in files}
        self.names = {posixpath.basename(path) for path in files}

    def has(self, path):
        path = posixpath.normpath(path)
        if "*" in path:
            return any(fnmatch.fnmatchcase(known, path) for known in self.paths)
        return path == "." or path in self.paths

    def misses(self, name, folder):
        """Whether `name`, quoted in a document of `folder`, looks like a path of this tree but does not exist.

        NAME stands for a name of the reader's choice, and `.cc` alone for the source of a header."""
        if not PATH.match(name) or MADE.match(name) or "NAME" in name or re.match(r"^\.\w+$", name):
            return False
        if "/" not in name.rstrip("/"):
            looks = name.endswith((".cc", ".h", ".proto", ".sh", ".py"))
            return looks and not fnmatch.filter(self.names, name)
        first = name.split("/")[0]
        looks = (first in self.tops or posixpath.join(folder, first) in self.paths or
                 first in {"broad_phase", "decision", "cli", "storage", "rpc"} or FILE_SUFFIX.search(name))
        places = ("", folder, "engine_client", "server", "engine_client/include", "engine_client/broad_phase",
                  "engine_client/cli", "proto", "unity_client")
        # `broad_phase/kd/kd_tree` stands for its header and source.
        return bool(looks) and not any(
            self.has(posixpath.join(place, name)) or self.has(posixpath.join(place, name + ".*")) for place in places)


def row_errors(path, prose, tree):
    """A folder in a table row must exist at the top, in the document's folder, or in a folder that the row's first cell names."""
    folder = posixpath.dirname(path)
    for row in ROW.finditer(prose):
        places = [folder, *(posixpath.join(folder, name) for name in QUOTED_FOLDER.findall(row.group(1)))]
        for name in QUOTED_FOLDER.findall(row.group()):
            if not MADE.match(name) and not tree.has(name) and not any(tree.has(posixpath.join(place, name)) for place in places):
                yield f"{path}:{prose.count(chr(10), 0, row.start()) + 1}: `{name}` exists neither beside this document nor in the folder of its row"


def document_errors(path, text, tree):
    if not path.endswith(".md"):
        return
    folder = posixpath.dirname(path)
    prose = CODE_BLOCK.sub(lambda match: "\n" * match.group().count("\n"), text)
    for match in QUOTED.finditer(prose):
        # In a command, check the first word.
        name = match.group(1).split(" ")[0]
        if tree.misses(name, folder):
            yield f"{path}:{prose.count(chr(10), 0, match.start()) + 1}: `{name}` does not exist"
    yield from row_errors(path, prose, tree)
    for match in LINK.finditer(prose):
        if "://" not in match.group(1) and not tree.has(posixpath.join(folder, match.group(1))):
            yield f"{path}:{prose.count(chr(10), 0, match.start()) + 1}: the link to {match.group(1)} leads nowhere"


def check(root, files):
    errors, tree = list(folder_errors(files)), Tree(files)
    for path in files:
        if path.endswith(LANGUAGE_SUFFIXES + (".md",)):
            text = (root / path).read_text(encoding="utf-8")
            errors += length_errors(path, text)
            errors += printing_errors(path, text)
            errors += status_errors(path, text)
            errors += document_errors(path, text, tree)
            errors += language_errors(path, text)
    return errors


def files_of(root):
    listed = subprocess.run(["git", "-C", str(root), "ls-files", "--cached", "--others", "--exclude-standard"],
                            capture_output=True, text=True)
    if listed.returncode != 0:  # an archive of the tree is not a clone
        made = {"build", "node_modules"}
        paths = (path.relative_to(root) for path in root.rglob("*") if path.is_file())
        return sorted(path.as_posix() for path in paths if not made & set(path.parts))
    return sorted(path for path in set(listed.stdout.splitlines()) if (root / path).is_file())


GOOD = {
    "README.md": "`engine_client/cli/io/text_table.cc`, `tests/run.sh asan`, `build/dev/bin`, [bench](tests/bench/README.md)\n",
    "tests/run.sh": "x\n" * MAX_LINES,
    "tests/bench/README.md": "`results/` and `../../README.md`\n",
    "engine_client/README.md": "| `cli/` | in `io/` the terminal, beside `server/rpc/` |\n",
    "engine_client/cli/io/text_table.cc": "void Print() { std::cout << 1; }\n",
    ".ci/good.cc": "// The rest\n// Of a sentence goes on here.\nint a = 1;  // of one\n",
    "engine_client/cli/run_command.cc": "// std::cout\nvoid F() { std::snprintf(buffer, 8, \"\"); }\n",
    **{f"server/rpc/f{index}.cc": "\n" for index in range(MAX_FOLDER_FILES)},
    "unity_client/Generated/Messages.cs": "x\n" * (MAX_LINES + 1),
    **{f"tests/server/golden/{index}.log": "\n" for index in range(MAX_FOLDER_FILES + 1)},
}
# Each causes one error, which begins with the file or folder given first.
BAD = [
    ("server/rpc", "server/rpc/one_more.cc", "\n"),
    ("server/long.cc", "server/long.cc", "x\n" * (MAX_LINES + 1)),
    ("engine_client/cli/game/a.cc", "engine_client/cli/game/a.cc", "void F() { std::cout << 1; }\n"),
    ("engine_client/cli/run_command.cc", "engine_client/cli/run_command.cc", "void F() { std::printf(\"\"); }\n"),
    ("engine_client/cli/run_command.cc", "engine_client/cli/run_command.cc", "void F() { terminal.out << 1; }\n"),
    ("server/rpc/services/a.cc", "server/rpc/services/a.cc", "void F() { End(absl::NotFoundError(\"\")); }\n"),
    (".ci/a.py", ".ci/a.py", "x = 1\n# Of a window's frames one is longer.\n"),
    (".ci/a.cc", ".ci/a.cc", "int a;  // Who reads it\n"),
    (".ci/a.ts", ".ci/a.ts", "/* first\n * nobody is told */\n"),
    (".ci/a.cc", ".ci/a.cc", 'Fail("What is broken");\n'),
    ("server/README.md", "server/README.md", "`server/gone/file.cc`\n"),
    ("server/README.md", "server/README.md", "`rpc/gone.cc`\n"),
    ("server/README.md", "server/README.md", "`gone.cc`\n"),
    ("server/README.md", "server/README.md", "| `rpc/` | in `io/` the command line's terminal |\n"),
    ("server/README.md", "server/README.md", "[gone](../gone.md)\n"),
]


def write(root, path, text):
    (root / path).parent.mkdir(parents=True, exist_ok=True)
    (root / path).write_text(text, encoding="utf-8")


def self_test():
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        for path, text in GOOD.items():
            write(root, path, text)
        missed = ["a valid tree was refused: " + error for error in check(root, sorted(GOOD))]
        for where, path, text in BAD:
            write(root, path, text)
            errors = check(root, sorted({*GOOD, path}))
            if len(errors) != 1 or not errors[0].startswith(where + ":"):
                missed.append(f"{path} {text[:60]!r} gave {errors} instead of one error of {where}")
            (root / path).unlink()
            if path in GOOD:
                write(root, path, GOOD[path])
        return missed


def main(arguments):
    if arguments == ["--self-test"]:
        errors = self_test()
        print("\n".join(errors) or f"{len(BAD)} broken rules were each found")
        return 1 if errors else 0
    if len(arguments) != 1:
        print(__doc__, file=sys.stderr)
        return 2
    root = pathlib.Path(arguments[0])
    files = files_of(root)
    errors = check(root, files) if files else [f"no file under {root}"]
    print("\n".join(errors) or f"{len(files)} files keep the rules")
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
