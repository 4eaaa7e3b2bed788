#!/usr/bin/env python3
"""Judges AI Decides on a sealed list of unseen scenes, for final figures only.

data/sealed.toml contains a random phrase and the SHA-256 of every line of the list. A rule derives scenes, object counts and seeds from
the phrase, so that everybody can judge but nobody reads the scenes by accident. The list is not stored, the traces are in a temporary
folder, and the output identifies scenes by number. Do not use it while you tune a policy.

Each run is a "look" and makes the list less independent, because its results may influence later changes. Therefore every look is
appended to data/sealed_looks.log at its begin and at its end: date, commit, command, figures. Commit that file.
"""

import argparse
import datetime
import hashlib
import json
import pathlib
import secrets
import shlex
import subprocess
import sys
import tempfile
import tomllib

import conditions
from conditions import Failure
from judging import choosing
from judging.common import InputError, read_goals
from judging.decisions import figure_text

LIST = conditions.DATA / "sealed.toml"
ROWS = ("stationary", "flips", "baselines")
STATIONARY = ("brownian", "rotating-gravity", "hurricane", "suite-b", "suite-g", "suite-h", "few-moving", "nearly-resting",
              "teleporting", "spawning", "planar", "beams", "clusters", "sizes-1-to-1000")
REGIMES = 8
# Scenes with more objects have fewer frames, because tracing is slow.
FULL_LENGTH_OBJECTS = 5_000
HEAD = """# A sealed list of scenes, by the rule of tests/bench/sealed.py: a random phrase, and the SHA-256 of each line. Do not compute the
# scenes. The log in this folder lists each use.
"""


def draw(phrase, *words):
    """Returns a number of 256 bits, derived from the phrase and its purpose."""
    return int.from_bytes(hashlib.sha256("/".join((phrase, *words)).encode()).digest(), "big")


def scene_of(sealed, name, category, frames):
    low, high = sealed["objects"]
    objects = round(low * (high / low) ** (draw(sealed["phrase"], name, "objects") / 2**256))
    if category == "stationary":
        frames = round(frames * min(1, FULL_LENGTH_OBJECTS / objects))
    return {"scene": name, "objects": objects, "frames": frames,
            "seed": draw(sealed["phrase"], name, "seed") % 2**31, "pass": "15m" if category == "stationary" else "12m",
            "category": category}


def scenes_of(sealed, regime_frames):
    """Returns the list. Families are in the order in which they were drawn, each at most once."""
    def drawn(names, count):
        return sorted(names, key=lambda name: draw(sealed["phrase"], name))[:count]
    scenes = [scene_of(sealed, name, "stationary", sealed["frames"]) for name in drawn(STATIONARY, sealed["stationary"])]
    scenes += [scene_of(sealed, name, "changing", REGIMES * regime_frames[name]) for name in drawn(regime_frames, sealed["changing"])]
    return [scene | {"cell": f"sealed-{number}"} for number, scene in enumerate(scenes, 1)]


def commitment(scene):
    line = " ".join(str(scene[word]) for word in ("scene", "objects", "frames", "seed", "pass", "category"))
    return hashlib.sha256(line.encode()).hexdigest()


def read_sealed(path, regime_frames):
    """Returns the scenes of a sealed list, and checks them with their hashes."""
    with open(path, "rb") as file:
        sealed = tomllib.load(file)
    scenes = scenes_of(sealed, regime_frames)
    if [commitment(scene) for scene in scenes] != sealed["commitments"]:
        raise InputError(f"{path}: the rule gives other scenes than those that were sealed; undo its change, or seal a new list")
    return scenes


def seal(path, regime_frames, **sizes):
    """Writes a new list with a random phrase."""
    sealed = {"phrase": secrets.token_hex(16), "stationary": 8, "changing": 4, "objects": [300, 12_000], "frames": 2000} | sizes
    lines = [f"{name} = {json.dumps(value)}" for name, value in sealed.items()]
    hashes = "".join(f'  "{commitment(scene)}",\n' for scene in scenes_of(sealed, regime_frames))
    with open(path, "x", encoding="utf-8") as file:
        file.write(HEAD + "\n".join(lines) + f"\ncommitments = [\n{hashes}]\n")


