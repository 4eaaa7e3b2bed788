#!/usr/bin/env python3
"""What choosing is worth: the best arm against always KDTree, over many scenes and counts, and how much of it AI Decides gets.

For each scene and object count a short game of every arm shows which come near the best; then AI Decides, those arms and KDTree
play the same frames in turns, with `sweepstake run --embedded`. The figures are detection times, which is what the arms differ in,
over the frames that all played: worth is KDTree's ÷ the best arm's. What was captured is ln(KDTree ÷ AI Decides), summed over all
cells, ÷ ln(KDTree ÷ best arm), summed; where KDTree is the best, AI Decides can only lose. Nothing else should run meanwhile.
"""

import argparse
import math
import statistics
import sys

import live
from judging import choosing
from judging.common import InputError

SCENES = ("brownian,rotating-gravity,hurricane,free-fall,random-gravity,suite-b,suite-g,suite-h,rest-and-motion,waves,storms,"
          "gather-and-scatter,day-and-night,arrivals,count-changing,spawning,nearly-resting,few-moving,falling,one-huge,"
          "teleporting,beams,clusters,planar,sizes-1-to-1000,mixture")
ALWAYS = "KDTree"


def detection(game, name):
    if name == "AI Decides":
        game.decided()
    else:
        game.fixed(name, "--shadow", "off")
    return game.detection_ns


def contenders(game, options):
    """The arms that come near the best in short games, and KDTree."""
    frames = {}
    for arm in live.ARMS:
        game.fixed(arm, "--shadow", "off", seconds=max(options.seconds / 15, 0.05))
        frames[arm] = game.detection_ns
    medians = live.over_same_frames(statistics.median, frames)
    best = min(medians.values())
    return [arm for arm in live.ARMS if arm == ALWAYS or medians[arm] <= options.near * best]


def cell_of(game, options):
    names = ["AI Decides", *contenders(game, options)]
    sums = dict.fromkeys(names, 0.0)
    for number in range(options.rounds):
        turn = number % len(names)
        mean = live.means({name: detection(game, name) for name in names[turn:] + names[:turn]})
        for name in names:
            sums[name] += mean[name]
    best = min(names[1:], key=sums.get)
    worth, gain = sums[ALWAYS] / sums[best], sums[ALWAYS] / sums["AI Decides"]
    return {"cell": f"{game.scene}-{game.objects}", "best": best, "worth": worth, "gain": gain,
            "regret": sums["AI Decides"] / sums[best] - 1, "best_ms": sums[best] / options.rounds / 1e6,
            "log_worth": math.log(worth), "log_gain": math.log(gain)}


def run(options):
    scenes = options.scenes.split(",")
    games = [live.Game(options, scene, objects) for objects in options.objects for scene in scenes]
    cells = []
    for number, game in enumerate(games, 1):
        cells.append(cell_of(game, options))
        print(f"{number} of {len(games)}: {cells[-1]['cell']}, {cells[-1]['best']} is the best, worth {cells[-1]['worth']:.2f}, "
              f"AI Decides {cells[-1]['gain']:.2f}", file=sys.stderr, flush=True)
    return {"command": "worth", "row": "worth", "policy": options.policy, "seconds": options.seconds, "rounds": options.rounds,
            "always_best": f"{sum(cell['best'] == ALWAYS for cell in cells)} of {len(cells)}",
            "mean_worth": math.exp(statistics.fmean(cell["log_worth"] for cell in cells)), "cells": cells}


def counts(text):
    return [int(word) for word in text.split(",")]


def parse(words):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="examples:\n  tests/bench/worth.py\n  tests/bench/worth.py --scenes hurricane,nearly-resting --objects 3000 --rounds 3\n"
        "Ends with 0 when every goal is met, with 1 when one is missed, with 2 when it could not be run.")
    parser.add_argument("--program", default=live.ROOT / "build/release/bin/sweepstake", metavar="PATH", help="(default: %(default)s)")
    parser.add_argument("--scenes", default=SCENES, metavar="SCENE,…", help="(default: %(default)s)")
    parser.add_argument("--objects", type=counts, default=counts("300,3000,20000"), metavar="N,…", help="(default: 300,3000,20000)")
    live.add_game_options(parser, seconds=5, rounds=1, near=1.3)
    options = parser.parse_args(words)
    live.check_game_options(parser, options, [options.program])
    return options


def main(words):
    options = parse(words)
    try:
        return choosing.conclude(run(options), options.json)
    except (live.Failure, InputError, OSError) as failure:
        print(f"worth.py: {failure}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
