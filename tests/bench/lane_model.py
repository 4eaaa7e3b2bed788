#!/usr/bin/env python3
"""Measures the errors of the shadow lane on this machine, and prints them in the format of `conditions.py --lane-model`.

Each arm plays each scene with a working lane, which also visits the active arm, on the same frames. The error of a visit is its time ÷
the median time of the frame thread on the frames of the visit. The median per arm, over the scenes, is the arm's ratio; the spread of
its logarithm within a game is the noise. Visits that the lane's time cap ended are ignored.

Contention compares the mean frame during a sweep's visits, after its frames were copied, with equally many frames before the sweep. It
is the median over the sweeps and the mean over the games. The lane checks for copied frames once a millisecond, so a part of its work
is missed. With --condition the rest of the machine is loaded as in live.py. On one processor the lane does not run, so nothing can be
measured. Needs Linux and Python 3.11; the machine should be otherwise idle.
"""

import argparse
import csv
import json
import math
import statistics
import sys

import live
from judging.common import or_dash, table

# A visit of the lane has VISIT_FRAMES frames. The first UNMEASURED_FRAMES of them, the build and the warm-up, are not measured
# (engine_client/adaptive/shadow_schedule.h).
UNMEASURED_FRAMES = 3
VISIT_FRAMES = 8
# With a quota of fewer processors the lane does not run, so that the game gets all of their time.
MIN_QUOTA = 2
CONDITIONS = [condition for condition in live.CONDITIONS if condition != "one-cpu"]
ACTIVE, CAPPED = 1, 2
# Distance between the quartiles of a normal distribution, in standard deviations. The deviation is estimated from the quartiles, because
# spikes do not change them.
QUARTILES_APART = 1.349
MIN_VISITS = 4


class LaneGame(live.Game):
    """A game that also keeps the measurements of the lane's visits."""

    def read(self, folder):
        super().read(folder)
        with open(folder / "decisions.csv", encoding="utf-8", newline="") as file:
            self.visits = [visit_of(row) for row in csv.DictReader(file) if row["shadow_arm"]]


def visit_of(row):
    """Returns a visit in a line of an audit log: first frame, ns per frame, ns of the build, flags."""
    return tuple(int(row["shadow_" + name]) for name in ("first_frame_index", "detection_time_ns", "build_time_ns", "flags"))


def errors_of(visits, detection_ns):
    """Returns ln(lane ÷ frame thread) for the complete visits of the active arm."""
    errors = []
    for first_frame, ns, _, flags in visits:
        live_ns = detection_ns[first_frame + UNMEASURED_FRAMES:first_frame + VISIT_FRAMES]
        if flags & ACTIVE and not flags & CAPPED and live_ns and ns > 0 and min(live_ns) > 0:
            errors.append(math.log(ns / statistics.median(live_ns)))
    return errors


def work_of(visits):
    """Returns the time of all visits of a sweep, by the sweep's first frame."""
    work_ns = {}
    for first_frame, ns, build_ns, _ in visits:
        work_ns[first_frame] = work_ns.get(first_frame, 0) + build_ns + (VISIT_FRAMES - 1) * ns
    return work_ns


def contention_of(visits, frame_ns):
    """Returns frames during a sweep's work ÷ equally many before it, the median over the sweeps; None if no sweep has both."""
    ratios = []
    for first_frame, work_ns in work_of(visits).items():
        begin = end = first_frame + VISIT_FRAMES
        while end < len(frame_ns) and work_ns > 0:
            work_ns -= frame_ns[end]
            end += 1
        count = end - begin
        if work_ns <= 0 and first_frame >= count:
            ratios.append(sum(frame_ns[begin:end]) / sum(frame_ns[first_frame - count:first_frame]))
    return statistics.median(ratios) if ratios else None


def spread(errors):
    low, _, high = statistics.quantiles(errors, n=4)
    return (high - low) / QUARTILES_APART


def measure(game, arm, options):
    """Plays one game of an arm; None if the lane made too few visits."""
    frame_ns = game.fixed(arm, "--shadow", "on", "--time-scale", str(options.time_scale))
    errors, contention = errors_of(game.visits, game.detection_ns), contention_of(game.visits, frame_ns)
    if len(errors) < MIN_VISITS or contention is None:
        print(f"{arm} in {game.scene}: {len(errors)} visits, lane {game.summary['shadow']['state']}: left out", file=sys.stderr, flush=True)
        return None
    return {"scene": f"{game.scene}-{game.objects}", "arm": arm, "visits": len(errors), "error": statistics.median(errors),
            "noise": spread(errors), "contention": contention}


