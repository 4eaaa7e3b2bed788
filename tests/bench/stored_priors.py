#!/usr/bin/env python3
"""Measures the effect of stored priors on a live game: right, wrong and no priors, through a daemon that is restarted.

For each scene, a game without a shadow lane tries every arm, and a real `sweepstaked` with its SQLite store learns from it. Then the
daemon ends. Each round starts daemons on a copy of that store (right), on a store with its evidence but reversed ranking of the arms
(wrong), and on an empty store (none). AI Decides plays the scene with each of them, in turns with every fixed arm that is near the
best. Regret is the mean frame time ÷ that of the best fixed arm, minus 1, over the frames that all played, at equal speed and with
the time of the lane as in live.py. Needs Linux and Python 3.11; the machine should be otherwise idle.
"""

import argparse
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

import live
from daemon_load import Daemon
from daemon_load import Failure as DaemonFailure
from judging import choosing
from judging.common import InputError

KINDS = ("right", "wrong", "none")
SERVER_OPTIONS = ("--max-time-scale", "1000")
EVIDENCE = ("alpha_increment", "beta_increment", "window_count")


class Store:
    """A folder with a daemon's data, which several daemons use one after the other."""

    def __init__(self, options, folder):
        self.options, self.folder = options, folder
        self.folder.mkdir(exist_ok=True)

    def __enter__(self):
        self.daemon = Daemon(self.options.programs, self.folder, server_options=SERVER_OPTIONS)
        return self.daemon

    def __exit__(self, *_):
        self.daemon.stop()


def reversed_ranking(records):
    """Returns evidence in which the best arm has the record of the worst, and so on. One record per arm."""
    def mean(record):
        return record["alpha_increment"] / (record["alpha_increment"] + record["beta_increment"])
    ranked = sorted(records, key=mean)
    return [record | {word: mirror[word] for word in EVIDENCE} for record, mirror in zip(ranked, reversed(ranked))]


def transfer(daemon, command, *arguments):
    done = subprocess.run(list(map(str, daemon.sweepstake("priors", command, *arguments))), capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise live.Failure(f"sweepstake priors {command} ended with {done.returncode}: {done.stderr.strip()}")


def teach(game, options, folder):
    """Returns the stores of the three kinds, without running daemons."""
    stores = {kind: Store(options, folder / kind) for kind in KINDS}
    file = folder / "priors.json"
    with stores["right"] as daemon:
        game.decider = ["--daemon", daemon.address]
        game.decided("--shadow", "off")
        transfer(daemon, "export", "--out", file)
    priors = json.loads(file.read_text())
    priors["records"] = reversed_ranking(priors["records"])
    file.write_text(json.dumps(priors))
    with stores["wrong"] as daemon:
        transfer(daemon, "import", "--promote", "--in", file)
    return stores


def play_with(game, store, kind, options, folder):
    """Plays a game whose daemon starts on a copy of the store, so that games do not learn from each other; returns the frames."""
    copy = folder / "copy"
    shutil.copytree(store.folder, copy)
    try:
        with Store(options, copy) as daemon:
            game.decider = ["--daemon", daemon.address]
            frames = game.decided()
    finally:
        shutil.rmtree(copy)
    if (game.summary["prior_sources"] > 0) != (kind != "none"):
        raise live.Failure(f"the daemon gave priors of {game.summary['prior_sources']} sources to the game with {kind} priors")
    return frames


def play_round(game, arms, stores, options, folder, number):
    names = [*KINDS, *arms]
    turn = number % len(names)
    games, rest_ns, lane_shares = {}, {}, {}
    for name in names[turn:] + names[:turn]:
        if name in KINDS:
            games[name] = play_with(game, stores[name], name, options, folder)
            lane_shares[name] = game.summary["shadow"]["frame_share"]
        else:
            game.decider = ["--embedded"]
            games[name] = game.fixed(name, "--shadow", "off")
        rest_ns[name] = game.rest_ns
    reference = live.over_same_frames(list, rest_ns)[arms[0]]
    mean = {name: live.at_equal_speed(games[name], rest_ns[name], reference) for name in games}
    best_ns = min(mean[arm] for arm in arms)
    return {kind: mean[kind] / best_ns - 1 + lane_shares[kind] for kind in KINDS}


def cell_of(game, options, folder, progress):
    medians = live.median_frames(game, options)
    arms = [arm for arm in live.ARMS if medians[arm] <= options.near * min(medians.values())]
    stores = teach(game, options, folder)
    rounds = []
    for number in range(options.rounds):
        rounds.append(play_round(game, arms, stores, options, folder, number))
        progress(f"{game.scene} {game.objects}: round {number + 1} of {options.rounds}, " +
                 ", ".join(f"{kind} {100 * regret:+.2f}%" for kind, regret in rounds[-1].items()))
    cell = {"cell": f"{game.scene}-{game.objects}", "rounds": options.rounds}
    for kind in KINDS:
        cell["regret_" + kind], cell["half_width_" + kind] = live.interval([each[kind] for each in rounds])
    return cell


def run(options):
    options.program = options.programs / "sweepstake"
    cells = []
    for scene, objects in live.parse_scenes(options.scenes):
        with tempfile.TemporaryDirectory(prefix="sweepstake-priors-") as folder:
            cells.append(cell_of(live.Game(options, scene, objects), options, pathlib.Path(folder),
                                 lambda line: print(line, file=sys.stderr, flush=True)))
    return {"command": "stored_priors", "row": "priors", "policy": options.policy, "seconds": options.seconds,
            "time_scale": options.time_scale, "cells": cells}


def parse(words):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="examples:\n  tests/bench/stored_priors.py\n  tests/bench/stored_priors.py --scenes hurricane:2000 --rounds 2 --json\n"
        "Exit code: 0 every goal is met, 1 a goal is missed, 2 the measurement failed.")
    parser.add_argument("--programs", type=pathlib.Path, default=live.ROOT / "build/release/bin", metavar="FOLDER",
                        help="folder with sweepstaked and sweepstake (default: %(default)s)")
    parser.add_argument("--scenes", default=live.SCENES, metavar="SCENE:OBJECTS,…", help="(default: %(default)s)")
    live.add_game_options(parser, seconds=15, rounds=5, near=1.15)
    options = parser.parse_args(words)
    live.check_game_options(parser, options, [options.programs / name for name in ("sweepstake", "sweepstaked")], "--programs")
    return options


def main(words):
    options = parse(words)
    try:
        return choosing.conclude(run(options), options.json)
    except (live.Failure, DaemonFailure, InputError, OSError) as failure:
        print(f"stored_priors.py: {failure}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
