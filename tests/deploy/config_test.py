#!/usr/bin/env python3
"""Checks each configuration of the daemon in deploy/ and in its documents with `sweepstaked check-config`.

    config_test.py ROOT SWEEPSTAKED
"""

import pathlib
import re
import subprocess
import sys
import tempfile

ROOT, DAEMON = (pathlib.Path(path).resolve() for path in sys.argv[1:3])


def configurations():
    for file in sorted((ROOT / "deploy").rglob("*.toml")):
        yield file.relative_to(ROOT), file.read_text(encoding="utf-8")
    for file in sorted((ROOT / "deploy").rglob("*.md")):
        for text in re.findall(r"^```toml\n(.*?)^```", file.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL):
            yield file.relative_to(ROOT), text


def main():
    failures = 0
    with tempfile.TemporaryDirectory(prefix="sweepstake-") as folder:
        checked = list(configurations())
        assert len({name for name, _ in checked}) >= 2, "a document and a file have configurations"
        for name, text in checked:
            file = pathlib.Path(folder) / "checked.toml"
            file.write_text(text, encoding="utf-8")
            result = subprocess.run([DAEMON, "check-config", file], capture_output=True, text=True, check=False)
            if result.returncode != 0:
                print(f"{name}: {result.stderr.strip()}")
                failures += 1
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