def model_of(rows, arms, condition):
    """Returns the lane model and other measurements."""
    by_arm = {arm: [row["error"] for row in rows if row["arm"] == arm] for arm in arms}
    errors = {arm: statistics.fmean(values) for arm, values in by_arm.items() if values}
    contention, half_width = live.interval([row["contention"] for row in rows])
    return {"command": "lane_model", "condition": condition, "lane-noise": statistics.fmean(row["noise"] for row in rows),
            "noise_largest": max(row["noise"] for row in rows), "lane-contention": max(contention, 1.0),
            "contention": contention, "contention_half_width": half_width,
            "bias_deviation": statistics.stdev(errors.values()) if len(errors) > 1 else None,
            "lane-ratio": {arm: math.exp(error) for arm, error in errors.items()},
            "unmeasured_arms": [arm for arm in arms if arm not in errors], "rows": rows}


def run(options):
    rows = []
    cells = [(scene, objects, arm) for scene, objects in live.parse_scenes(options.scenes) for arm in options.arms]
    with live.quota_group(options.condition, options.cpu_quota) as group, live.other_work(options.condition):
        for number, (scene, objects, arm) in enumerate(cells, 1):
            game = LaneGame(options, scene, objects, options.condition)
            game.group = group
            row = measure(game, arm, options)
            if row is None:
                continue
            rows.append(row)
            print(f"{number} of {len(cells)}: {arm} in {row['scene']}, {row['visits']} visits, lane ÷ frame thread "
                  f"{math.exp(row['error']):.2f}, noise {row['noise']:.2f}", file=sys.stderr, flush=True)
    if not rows:
        raise live.Failure("the lane made too few visits: increase --seconds")
    return model_of(rows, options.arms, options.condition)


def model_text(model):
    """Formats the lane model like data/lane_model.toml."""
    lines = [f"{name} = {model[name]:.3f}" for name in ("lane-noise", "lane-contention")]
    return "\n".join([*lines, "", "[lane-ratio]", *(f"{arm} = {ratio:.3f}" for arm, ratio in model["lane-ratio"].items())]) + "\n"


def text(model):
    rows = [(row["scene"], row["arm"], str(row["visits"]), f"{math.exp(row['error']):.3f}", f"{row['noise']:.3f}",
             f"{row['contention']:.3f}") for row in model["rows"]]
    comment = (f"Condition {model['condition']}. Noise up to {model['noise_largest']:.2f}; contention {model['contention']:.3f} ± "
               f"{or_dash(model['contention_half_width'], '{:.3f}'.format)}; SD of ln(ratio) between arms "
               f"{or_dash(model['bias_deviation'], '{:.3f}'.format)}.\n")
    if model["unmeasured_arms"]:
        comment += f"Too few visits, so replays use a ratio of 1: {', '.join(model['unmeasured_arms'])}. Increase --seconds.\n"
    lines = table(("scene", "arm", "visits", "ratio", "noise", "contention"), rows) + "\n" + comment + "\n"
    return "".join(f"# {line}".rstrip() + "\n" for line in lines.splitlines()) + model_text(model)


def parse(words):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="examples:\n  tests/bench/lane_model.py > mine.toml && tests/bench/conditions.py stationary --lane-model mine.toml\n"
        "  tests/bench/lane_model.py --condition neighbours --scenes hurricane:2000\n"
        "  tests/bench/lane_model.py --condition quota --cpu-quota 3 --json\n"
        "Exit code: 0 measured, 2 the measurement failed.")
    parser.add_argument("--program", default=live.ROOT / "build/release/bin/sweepstake", metavar="PATH", help="the program sweepstake (default: %(default)s)")
    parser.add_argument("--scenes", default=live.SCENES, metavar="SCENE:OBJECTS,…", help="scenes and their object counts (default: %(default)s)")
    parser.add_argument("--arms", type=lambda word: word.split(","), default=list(live.ARMS), metavar="ARM,…", help="arms to measure (default: all)")
    parser.add_argument("--condition", choices=CONDITIONS, default="quiet", help="(default: %(default)s)")
    parser.add_argument("--cpu-quota", type=float, default=MIN_QUOTA, metavar="CORES",
                        help="processors of the game in the condition quota, at least %(default)s (the default)")
    live.add_game_options(parser, seconds=5)
    options = parser.parse_args(words)
    live.check_game_options(parser, options, [options.program])
    if not options.cpu_quota >= MIN_QUOTA:
        parser.error(f"with a quota below {MIN_QUOTA} processors the lane rests, so nothing can be measured")
    if unknown := set(options.arms) - set(live.ARMS):
        parser.error(f"unknown arm '{unknown.pop()}', must be one of {', '.join(live.ARMS)}")
    return options


def main(words):
    options = parse(words)
    try:
        model = run(options)
    except (live.Failure, OSError) as failure:
        print(f"lane_model.py: {failure}", file=sys.stderr)
        return 2
    print(json.dumps(model, indent=2) if options.json else text(model), end="\n" if options.json else "")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
