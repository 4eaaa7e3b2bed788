#!/usr/bin/env python3
"""Compares the bill of materials of the daemon (deploy/sbom.py) with the packages of this system.

    sbom_test.py ROOT DAEMON
"""

import json
import pathlib
import shutil
import subprocess
import sys


def main():
    root, daemon = map(pathlib.Path, sys.argv[1:])
    if not shutil.which("dpkg-query"):
        sys.exit(77)
    script = root / "deploy" / "sbom.py"
    document = json.loads(subprocess.run([script, daemon], capture_output=True, text=True, check=True).stdout)
    assert (document["bomFormat"], document["specVersion"]) == ("CycloneDX", "1.5")
    components = {each["name"]: each for each in document["components"]}
    assert len(components) == len(document["components"]), "a package is listed twice"
    for name in ["libgrpc29", "libsqlite3-0", "libssl3", "libeigen3-dev"]:
        if subprocess.run(["dpkg-query", "-W", name], capture_output=True, check=False).returncode != 0:
            continue  # another release of the distribution
        version = subprocess.run(["dpkg-query", "-W", "-f", "${Version}", name], capture_output=True, text=True, check=True).stdout
        assert components[name]["version"] == version, name
        assert components[name]["purl"].startswith(f"pkg:deb/debian/{name}@"), name
    has_dashboard = b"/assets/index-" in daemon.read_bytes()
    assert ("preact" in components) == has_dashboard, "the dashboard contains Preact"
    assert "vite" not in components, "only used to build the dashboard"
    assert "libgtest-dev" not in components, "only what the daemon contains or loads"
    missing = subprocess.run([script, "/nowhere"], capture_output=True, text=True, check=False)
    assert missing.returncode == 1 and "there is no program /nowhere" in missing.stderr, missing
    text = subprocess.run([script, script], capture_output=True, text=True, check=False)
    assert text.returncode == 1 and "does not load shared libraries" in text.stderr, text
    print(len(components), "packages")


if __name__ == "__main__":
    main()
