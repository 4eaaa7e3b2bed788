#!/usr/bin/env python3
"""Counts the instructions of a frame with NEON and with SSE4. The counts replace times, because no Arm processor is available.

Both programs run the same frames under qemu, which logs every block of instructions that it translates and every one that it
executes. Only instructions between the lines of tests/cross/frames.cc are counted: start-up differs between two runs, because
Highway's library calibrates a timer there. A count does not include latency or parallel execution. Both instruction sets have
registers of 128 bits.
"""

import argparse
import concurrent.futures
import json
import os
import pathlib
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
import tomllib

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "tests" / "bench"))

from judging.common import meets, table  # noqa: E402

BACKENDS = ("BruteForce", "Grid", "SAP", "AxisSweep", "DBVT", "Tracy", "KDTree")
# Each emulated processor has this instruction set, and none that the kernels would use instead.
EMULATORS = {
    "neon": ["qemu-aarch64-static", "-cpu", "neoverse-n1", "-L", "/usr/aarch64-linux-gnu"],
    "sse4": ["qemu-x86_64-static", "-cpu", "Westmere"],
}
# An instruction's address, bytes and name. A long instruction continues in a line that has only bytes.
INSTRUCTION = re.compile(rb"0x\w+:  [0-9a-f ]+  [a-z]")


class RunError(Exception):
    """A program failed, or its results differ from those of the other one."""


def instructions_between_writes(log):
    """Returns the number of instructions executed before each line that the program wrote."""
    lengths = {}
    length = count = 0
    for line in log:
        if line.startswith(b"Trace "):
            block = line[:line.index(b"[")]
            if length > 0:  # A block is translated right before it is first executed.
                lengths[block], length = length, 0
            count += lengths[block]
        elif INSTRUCTION.match(line):
            length += 1
        elif b" write(1," in line:
            yield count
            count = 0


def run(simd, program, cell):
    """Returns the instructions of each frame, and the lines that the program wrote."""
    log, log_end = os.pipe()
    with tempfile.TemporaryFile("w+", encoding="ascii") as output:
        command = [*EMULATORS[simd], "-d", "in_asm,exec,nochain,strace", "-D", f"/dev/fd/{log_end}", program, *cell]
        with subprocess.Popen(command, stdout=output, pass_fds=(log_end,)) as process:
            os.close(log_end)
            with open(log, "rb") as lines:
                counts = list(instructions_between_writes(lines))
        output.seek(0)
        written = output.read().splitlines()
    if process.returncode != 0 or len(counts) != len(written) or written[-1:] != [simd]:
        raise RunError(f"{program} {' '.join(cell)}: {simd} ended with {process.returncode}; its last output was {written[-1:]}")
    return counts[1:-1:2], written[:-1]


def compare(backend, neon, sse4):
    (neon_counts, neon_written), (sse4_counts, sse4_written) = neon, sse4
    if neon_written != sse4_written:
        raise RunError(f"{backend} gives different pairs or checks with NEON and SSE4")
    return {"backend": backend, "neon": round(statistics.mean(neon_counts)), "sse4": round(statistics.mean(sse4_counts)),
            "ratio": sum(neon_counts) / sum(sse4_counts)}


def measure(options):
    """Returns a row per backend, in their order; the runs are independent of each other."""
    programs = {"neon": options.aarch64, "sse4": options.native}
    backends = options.only or BACKENDS
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        runs = {(backend, simd): pool.submit(run, simd, programs[simd], (backend, options.scene, str(options.objects),
                                                                         str(options.frames)))
                for backend in backends for simd in EMULATORS}
        try:
            for backend in backends:
                print(f"{backend} ...", file=sys.stderr, flush=True)
                yield compare(backend, *(runs[backend, simd].result() for simd in EMULATORS))
        finally:
            pool.shutdown(cancel_futures=True)


def text(rows, goal, options):
    def verdict(row):
        return "met" if row["met"] else "NOT MET"

    cells = [[row["backend"], f"{row['neon']}", f"{row['sse4']}", f"{row['ratio']:.2f}", verdict(row)] for row in rows]
    return (f"Instructions of a frame: {options.scene}, {options.objects} objects, mean of {options.frames - 1} frames. "
            f"Goal: NEON ÷ SSE4 at most {goal['at_most']}.\n\n" + table(["backend", "NEON", "SSE4", "ratio", "goal"], cells))


def document(rows, goal, options):
    return json.dumps({"scene": options.scene, "objects": options.objects, "frames": options.frames - 1, "goal": goal,
                       "backends": rows}, indent=2) + "\n"


def require_programs(options):
    for program in (options.native, options.aarch64):
        if not pathlib.Path(program).is_file():
            raise RunError(f"{program} is missing; tests/cross.sh --quick aarch64 builds it")
    for emulator, *_ in EMULATORS.values():
        if shutil.which(emulator) is None:
            raise RunError(f"{emulator} is missing; tests/cross.sh installs it (Debian's qemu-user-static)")


def count_from(least):
    def parse_count(word):
        if not word.isdecimal() or int(word) < least:
            raise argparse.ArgumentTypeError(f"{word} is not a number of at least {least}")
        return int(word)
    return parse_count


def parse(words):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="examples:\n"
        "  tests/cross.sh --quick aarch64      # builds the programs\n"
        "  tests/cross/neon_instructions.py\n"
        "  tests/cross/neon_instructions.py --scene suite-g --only KDTree --only Tracy\n"
        "  tests/cross/neon_instructions.py --frames 4 --json\n"
        "Exit code: 0 every backend meets the goal, 1 a backend misses it, 2 the instructions could not be counted.")
    parser.add_argument("--scene", default="suite-b", help="default: %(default)s")
    parser.add_argument("--objects", type=count_from(1), default=1000, metavar="N", help="default: %(default)s")
    parser.add_argument("--frames", type=count_from(2), default=48, metavar="N",
                        help="number of frames, including the first one, which builds and is not counted. With the default, KDTree "
                        "also splits nodes again in suite-b and suite-g (default: %(default)s)")
    parser.add_argument("--only", choices=BACKENDS, action="append", help="only this backend; may be repeated")
    parser.add_argument("--jobs", type=count_from(1), default=len(os.sched_getaffinity(0)), metavar="N",
                        help="parallel runs (default: one per processor)")
    parser.add_argument("--native", default=ROOT / "build/cross-native/bin/frames", metavar="PROGRAM",
                        help="the program for x86-64 (default: %(default)s)")
    parser.add_argument("--aarch64", default=ROOT / "build/cross-aarch64/bin/frames", metavar="PROGRAM",
                        help="the program for aarch64 (default: %(default)s)")
    parser.add_argument("--goals", default=ROOT / "tests/bench/data/goals.toml", metavar="FILE.toml",
                        help="file whose table [instructions] has the goal (default: %(default)s)")
    parser.add_argument("--json", action="store_true", help="one JSON document on stdout")
    return parser.parse_args(words)


def main(words):
    options = parse(words)
    try:
        goal = tomllib.loads(pathlib.Path(options.goals).read_text(encoding="utf-8"))["instructions"]
        require_programs(options)
        rows = [{**row, "met": meets(goal, row["ratio"])} for row in measure(options)]
    except (RunError, OSError, KeyError, tomllib.TOMLDecodeError) as error:
        print(f"neon_instructions.py: {error}", file=sys.stderr)
        return 2
    print((document if options.json else text)(rows, goal, options), end="")
    return 0 if all(row["met"] for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
