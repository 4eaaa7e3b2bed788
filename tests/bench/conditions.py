#!/usr/bin/env python3
"""Judges AI Decides in replays under conditions: errors of the lane, other work, flips, extreme and new scenes, sizes, tails.

ROW is a row of data/conditions.toml: it selects the scenes, the conditions and the policies for comparison. The program creates
the missing traces of the scenes in LIST and replays them with `sweepstake-lab replay`. It prints every goal of the row in
data/goals.toml with the reached value and its cells. The row `ablation` compares AI Decides with itself without one of its parts, and
with baselines, in a table of policies and conditions.
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys
import time
import tomllib

from judging import ablation, choosing
from judging.common import InputError
from judging.decisions import read_scenes

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
DATA = HERE / "data"


class Failure(Exception):
    """A called program has failed; the message contains its error."""


def read_plan(path=DATA / "conditions.toml"):
    with open(path, "rb") as file:
        return tomllib.load(file)


def lane_words(model):
    """Converts a lane model (data/lane_model.toml) or the options of a condition to options of `sweepstake-lab replay`."""
    words = []
    for name, value in model.items():
        if value is True:
            words.append("--" + name)
        elif isinstance(value, dict):
            for arm, ratio in value.items():
                words += ["--" + name, arm, str(ratio)]
        else:
            words += ["--" + name, str(value)]
    return words


def condition_words(condition, lane_model):
    return lane_words((lane_model if condition.get("lane_model") else {}) | condition.get("options", {}))


def games_of(row, scenes, regime_frames):
    """Returns the games of a row. Each is a scene with its pass for the replay and the resulting interval of flips."""
    games = [scene | {"flip_s": None} for scene in scenes if scene["category"] in row["categories"]]
    for flip_s in row.get("flip_s", []):
        for scene in {each["cell"]: each for each in scenes if each["scene"] in regime_frames}.values():
            regimes = scene["frames"] / regime_frames[scene["scene"]]
            games.append(scene | {"flip_s": flip_s, "category": "flipping", "pass": f"{round(1000 * regimes * flip_s)}ms"})
    if not games:
        raise InputError("the list has no scene of the row's categories")
    return games


def called(command, what):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise Failure(f"{what} ended with {done.returncode}: {done.stderr.strip()[-800:]}")
    return done.stdout


def replayed(program, games, traces, policies, words):
    """Returns the rows of one replay of all games: for each game, a row per policy, by its name."""
    document = json.loads(called(
        [program, "replay", "--costs", ",".join(str(traces / (game["cell"] + ".costs")) for game in games),
         "--pass", ",".join(game["pass"] for game in games), "--policy", ",".join(policies), "--json", *words], "sweepstake-lab replay"))
    rows = document["rows"]
    count = len(rows) // len(games)
    return [{row["policy"]: row for row in rows[at:at + count]} for at in range(0, len(rows), count)]


def milliseconds(frame):
    """Returns milliseconds per frame: the best fixed arm's time, the loss to it, savings against the median and worst arm, lane time."""
    saved = {arm: frame[arm] - frame["detection"] for arm in ("median", "worst")}
    return {"ms_best": frame["best"], "ms_lost": frame["regret"], "ms_saved_median": saved["median"], "ms_saved_worst": saved["worst"],
            "ms_lane": frame["lane"], "ms_lane_unpaid": frame["lane"] - saved["median"]}


def said(bins, low, high):
    """Returns the number of decisions with P(best) in this range, and the number of those whose leader was the fastest arm."""
    decisions, right = 0, 0.0
    for one in bins:
        if low <= one["low"] and one["high"] <= high:
            decisions += one["decisions"]
            right += one["best"] * one["decisions"]
    return {"p_best_said": decisions, "p_best_right": right}


def place_of(condition, game):
    return {"condition": condition, "cell": game["cell"], "category": game["category"], "flip_s": game["flip_s"]}


def cell_of(condition, game, rows, policy, peers, cold):
    own = rows[policy]
    cell = {**place_of(condition, game), "headroom": own["headroom"], "regret": own["regret_best_fixed"], "ci95": own["ci95"],
            "regret_after_start": own["regret_after_start"], "captured": own["headroom_captured"], "switches": own["switches"],
            "switches_after_start": own["switches_after_start"],
            **milliseconds(own["ms_per_frame"]), **said(own["reliability"], 0.8, 0.9)}
    for peer in peers:
        cell["regret_" + peer] = rows[peer]["regret_best_fixed"]
        cell["excess_" + peer] = cell["regret"] - cell["regret_" + peer]
        cell["ms_saved_" + peer] = rows[peer]["ms_per_frame"]["detection"] - own["ms_per_frame"]["detection"]
    if cold:
        for figure in ("first_right", "regret_first_10_s"):
            cell |= {figure: own[figure], figure + "_cold": cold[policy][figure]}
    return cell


