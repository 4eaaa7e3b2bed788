#!/usr/bin/env python3
"""Counts the tuned constants of AI Decides. Fails if their number is not `at_most` of [constants] in tests/bench/data/goals.toml.

A tuned constant is a number that somebody chose, and with another value of which games would choose other arms. More of them fit the
decider to the scenes on which they were chosen, so the number may only fall.

Counted, in engine_client/decider and engine_client/adaptive/guards:
    each `constexpr` number with a name (kName)
    each other number in the code, except 0, 1, 2, 1/2, 1024 and powers of ten, which are mostly units
Not counted:
    files and folders of ELSEWHERE, where no constant is of AI Decides
    names of FIXED: their values follow from mathematics, from another constant, or from the range of a number

It prints each counted constant with its comment, which states the source. A constant without a comment is an error.

    constants_test.py ROOT          counts the constants of the sources at ROOT
    constants_test.py --self-test   shows that each rule can fail
"""

import pathlib
import re
import sys
import tempfile
import tomllib

FOLDERS = ("engine_client/decider", "engine_client/adaptive/guards")
GOALS = "tests/bench/data/goals.toml"
# Each with the reason.
ELSEWHERE = {
    "engine_client/decider/audit/": "the format of the log",
    "engine_client/decider/embedded/": "the limits of files",
    "engine_client/decider/session/": "the rules of every policy, among them the paper's",
    "engine_client/decider/client_reports.h": "the protocol",
    "engine_client/decider/options.cc": "the limits of the settings",
    "engine_client/decider/options.h": "the settings; their defaults are the paper's values",
    "engine_client/decider/types.h": "names and flags",
    "engine_client/decider/policy/diagnosis.cc": "the accuracy of an integral",
    "engine_client/decider/policy/diagnosis.h": "the verdicts that people see; no choice depends on them",
    "engine_client/decider/policy/paper_policy.h": "the paper's policy",
    "engine_client/decider/policy/reward.cc": "the paper's reward",
    "engine_client/decider/policy/reward.h": "the paper's reward",
    "engine_client/decider/pooling/priors_diff.cc": "a comparison that people see",
}
FIXED = {
    "kHalfOfMax": "the range of a number",
    "kLogCostRewardVersion": "a version",
    "kLogNs": "the definition of the reward",
    "kLogRange": "the definition of the reward",
    "kDeviations95": "a quantile of the normal distribution; intervals of 95 % are stored",
    "kMaxArms": "the size of an array",
    "kMaxEvidence": "the range of a number",
    "kMaxLogCost": "the range of a number",
    "kMedianVariance": "π/2",
    "kMinDistance": "the range of a number",
    "kMinLogCost": "the range of a number",
    "kMinSpeed": "the range of a number",
    "kUnmeasured": "a mark",
    "kWithinDeviations": "follows from kWithinShare",
}

NAMED = re.compile(r"\bconstexpr\s+(?:double|float|int|size_t|u?int\d+_t)\s+(k[A-Z]\w*)\s*(?:=|\{)\s*([^;]*?)\}?;")
# Lines and types whose numbers are no constants: includes, and sizes of arrays.
NEUTRAL = re.compile(r'^\s*#.*|"[^"]*"|\'[^\']\'|std::array<[^<>]*>|static_assert\(.*')
NUMBER = re.compile(r"(?<![\w.])\d[\d'.]*(?:e[+-]?\d+)?(?=[uUfFlL]*\b|$)")


def is_unit(number):
    value = float(number.replace("'", ""))
    return value in (0, 0.5, 1, 2, 1024) or re.fullmatch(r"(?:10*(?:\.0*)?|0?\.0*1|1e[+-]?\d+)", number.replace("'", "")) is not None


def comment_of(lines, at):
    """Returns the comment of the constant in line `at`: behind it, or above the group of constants that it belongs to."""
    if "//" in lines[at]:
        return lines[at].split("//", 1)[1].strip()
    above = at - 1
    while above >= 0 and "constexpr" in lines[above]:
        above -= 1
    block = []
    while above >= 0 and lines[above].lstrip().startswith("//"):
        block.insert(0, lines[above].lstrip()[2:].strip())
        above -= 1
    return " ".join(block)


def mentions(lines, name):
    """Returns the first comment line that names the constant, or an empty text."""
    return next((line.lstrip()[2:].strip() for line in lines if line.lstrip().startswith("//") and re.search(rf"\b{name}\b", line)), "")


def constants_of(path, text):
    """Returns the counted constants of a source: where they are, their names or numbers, their values and comments."""
    lines = text.splitlines()
    found = []
    for at, line in enumerate(lines):
        code = NEUTRAL.sub("", line.split("//")[0])
        named = NAMED.search(line)
        if named:
            if named.group(1) not in FIXED:
                found.append((f"{path}:{at + 1}", named.group(1), named.group(2), comment_of(lines, at) or mentions(lines, named.group(1))))
            continue
        found += [(f"{path}:{at + 1}", number, number, line.strip()) for number in NUMBER.findall(code) if not is_unit(number)]
    return found


