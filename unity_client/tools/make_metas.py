#!/usr/bin/env python3
"""Gives each file and folder of the Unity package that has none its .meta, with a GUID made of its path.

    make_metas.py PACKAGE           writes what is missing; a .meta that is there stays, so that a GUID outlives a rename (git mv both)
    make_metas.py PACKAGE --check   fails when one is missing, belongs to nothing, or has the GUID of another

Unity takes no file whose name begins with a dot and no folder whose name ends with ~. The samples in Samples~ have metas all the same: they
are copied into a project together, and a sample's scene finds its scripts by their GUIDs. Plug-ins are placed by a build and are not in the
repository: their metas say for which platform each of them is.
"""

import hashlib
import pathlib
import re
import sys

PACKAGE = "com.sweepstake.broadphase"
GUID = re.compile(r"^guid: ([0-9a-f]{32})$", re.MULTILINE)

# Where a build puts the library, and Unity's names of what may load it: the editor's OS and CPU, the player's target and CPU.
PLUGINS = {
    "Runtime/Plugins/linux-x86_64/libsweepstake.so": ("Linux", "x86_64", {"Linux64": "x86_64"}),
    "Runtime/Plugins/linux-aarch64/libsweepstake.so": (None, None, {"EmbeddedLinux": "ARM64"}),
    "Runtime/Plugins/windows-x86_64/sweepstake.dll": ("Windows", "x86_64", {"Win64": "x86_64"}),
}

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
# Unity's own importer of style sheets is a script of the editor.
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


def plugin_meta(guid, editor_os, editor_cpu, players):
    lines = [f"fileFormatVersion: 2\nguid: {guid}\nPluginImporter:\n  externalObjects: {{}}\n  serializedVersion: 2\n  iconMap: {{}}\n"
             "  executionOrder: {}\n  defineConstraints: []\n  isPreloaded: 0\n  isOverridable: 0\n  isExplicitlyReferenced: 0\n"
             "  validateReferences: 1\n  platformData:\n  - first:\n      Any:\n    second:\n      enabled: 0\n      settings: {}\n"]
    lines.append(f"  - first:\n      Editor: Editor\n    second:\n      enabled: {1 if editor_os else 0}\n      settings:\n"
                 f"        CPU: {editor_cpu or 'AnyCPU'}\n        DefaultValueInitialized: true\n        OS: {editor_os or 'AnyOS'}\n")
    for target, cpu in players.items():
        lines.append(f"  - first:\n      Standalone: {target}\n    second:\n      enabled: 1\n      settings:\n        CPU: {cpu}\n")
    return "".join(lines) + "  userData:\n  assetBundleName:\n  assetBundleVariant:\n"


def is_seen(path):
    """Whether Unity imports it, there or, a sample, where it is copied to."""
    parts = path.parts[1:] if path.parts[0] == "Samples~" else path.parts
    return bool(parts) and not any(part.startswith(".") or part.endswith("~") for part in parts)


def assets(package):
    found = {path.relative_to(package) for path in package.rglob("*")}
    found = {path for path in found if is_seen(path) and path.suffix != ".meta" and path.as_posix() not in PLUGINS}
    for plugin in PLUGINS:
        parents = list(pathlib.PurePosixPath(plugin).parents)[:-1]
        found |= {pathlib.Path(path) for path in (plugin, *parents)}
    return sorted(found)


def meta_of(package, asset):
    name = asset.as_posix()
    guid = hashlib.md5(f"{PACKAGE}/{name}".encode()).hexdigest()
    if name in PLUGINS:
        return plugin_meta(guid, *PLUGINS[name])
    if (package / asset).is_dir() or any(plugin.startswith(name + "/") for plugin in PLUGINS):
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
            meta.parent.mkdir(parents=True, exist_ok=True)
            meta.write_text(meta_of(package, asset), encoding="utf-8")


def errors(package):
    wanted = {f"{asset.as_posix()}.meta" for asset in assets(package)}
    there = {path.relative_to(package).as_posix() for path in package.rglob("*.meta") if is_seen(path.relative_to(package))}
    for name in sorted(wanted - there):
        yield f"{name} is missing; run unity_client/tools/make_metas.py"
    for name in sorted(there - wanted):
        yield f"{name} belongs to nothing"
    owners = {}
    for name in sorted(there & wanted):
        match = GUID.search((package / name).read_text(encoding="utf-8"))
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