def commit():
    def git(*words):
        return subprocess.run(["git", "-C", conditions.ROOT, *words], capture_output=True, text=True, check=False).stdout.strip()
    return (git("rev-parse", "--short=12", "HEAD") or "unknown") + ("-changed" if git("status", "--porcelain", "-uno") else "")


def append_look(path, commit_id, *words):
    now = datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")
    with open(path, "a", encoding="utf-8") as file:
        file.write("  ".join([now, commit_id, *words]) + "\n")


def trace(scenes, folder, options, progress):
    """Creates the scenes' traces. The output of the program is not shown, because it names the scenes."""
    for number, scene in enumerate(scenes, 1):
        progress(f"tracing scene {number} of {len(scenes)}")
        done = subprocess.run([options.program, "trace", "--scene", scene["scene"], "--objects", str(scene["objects"]), "--frames",
                               str(scene["frames"]), "--seed", str(scene["seed"]), "--out", folder / (scene["cell"] + ".costs")],
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)
        if done.returncode != 0:
            raise Failure(f"sweepstake-lab trace ended with {done.returncode} at {scene['cell']}")


def figures(goals):
    return "; ".join(f"{goal['goal']}: " + ("nothing to judge" if goal["reached"] is None else
                                            f"{figure_text(goal['unit'], goal['reached'])} {'met' if goal['met'] else 'NOT MET'}")
                     for goal in goals)


def look(options, progress):
    plan = conditions.read_plan()
    scenes = read_sealed(options.list, plan["regime_frames"])
    log = options.list.with_name(options.list.stem + "_looks.log")
    commit_id = commit()
    append_look(log, commit_id, "begun", shlex.join(["tests/bench/sealed.py", *options.words]))
    documents = []
    with tempfile.TemporaryDirectory(prefix="sealed-") as folder:
        trace(scenes, pathlib.Path(folder), options, progress)
        for row in ROWS:
            cells = conditions.play(plan["row"][row], scenes, pathlib.Path(folder), plan, options, progress)
            documents.append({"command": "sealed", "row": row, "list": options.list.name, "policy": options.policy,
                              "seeds": options.seeds, "cells": cells})
    goals = read_goals(choosing.GOALS)["choosing"]
    concluded = [choosing.conclusion(document, goals) for document in documents]
    append_look(log, commit_id, "ended", figures([goal for _, whole, _ in concluded for goal in whole["goals"]]))
    return concluded


def parse(words):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="examples:\n"
        "  tests/bench/sealed.py                       a look: once, after all other work\n"
        "  tests/bench/sealed.py --seal /tmp/mine.toml a list of your own, for a try\n"
        "  tests/bench/sealed.py --list /tmp/mine.toml\n"
        "Exit code: 0 every goal is met, 1 a goal is missed, 2 the measurement failed.")
    parser.add_argument("--list", type=pathlib.Path, default=LIST, metavar="FILE.toml",
                        help="the log of looks is in the same folder (default: %(default)s)")
    parser.add_argument("--seal", type=pathlib.Path, metavar="FILE.toml", help="only write a new list with a random phrase")
    conditions.add_replay_options(parser)
    options = parser.parse_args(words)
    options.words = words
    if options.seal is None:
        conditions.check_program(parser, options)
    return options


def main(words):
    options = parse(words)
    try:
        if options.seal is not None:
            seal(options.seal, conditions.read_plan()["regime_frames"])
            return 0
        concluded = look(options, lambda line: print(line, file=sys.stderr, flush=True))
    except (Failure, InputError, OSError, tomllib.TOMLDecodeError) as failure:
        print(f"sealed.py: {failure}", file=sys.stderr)
        return 2
    if options.json:
        print(json.dumps({"command": "sealed", "rows": [whole for _, whole, _ in concluded]}, indent=2))
    else:
        print("\n".join(text for text, _, _ in concluded), end="")
    return 1 if any(missed for _, _, missed in concluded) else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