def sources_of(root):
    for folder in FOLDERS:
        for path in sorted((root / folder).rglob("*")):
            name = path.relative_to(root).as_posix()
            if path.suffix in (".h", ".cc") and not name.startswith(tuple(ELSEWHERE)):
                yield name, path.read_text(encoding="utf-8")


def check(root):
    """Returns the counted constants and the errors."""
    texts = dict(sources_of(root))
    constants = [constant for path, text in texts.items() for constant in constants_of(path, text)]
    with open(root / GOALS, "rb") as file:
        goals = tomllib.load(file)["constants"]
    errors = [f"{where}: {name} has no comment that states its source" for where, name, _, comment in constants
              if not comment]
    everything = "\n".join(texts.values())
    errors += [f"{name} of FIXED does not exist; remove it" for name in FIXED if not re.search(rf"constexpr \w+ {name}\b", everything)]
    errors += [f"{path} of ELSEWHERE does not exist; remove it" for path in ELSEWHERE if not (root / path).exists()]
    if len(constants) > goals["at_most"]:
        errors.append(f"{len(constants)} tuned constants; {GOALS} allows {goals['at_most']}, and the goal is {goals['goal']}")
    elif len(constants) < goals["at_most"]:
        errors.append(f"{len(constants)} tuned constants are fewer than before: set at_most of [constants] in {GOALS} to this number")
    return constants, errors


def text_of(constants, goal):
    lines = [f"{where}  {name} = {value}  // {comment}" if name != value else f"{where}  {value} without a name: {comment}"
             for where, name, value, comment in constants]
    return "\n".join([*lines, f"{len(constants)} tuned constants, goal {goal}"])


GOOD = {
    GOALS: "[constants]\ngoal = 3\nat_most = 4\n",
    "engine_client/decider/policy/a.cc": "#include <a>\n"
    "// Standard deviations, chosen on the tuning list.\nconstexpr double kA = Square(0.3);\nconstexpr uint32_t kB{7};\n\n"
    "constexpr double kWithinShare = 0.7;  // of a normal distribution\nconstexpr double kWithinDeviations = 1.0364;\n"
    'std::array<double, 3> F() { Say("4"); return 1e-9 * 0.5 * Of(2, 1U, 100, 1\'000) / kC3; }\n',
    # The constant is explained above.
    "engine_client/adaptive/guards/a.h": "// A frame of at least kLongNs is judged.\nclass A {\n static constexpr uint64_t kLongNs = 5;\n};\n",
    "engine_client/decider/options.h": "double fps = 0.55;\n",
}
# A changed file, and the error that it must cause.
BAD = [
    ("engine_client/decider/policy/b.cc", "// From kA.\nconstexpr float kNew = 3;\n", "5 tuned constants; "),
    ("engine_client/decider/window.cc", "double F(double x) { return 1.02 * x; }\n", "5 tuned constants; "),
    ("engine_client/adaptive/guards/a.h", "\n", "3 tuned constants are fewer than before"),
    ("engine_client/adaptive/guards/a.h", "constexpr int kC = 3;\n", "a.h:1: kC has no comment"),
    ("engine_client/decider/policy/a.cc", "", "kWithinDeviations of FIXED does not exist"),
]


def write(root, files):
    for path, text in files.items():
        (root / path).parent.mkdir(parents=True, exist_ok=True)
        (root / path).write_text(text, encoding="utf-8")


def self_test():
    # The tree of the test has no other exceptions.
    for exceptions, kept in ((FIXED, "kWithinDeviations"), (ELSEWHERE, "engine_client/decider/options.h")):
        for name in [name for name in exceptions if name != kept]:
            del exceptions[name]
    missed = []
    for path, text, expected in [(None, None, None), *BAD]:
        with tempfile.TemporaryDirectory() as folder:
            write(pathlib.Path(folder), GOOD if path is None else GOOD | {path: text})
            _, errors = check(pathlib.Path(folder))
            if bool(errors) != (path is not None) or (expected and not any(expected in error for error in errors)):
                missed.append(f"{path} {text!r} gave {errors} instead of {expected!r}")
    return missed


def main(arguments):
    if arguments == ["--self-test"]:
        missed = self_test()
        print("\n".join(missed) or f"{len(BAD)} errors were each found")
        return 1 if missed else 0
    if len(arguments) != 1:
        print(__doc__, file=sys.stderr)
        return 2
    root = pathlib.Path(arguments[0])
    constants, errors = check(root)
    with open(root / GOALS, "rb") as file:
        print(text_of(constants, tomllib.load(file)["constants"]["goal"]))
    print("\n".join(errors), file=sys.stderr, end="\n" if errors else "")
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