def play(row, scenes, traces, plan, options, progress):
    """Returns the cells of a row: every game under every condition."""
    policies = [options.policy, *row["peers"]]
    games = games_of(row, scenes, plan["regime_frames"])
    with open(options.lane_model, "rb") as file:
        lane_model = tomllib.load(file)
    cells, begin_s = [], time.monotonic()
    for number, name in enumerate(row["conditions"]):
        words = ["--seeds", options.seeds, "--run", options.run, *condition_words(plan["condition"][name], lane_model)]
        results = replayed(options.program, games, traces, policies, [*words, "--priors", row.get("priors", "none")])
        if row.get("compares_policies"):
            cells += [ablation.cell_of(place_of(name, game), rows) for game, rows in zip(games, results)]
        else:
            cold = replayed(options.program, games, traces, policies, words) if "priors" in row else [None] * len(games)
            cells += [cell_of(name, game, rows, options.policy, row["peers"], other) for game, rows, other in zip(games, results, cold)]
        spent_s = time.monotonic() - begin_s
        left_s = spent_s / (number + 1) * (len(row["conditions"]) - number - 1)
        progress(f"{name}: condition {number + 1} of {len(row['conditions'])}, {len(games)} games of {len(results[0])} policies, "
                 f"{left_s:.0f} s left")
    return cells


def trace(scenes_path, traces, row, options):
    words = [HERE / "traces.sh", "--program", options.program]
    if "repeats" in row:
        words += ["--repeats", row["repeats"]]
    done = subprocess.run([str(word) for word in [*words, scenes_path, traces]], stdout=sys.stderr, check=False)
    if done.returncode != 0:
        raise Failure(f"traces.sh ended with {done.returncode}")


def list_name(path):
    """Returns the name of the list's folder of traces, as in decisions.sh: held-out for held_out_scenes.txt."""
    name = path.stem.removesuffix("_scenes")
    return name if name == path.stem else name.replace("_", "-")


def run(options):
    plan = read_plan()
    row = plan["row"][options.row]
    scenes_path = options.list or DATA / row.get("list", "tuning_scenes.txt")
    raw = "-raw" if "repeats" in row else ""
    traces = options.traces or ROOT / "build/traces" / (list_name(scenes_path) + raw)
    trace(scenes_path, traces, row, options)
    cells = play(row, read_scenes(scenes_path), traces, plan, options, lambda line: print(line, file=sys.stderr, flush=True))
    return {"command": "conditions", "row": options.row, "list": scenes_path.name, "policy": options.policy,
            "seeds": options.seeds, "cells": cells}


def add_replay_options(parser):
    parser.add_argument("--program", type=pathlib.Path, default=ROOT / "build/release/bin/sweepstake-lab", metavar="PATH",
                        help="(default: %(default)s)")
    parser.add_argument("--policy", default="default", help="the judged policy (default: %(default)s)")
    parser.add_argument("--seeds", type=int, default=30, help="games of each policy on each trace (default: %(default)s)")
    parser.add_argument("--run", default="15m", help="virtual time of a game (default: %(default)s)")
    parser.add_argument("--lane-model", type=pathlib.Path, default=DATA / "lane_model.toml", metavar="FILE.toml",
                        help="output of lane_model.py (default: %(default)s)")
    parser.add_argument("--json", action="store_true", help="one JSON document on stdout")


def check_program(parser, options):
    if not os.access(options.program, os.X_OK):
        parser.error(f"no program at {options.program}: build preset release, or give --program")


def parse(words):
    rows = read_plan()["row"]
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="examples:\n"
        "  tests/bench/conditions.py stationary\n"
        "  tests/bench/conditions.py flips tests/bench/data/held_out_scenes.txt --json\n"
        "  tests/bench/conditions.py baselines --seeds 10 --policy lane-argmin\n"
        "  tests/bench/conditions.py ablation --seeds 10\n"
        "Exit code: 0 every goal is met, 1 a goal is missed, 2 the measurement failed. README.md in this folder says how long each\n"
        "row takes.")
    parser.add_argument("row", choices=rows, metavar="ROW", help=", ".join(rows))
    parser.add_argument("list", nargs="?", type=pathlib.Path, metavar="LIST.txt",
                        help="the scenes (default: data/tuning_scenes.txt, or the row's list in data/conditions.toml)")
    parser.add_argument("--traces", type=pathlib.Path, metavar="FOLDER", help="(default: build/traces/LIST; LIST-raw for tails)")
    add_replay_options(parser)
    options = parser.parse_args(words)
    check_program(parser, options)
    return options


def main(words):
    options = parse(words)
    try:
        document = run(options)
        if read_plan()["row"][options.row].get("compares_policies"):
            return ablation.conclude(document, options.json)
        return choosing.conclude(document, options.json)
    except (Failure, InputError, OSError, tomllib.TOMLDecodeError) as failure:
        print(f"conditions.py: {failure}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
