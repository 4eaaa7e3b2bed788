"""Checks that one seed gives the same boxes and pairs with every instruction set of this machine.

  simd_fingerprints_test.py FINGERPRINT

FINGERPRINT is the program that tests/cross.sh runs on other platforms. Exit status: 0 equal, 1 different.
"""

import os
import pathlib
import subprocess
import sys
import tempfile

SIMD_TARGETS = ("avx512", "avx2", "sse4", "sve2", "sve", "neon", "scalar")


def fingerprint(program, folder, target):
    """Returns the output of the program, or None if the machine does not have the instruction set."""
    out = pathlib.Path(folder) / f"{target}.txt"
    done = subprocess.run([program, out], env={**os.environ, "SWEEPSTAKE_CLIENT_SIMD": target}, capture_output=True, text=True,
                          check=False)
    if "unknown instruction set" in done.stderr:
        return None
    if done.returncode != 0:
        raise SystemExit(f"{target}: {done.stderr.strip()}")
    return out.read_text(encoding="ascii")


def main(program):
    with tempfile.TemporaryDirectory() as folder:
        found = {target: text for target in SIMD_TARGETS if (text := fingerprint(program, folder, target))}
    if len(found) < 2:
        raise SystemExit(f"only {', '.join(found) or 'no instruction set'} ran, so the outputs cannot be compared")
    first, *others = found
    for target in others:
        if found[target] != found[first]:
            raise SystemExit(f"the output of {target} differs from that of {first}")
    print(f"{', '.join(found)}: {len(found[first].splitlines())} lines, equal")


if __name__ == "__main__":
    main(sys.argv[1])
