#!/usr/bin/env python3
"""Fails where attacks.md names a test that does not exist, and where a clock is used that must not be.

    attacks_test.py ROOT
"""

import pathlib
import re
import sys

NAMED = re.compile(r"`(\w+\.\w+)`")
TEST = re.compile(r"^TEST(?:_F|_P)?\((\w+),\s*(\w+)\)", re.MULTILINE)
CLAIM = re.compile(r"^\| .* \|$", re.MULTILINE)
MESSAGE = re.compile(r"^message (\w+) \{(.*?)^\}", re.MULTILINE | re.DOTALL)
FIELD = re.compile(r"^\s*(?:repeated |optional )?([\w.]+) (\w+) = \d+", re.MULTILINE)
TIME_OF_DAY = re.compile(r"(?:^|_)(?:unix|utc|wall|date)(?:_|$)")
# Where decisions are made. The wall clock dates sessions, rows and events, for people.
WALL_CLOCK = re.compile(r"system_clock|\btime\(|gettimeofday|CLOCK_REALTIME|unix_time\.h|UnixNow")
STEADY_FOLDERS = ("engine_client/decider", "tests/laboratory/policies", "server/rpc/common", "server/rpc/services")


def table_errors(table, tests):
    for row in CLAIM.findall(table)[2:]:
        proof = row.split("|")[-2]
        if not NAMED.search(proof) and "attacks_test.py" not in proof:
            yield f"no test proves: {row}"
        for name in NAMED.findall(proof):
            if name not in tests and not name.endswith(".py"):
                yield f"there is no test {name}"


def client_messages(protocol):
    """The bodies of what a client's stream may hold, by name."""
    bodies, found, wanted = dict(MESSAGE.findall(protocol)), {}, ["StreamTelemetryRequest"]
    while wanted:
        name = wanted.pop()
        if name in bodies and name not in found:
            found[name] = bodies[name]
            wanted += [kind for kind, _ in FIELD.findall(bodies[name])]
    return found


def clock_errors(root):
    messages = client_messages((root / "proto/sweepstake/v1/telemetry.proto").read_text(encoding="utf-8"))
    if "FrameBatch" not in messages:
        yield "the protocol's messages cannot be read"
    for name, body in messages.items():
        for _, field in FIELD.findall(body):
            if TIME_OF_DAY.search(field):
                yield f"{name}.{field}: a client's clock may be wrong by years"
    for folder in STEADY_FOLDERS:
        for source in sorted((root / folder).rglob("*.[ch]*")):
            if WALL_CLOCK.search(source.read_text(encoding="utf-8")):
                yield f"{source.relative_to(root)}: the wall clock may jump; use rpc::Clock"


def main(root):
    tests = {f"{suite}.{name}" for folder in ("server", "end_to_end", "engine_client", "laboratory")
             for file in (root / "tests" / folder).rglob("*.*") if file.suffix in (".cc", ".h")
             for suite, name in TEST.findall(file.read_text(encoding="utf-8"))}
    errors = [*table_errors((root / "tests/attacks.md").read_text(encoding="utf-8"), tests), *clock_errors(root)]
    print("\n".join(errors) or f"the tests of attacks.md are among the {len(tests)} there are")
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1])))
