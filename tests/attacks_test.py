#!/usr/bin/env python3
"""Fails if attacks.md names a test that does not exist, or if code uses a clock that is not allowed.

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
# Decisions must use a steady clock. The wall clock is only for the dates of sessions, rows and events.
WALL_CLOCK = re.compile(r"system_clock|\btime\(|gettimeofday|CLOCK_REALTIME|unix_time\.h|UnixNow")
STEADY = ("engine_client/decider", "tests/laboratory/policies", "server/rpc/common", "server/rpc/services",
          "server/sessions/common/decision_loop.cc", "server/sessions/session_opening.cc", "server/sessions/session_start.cc")


def table_errors(table, tests):
    for row in CLAIM.findall(table)[2:]:
        proof = row.split("|")[-2]
        if not NAMED.search(proof) and "attacks_test.py" not in proof:
            yield f"the row names no test: {row}"
        for name in NAMED.findall(proof):
            if name not in tests and not name.endswith(".py"):
                yield f"the test {name} does not exist"


def client_messages(protocol):
    """Returns the bodies of the messages in a client's stream, by name."""
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
        yield "the messages of the protocol were not found"
    for name, body in messages.items():
        for _, field in FIELD.findall(body):
            if TIME_OF_DAY.search(field):
                yield f"{name}.{field}: remove the time of day: a client's clock may be wrong by years"
    for steady in STEADY:
        for source in [root / steady] if (root / steady).is_file() else sorted((root / steady).rglob("*.[ch]*")):
            if WALL_CLOCK.search(source.read_text(encoding="utf-8")):
                yield f"{source.relative_to(root)}: the wall clock may jump; use sessions::LoopClock"


def main(root):
    tests = {f"{suite}.{name}" for folder in ("server", "end_to_end", "engine_client", "laboratory")
             for file in (root / "tests" / folder).rglob("*.*") if file.suffix in (".cc", ".h")
             for suite, name in TEST.findall(file.read_text(encoding="utf-8"))}
    errors = [*table_errors((root / "tests/attacks.md").read_text(encoding="utf-8"), tests), *clock_errors(root)]
    print("\n".join(errors) or f"all tests in attacks.md exist, among {len(tests)} tests")
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1])))
