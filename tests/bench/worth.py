#!/usr/bin/env python3
"""Measures the worth of choosing: the best arm compared with always KDTree, over many scenes and counts, and the share that AI Decides captures.

For each scene and object count a short game of every arm selects the best one. (A separate game is needed: the minimum of the measured
times would be biased towards luck.) Then AI Decides, that arm and KDTree play the same frames in turns, with `sweepstake run --embedded`.
The figures are detection times, in which the arms differ, over the frames that all played. They are at equal speed as in live.py if
the scene has enough other work to measure the speed, and include the cost of the shadow lane. Worth is the time of KDTree ÷ the time
of the best arm. The captured share is the sum of ln(KDTree ÷ AI Decides) over all cells ÷ the sum of ln(KDTree ÷ best arm). If KDTree is
the best, AI Decides can only lose. The machine should be otherwise idle.

The saving that AI Decides reports against KDTree, with which its games begin, is compared with the measured one, without the cost of
the lane. saving_error is their difference ÷ the time of KDTree.
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
# The work besides detection shows the speed of the machine only if it takes at least this share of the frame time.
LEAST_REST = 0.1


def play(game, name):
    """Plays a game; returns the detection and the other work of each frame in ns."""
    if name == "AI Decides":
        game.decided()
    else:
        game.fixed(name, "--shadow", "off")
    return game.detection_ns, game.rest_ns


def mean_detections(games, lane_share):
    """Returns the mean detection time of each game over the frames that all played. lane_share is the share of the lane in AI Decides'
    frames."""
    detection_ns = live.over_same_frames(list, {name: detection for name, (detection, _) in games.items()})
    rest_ns = live.over_same_frames(list, {name: rest for name, (_, rest) in games.items()})
    decided, rest = (sum(times["AI Decides"]) for times in (detection_ns, rest_ns))
    if min(sum(rest_ns[name]) for name in games) < LEAST_REST * (decided + rest):
        return {name: statistics.fmean(times) for name, times in detection_ns.items()}
    mean = {name: live.at_equal_speed(times, rest_ns[name], rest_ns["AI Decides"]) for name, times in detection_ns.items()}
    return mean | {"AI Decides": mean["AI Decides"] * (1 + lane_share * (decided + rest) / decided)}


def best_arm(game, options):
    frames = {}
    for arm in live.ARMS:
        game.fixed(arm, "--shadow", "off", seconds=max(options.seconds / 15, 0.05))
        frames[arm] = game.detection_ns
    medians = live.over_same_frames(statistics.median, frames)
    return min(live.ARMS, key=medians.get)


def saving_of(always_us, decided_us, reported_us):
    """Returns the measured and the reported saving per frame in µs, and their difference ÷ always_us; null if nothing was reported."""
    known = [each for each in reported_us if each is not None]
    reported = statistics.fmean(known) if known else None
    saved = always_us - decided_us
    return {"saved_us": saved, "reported_us": reported, "saving_error": None if reported is None else abs(reported - saved) / always_us}


def cell_of(game, options):
    best = best_arm(game, options)
    names = ["AI Decides", best] if best == ALWAYS else ["AI Decides", best, ALWAYS]
    sums = dict.fromkeys(names, 0.0)
    reported_us, without_lane = [], 0.0
    for number in range(options.rounds):
        turn = number % len(names)
        games = {}
        for name in names[turn:] + names[:turn]:
            games[name] = play(game, name)
            if name == "AI Decides":
                lane_share = game.summary["shadow"]["frame_share"]
                reported_us.append(game.summary["saved_against_initial_us"])
        mean = mean_detections(games, lane_share)
        for name in names:
            sums[name] += mean[name]
        without_lane += mean_detections(games, 0)["AI Decides"]
    worth, gain = sums[ALWAYS] / sums[best], sums[ALWAYS] / sums["AI Decides"]
    return {"cell": f"{game.scene}-{game.objects}", "best": best, "worth": worth, "gain": gain,
            "regret": sums["AI Decides"] / sums[best] - 1, "best_ms": sums[best] / options.rounds / 1e6,
            "log_worth": math.log(worth), "log_gain": math.log(gain),
            **saving_of(sums[ALWAYS] / options.rounds / 1e3, without_lane / options.rounds / 1e3, reported_us)}


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
        "Exit code: 0 every goal is met, 1 a goal is missed, 2 the measurement failed.")
    parser.add_argument("--program", default=live.ROOT / "build/release/bin/sweepstake", metavar="PATH", help="(default: %(default)s)")
    parser.add_argument("--scenes", default=SCENES, metavar="SCENE,…", help="(default: %(default)s)")
    parser.add_argument("--objects", type=counts, default=counts("300,3000,20000"), metavar="N,…", help="(default: 300,3000,20000)")
    live.add_game_options(parser, seconds=5, rounds=1)
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
