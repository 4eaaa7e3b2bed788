#!/usr/bin/env python3
"""Measures what the shadow lane gets wrong on this machine, and prints it as `conditions.py --lane-model` takes it.

Each arm plays each scene with the lane at work, which visits the active arm, too, on the same frames. A visit's time ÷ the median of
the frame thread's on the frames that the visit measured is the lane's error: its median by arm, over the scenes, is the arm's
ratio, the spread of its logarithm within a game the noise. Visits that the lane's cap ended tell nothing. Contention is the mean
frame after a sweep's frames were copied, for as long as its visits take, ÷ as many frames before the sweep: the median over the
sweeps, mean over the games. The lane looks for copied frames once a millisecond, so that a part of its work is missed. With
--condition the rest of the machine does what it does in live.py; on one processor alone the lane rests, and there is nothing to measure.
Needs Linux and Python 3.11; else nothing should run meanwhile.
"""

import argparse
import csv
import json
import math
import statistics
import sys

import live
from judging.common import or_dash, table

# Frames of a visit from its first one on: the build, the warm-up, and those that are measured (engine_client/adaptive/shadow_schedule.h).
UNMEASURED_FRAMES = 3
VISIT_FRAMES = 8
# Below so many processors' time the lane leaves them to the game.
MIN_QUOTA = 2
CONDITIONS = [condition for condition in live.CONDITIONS if condition != "one-cpu"]
ACTIVE, CAPPED = 1, 2
# Of a normal distribution, quartiles are so many standard deviations apart; spikes do not move them.
QUARTILES_APART = 1.349
MIN_VISITS = 4


class LaneGame(live.Game):
    """Keeps what the lane's visits measured."""

    def read(self, folder):
        super().read(folder)
        csv.field_size_limit(1 << 30)
        with open(folder / "decisions.csv", encoding="utf-8", newline="") as file:
            self.visits = [visit for row in csv.DictReader(file) for visit in visits_of(row["shadow"])]


def visits_of(text):
    """The visits of a cell `shadow` of an audit log: their first frame, ns of a frame, ns of the build, flags."""
    for sample in text.split():
        first_frame, detection_ns, build_ns, *_, flags = map(int, sample.split(":"))
        yield first_frame, detection_ns, build_ns, flags


def errors_of(visits, detection_ns):
    """The logarithms of lane ÷ frame thread of the whole visits of the active arm."""
    errors = []
    for first_frame, ns, _, flags in visits:
        live_ns = detection_ns[first_frame + UNMEASURED_FRAMES:first_frame + VISIT_FRAMES]
        if flags & ACTIVE and not flags & CAPPED and live_ns and ns > 0 and min(live_ns) > 0:
            errors.append(math.log(ns / statistics.median(live_ns)))
    return errors


def work_of(visits):
    """The time of all visits by the sweep's first frame."""
    work_ns = {}
    for first_frame, ns, build_ns, _ in visits:
        work_ns[first_frame] = work_ns.get(first_frame, 0) + build_ns + (VISIT_FRAMES - 1) * ns
    return work_ns


def contention_of(visits, frame_ns):
    """Frames during a sweep's work ÷ as many before it, the median over the sweeps; None where no sweep has both."""
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
    """One game of an arm; None where the lane made too few visits to tell."""
    frame_ns = game.fixed(arm, "--shadow", "on", "--time-scale", str(options.time_scale))
    errors, contention = errors_of(game.visits, game.detection_ns), contention_of(game.visits, frame_ns)
    if len(errors) < MIN_VISITS or contention is None:
        print(f"{arm} in {game.scene}: {len(errors)} visits, lane {game.summary['shadow']['state']}: left out", file=sys.stderr, flush=True)
        return None
    return {"scene": f"{game.scene}-{game.objects}", "arm": arm, "visits": len(errors), "error": statistics.median(errors),
            "noise": spread(errors), "contention": contention}


def model_of(rows, arms, condition):
    """The lane model, and what else was seen."""
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
        raise live.Failure("the lane made too few visits to tell: give more --seconds")
    return model_of(rows, options.arms, options.condition)


def model_text(model):
    """The lane model as data/lane_model.toml has it."""
    lines = [f"{name} = {model[name]:.3f}" for name in ("lane-noise", "lane-contention")]
    return "\n".join([*lines, "", "[lane-ratio]", *(f"{arm} = {ratio:.3f}" for arm, ratio in model["lane-ratio"].items())]) + "\n"


def text(model):
    rows = [(row["scene"], row["arm"], str(row["visits"]), f"{math.exp(row['error']):.3f}", f"{row['noise']:.3f}",
             f"{row['contention']:.3f}") for row in model["rows"]]
    comment = (f"Condition {model['condition']}. Noise up to {model['noise_largest']:.2f}; contention {model['contention']:.3f} ± "
               f"{or_dash(model['contention_half_width'], '{:.3f}'.format)}; SD of ln(ratio) between arms "
               f"{or_dash(model['bias_deviation'], '{:.3f}'.format)}.\n")
    if model["unmeasured_arms"]:
        comment += f"Too few visits, which replays take for a ratio of 1: {', '.join(model['unmeasured_arms'])}. Give more --seconds.\n"
    lines = table(("scene", "arm", "visits", "ratio", "noise", "contention"), rows) + "\n" + comment + "\n"
    return "".join(f"# {line}".rstrip() + "\n" for line in lines.splitlines()) + model_text(model)


def parse(words):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="examples:\n  tests/bench/lane_model.py > mine.toml && tests/bench/conditions.py stationary --lane-model mine.toml\n"
        "  tests/bench/lane_model.py --condition neighbours --scenes hurricane:2000\n"
        "  tests/bench/lane_model.py --condition quota --cpu-quota 3 --json\n"
        "Ends with 0 when it has measured, with 2 when it could not.")
    parser.add_argument("--program", default=live.ROOT / "build/release/bin/sweepstake", metavar="PATH", help="(default: %(default)s)")
    parser.add_argument("--scenes", default=live.SCENES, metavar="SCENE:OBJECTS,…", help="(default: %(default)s)")
    parser.add_argument("--arms", type=lambda word: word.split(","), default=list(live.ARMS), metavar="ARM,…", help="(default: all)")
    parser.add_argument("--condition", choices=CONDITIONS, default="quiet", help="(default: %(default)s)")
    parser.add_argument("--cpu-quota", type=float, default=MIN_QUOTA, metavar="CORES",
                        help="of the condition quota, at least %(default)s")
    live.add_game_options(parser, seconds=5)
    options = parser.parse_args(words)
    live.check_game_options(parser, options, [options.program])
    if not options.cpu_quota >= MIN_QUOTA:
        parser.error(f"with a quota below {MIN_QUOTA} processors the lane rests: there is nothing to measure")
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
