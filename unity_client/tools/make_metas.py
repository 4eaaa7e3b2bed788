#!/usr/bin/env python3
"""Writes the missing .meta of each file and folder of the Unity package, with a GUID derived from its path.

    make_metas.py PACKAGE           writes missing files; an existing .meta stays, so that a GUID survives a rename (git mv both)
    make_metas.py PACKAGE --check   fails if one is missing, belongs to no file or folder, or has the GUID of another

Unity ignores files whose name begins with a dot and folders whose name ends with ~. The samples in Samples~ need metas nevertheless: they
are copied into a project together with them, and a sample's scene finds its scripts by their GUIDs. Plug-ins are not in the repository. Their
metas, which select the platform of each plug-in, are in plugin_metas, and a build installs them together with the plug-in.
"""

import hashlib
import pathlib
import re
import sys

PACKAGE = "com.sweepstake.broadphase"
GUID = re.compile(r"^guid: ([0-9a-f]{32})$", re.MULTILINE)

# The .meta files of plug-ins, in the same folder structure as in the package.
TEMPLATES = pathlib.Path(__file__).resolve().parent / "plugin_metas"

FOLDER = """\
fileFormatVersion: 2
guid: {guid}
folderAsset: yes
DefaultImporter:
  externalObjects: {{}}
  userData:
  assetBundleName:
  assetBundleVariant:
"""
SCRIPT = """\
fileFormatVersion: 2
guid: {guid}
MonoImporter:
  externalObjects: {{}}
  serializedVersion: 2
  defaultReferences: []
  executionOrder: 0
  icon: {{instanceID: 0}}
  userData:
  assetBundleName:
  assetBundleVariant:
"""
OTHER = """\
fileFormatVersion: 2
guid: {guid}
{importer}:
  externalObjects: {{}}
  userData:
  assetBundleName:
  assetBundleVariant:
"""
IMPORTERS = {".asmdef": "AssemblyDefinitionImporter", ".md": "TextScriptImporter", ".json": "TextScriptImporter", ".txt": "TextScriptImporter",
             ".shader": "ShaderImporter"}
# Style sheets are imported by a script of the editor. The GUID identifies that script.
STYLE = """\
fileFormatVersion: 2
guid: {guid}
ScriptedImporter:
  internalIDToNameTable: []
  externalObjects: {{}}
  serializedVersion: 2
  userData:
  assetBundleName:
  assetBundleVariant:
  script: {{fileID: 12385, guid: 0000000000000000e000000000000000, type: 0}}
  disableValidation: 0
"""


def template(asset):
    """The template of the meta of a plug-in or of its folder; the file does not exist for other assets."""
    return TEMPLATES / f"{asset}.meta"


def is_seen(path):
    """Whether Unity imports the file; a sample is imported after it was copied into a project."""
    parts = path.parts[1:] if path.parts[0] == "Samples~" else path.parts
    return bool(parts) and not any(part.startswith(".") or part.endswith("~") for part in parts)


def assets(package):
    found = {path.relative_to(package) for path in package.rglob("*")}
    return sorted(path for path in found if is_seen(path) and path.suffix != ".meta")


def meta_of(package, asset):
    if template(asset).is_file():
        return template(asset).read_text(encoding="utf-8")
    guid = hashlib.md5(f"{PACKAGE}/{asset.as_posix()}".encode()).hexdigest()
    if (package / asset).is_dir():
        return FOLDER.format(guid=guid)
    if asset.suffix == ".cs":
        return SCRIPT.format(guid=guid)
    if asset.suffix == ".uss":
        return STYLE.format(guid=guid)
    return OTHER.format(guid=guid, importer=IMPORTERS.get(asset.suffix, "DefaultImporter"))


def write(package):
    for asset in assets(package):
        meta = package / f"{asset}.meta"
        if not meta.exists():
            meta.write_text(meta_of(package, asset), encoding="utf-8")


def errors(package):
    wanted = {f"{asset.as_posix()}.meta" for asset in assets(package)}
    there = {path.relative_to(package).as_posix() for path in package.rglob("*.meta") if is_seen(path.relative_to(package))}
    for name in sorted(wanted - there):
        yield f"{name} is missing; run unity_client/tools/make_metas.py"
    for name in sorted(there - wanted):
        yield f"{name} belongs to no file or folder; delete it"
    files = {path.relative_to(TEMPLATES).as_posix(): path for path in TEMPLATES.rglob("*.meta")}
    files.update({name: package / name for name in there & wanted})
    owners = {}
    for name, file in sorted(files.items()):
        match = GUID.search(file.read_text(encoding="utf-8"))
        if not match:
            yield f"{name} has no GUID"
        elif match[1] in owners:
            yield f"{name} has the GUID of {owners[match[1]]}"
        else:
            owners[match[1]] = name


def main(arguments):
    if not 1 <= len(arguments) <= 2 or arguments[1:] not in ([], ["--check"]):
        print(__doc__, file=sys.stderr)
        return 2
    package = pathlib.Path(arguments[0])
    if arguments[1:]:
        found = list(errors(package))
        print("\n".join(found) or "each asset has its meta")
        return 1 if found else 0
    write(package)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
