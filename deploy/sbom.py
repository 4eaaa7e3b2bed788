#!/usr/bin/env python3
"""Prints a bill of materials (SBOM) of Sweepstake's programs, as CycloneDX 1.5 JSON: the packages of the shared libraries that they
load, the installed header-only libraries that they are compiled with, and the npm packages inside the dashboard. Needs dpkg.

    sbom.py PROGRAM...                                 for instance: deploy/sbom.py build/release/bin/sweepstaked > sbom.json
"""

import argparse
import json
import pathlib
import re
import subprocess
import sys

# Libraries whose code is compiled into the programs.
HEADER_ONLY = ["libboost-dev", "libcli11-dev", "libeigen3-dev", "nlohmann-json3-dev", "libprotozero-dev"]
# The path of a script of the dashboard, which a daemon contains unless it was built without Node.
DASHBOARD = b"/assets/index-"
ROOT = pathlib.Path(__file__).resolve().parent.parent


def output_of(*command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def is_installed(package):
    found = subprocess.run(["dpkg-query", "-W", "-f", "${Status}", package], capture_output=True, text=True, check=False)
    return "ok installed" in found.stdout


def libraries_of(program):
    """The files of the shared libraries that the program loads."""
    found = subprocess.run(["ldd", program], capture_output=True, text=True, check=False)
    if found.returncode != 0:
        sys.exit(f"sbom.py: {program} does not load shared libraries: {found.stderr.strip() or found.stdout.strip()}")
    return {pathlib.Path(path) for path in re.findall(r"(/\S+) \(0x", found.stdout)}


def package_of(library):
    """The Debian package of the file, or None if it belongs to none. A merged /usr has each library at two paths."""
    resolved = library.resolve()
    for path in (resolved, pathlib.Path("/" + str(resolved).removeprefix("/usr/")), library):
        found = subprocess.run(["dpkg-query", "-S", path], capture_output=True, text=True, check=False)
        if found.returncode == 0:
            return found.stdout.split(": ")[0].split(",")[0]
    return None


def licences_of(package):
    """The names of the licences in the package's machine-readable copyright file, in alphabetical order."""
    name = package.split(":")[0]
    try:
        text = pathlib.Path(f"/usr/share/doc/{name}/copyright").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return []
    return sorted({line.removeprefix("License:").strip() for line in text.splitlines() if line.startswith("License:")} - {""})


def component(package):
    name, version, architecture = output_of("dpkg-query", "-W", "-f", "${Package}\t${Version}\t${Architecture}", package).split("\t")
    licences = [{"license": {"name": licence}} for licence in licences_of(package)]
    return {"type": "library", "name": name, "version": version, "purl": f"pkg:deb/debian/{name}@{version}?arch={architecture}",
            **({"licenses": licences} if licences else {})}


def npm_components():
    """The packages that the dashboard's page contains; those for development are not part of it."""
    packages = json.loads((ROOT / "server/dashboard/package-lock.json").read_text(encoding="utf-8"))["packages"]
    for path, package in packages.items():
        if not path or package.get("dev"):
            continue
        name, version = path.removeprefix("node_modules/"), package["version"]
        yield {"type": "library", "name": name, "version": version, "purl": f"pkg:npm/{name.replace('@', '%40')}@{version}",
               **({"licenses": [{"license": {"name": package["license"]}}]} if "license" in package else {})}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0], formatter_class=argparse.RawDescriptionHelpFormatter,
                                     epilog="Example: deploy/sbom.py build/release/bin/sweepstaked > sbom.json")
    parser.add_argument("program", nargs="+", type=pathlib.Path)
    programs = parser.parse_args().program
    for program in programs:
        if not program.is_file():
            sys.exit(f"sbom.py: there is no program {program}; build it first")
    packages = {package for package in HEADER_ONLY if is_installed(package)}
    for library in set().union(*(libraries_of(program) for program in programs)):
        package = package_of(library)
        if package is None:
            sys.exit(f"sbom.py: {library} belongs to no package")
        packages.add(package)
    components = [component(package) for package in packages]
    if any(DASHBOARD in program.read_bytes() for program in programs):
        components += npm_components()
    version = re.search(r"project\(sweepstake VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")).group(1)
    print(json.dumps({
        "bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1,
        "metadata": {"component": {"type": "application", "name": "sweepstake", "version": version}},
        "components": sorted(components, key=lambda each: each["name"]),
    }, indent=2))


if __name__ == "__main__":
    main()
