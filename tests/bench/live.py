#!/usr/bin/env python3
"""Measures AI Decides in live games: the frame time compared with the best fixed arm on the same frames, in turns.

For each condition and scene, each round plays one game with AI Decides and one with every arm that is near the best one, in rotating
order, with `sweepstake run --embedded`. The regret of a round is the mean frame time of AI Decides ÷ that of the best fixed arm,
minus 1, over the frames that all of them played. The table shows the mean of the rounds with its 95 % interval.

The speed of a machine, above all of a virtual one, changes by the second and would hide the result. The rest of a frame, without the
detection, is the same work with every arm. If this rest took longer in a block of one game than in another, the machine was slower, and
the block's time is corrected. This correction also removes the slowdown by the shadow lane, which is therefore added again as the game
measured it, during its bursts of work and between them. The raw regret has no correction.

One more pair of games plays the best arm with and without the shadow lane, for the cost of the lane alone, as ratios of the mean and
of the 99.9th percentile frame without correction. The column choice isolates the choice of arms: each frame of AI Decides counts with
the typical time of its arm's frame ÷ the rest, compared with the best arm. It is meaningful if the arms' costs are constant.

A trial is a sequence of frames on another arm than the incumbent (the arm with most frames), including the frame that switches back.
Its worst frame is divided by the incumbent's worst frame on the same frames in a separate game, or by the best arm's if the incumbent is
too expensive to take part. Disturbances by the machine occur in both. The column worst frame is the 90th percentile of this ratio ÷
the same figure for the two games of the best arm, with and without the lane.
Conditions:
  quiet       no other load
  one-cpu     the game runs on one processor (taskset), so that the shadow lane rests
  neighbours  two other processes copy 64 MiB again and again
  bursts      four other processes compute for 1.2 s and rest for 2.5 s
  quota       the game's control group has the time of --cpu-quota processors; needs writable cgroups, for example as root
With --minutes a round starts only if it can end in time; the goals need at least five rounds. With --lane-only only the pairs of games
with and without the lane are played.
Needs Linux and Python 3.11. Exit code: 0 measured, 2 the measurement failed. `judge.py live` compares the result with the goals.
"""

import argparse
import collections
import contextlib
import csv
import itertools
import json
import math
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

from judging.common import or_dash, percent, table
from judging.live import MIN_ROUNDS, worst_of_trials

ROOT = pathlib.Path(__file__).resolve().parents[2]
CONDITIONS = ("quiet", "one-cpu", "neighbours", "bursts", "quota")
DEFAULT_CONDITIONS = "quiet,one-cpu,neighbours,bursts"
ARMS = ("BruteForce", "Grid", "SAP", "AxisSweep", "DBVT", "Tracy", "KDTree")
# Scenes with work other than the detection. Changing scenes are not used, because their regimes would pass too fast.
SCENES = "hurricane:2000,brownian:1000,rotating-gravity:3000,free-fall:5000"
BLOCK_FRAMES = 256
LONGEST_AGAIN_S = 4
STREAM = "a, b = bytearray(1 << 26), bytearray(1 << 26)\nwhile True:\n    a[:] = b"
BURST = """from time import sleep, time
while True:
    while time() % 3.7 < 1.2:
        pass
    sleep(3.7 - time() % 3.7)"""
OTHER_WORK = {"neighbours": (2, STREAM), "bursts": (4, BURST)}
# Two-sided 95 % quantiles of Student's t distribution for 1, 2, … degrees of freedom; for more, the normal one.
STUDENT = (12.71, 4.30, 3.18, 2.78, 2.57, 2.45, 2.36, 2.31, 2.26, 2.23)


class Failure(Exception):
    """The measurement cannot continue; the message says why."""


@contextlib.contextmanager
def other_work(condition):
    """Runs the condition's other processes until the block ends."""
    count, code = OTHER_WORK.get(condition, (0, ""))
    processes = [subprocess.Popen([sys.executable, "-c", code]) for _ in range(count)]
    try:
        yield
    finally:
        for process in processes:
            process.kill()
            process.wait()


@contextlib.contextmanager
def quota_group(condition, cores):
    """Creates the folder of a control group with the time of `cores` processors until the block ends; None without that condition."""
    if condition != "quota":
        yield None
        return
    unified = pathlib.Path("/sys/fs/cgroup/cgroup.controllers").exists()
    group = pathlib.Path("/sys/fs/cgroup" if unified else "/sys/fs/cgroup/cpu") / f"sweepstake-live-{os.getpid()}"
    name, value = ("cpu.max", f"{round(100_000 * cores)} 100000") if unified else ("cpu.cfs_quota_us", str(round(100_000 * cores)))
    try:
        group.mkdir()
        try:
            (group / name).write_text(value)
            yield group
        finally:
            group.rmdir()
    except OSError as error:
        raise Failure(f"no processor quota can be set here ({error}): run as root, or leave the condition quota out") from error


class Game:
    """Plays games of one scene. Each returns its frame times in ns and keeps the program's other output."""

    def __init__(self, options, scene, objects, condition="quiet"):
        self.options, self.scene, self.objects, self.condition = options, scene, objects, condition
        self.group = None  # the control group to play in
        self.decider = ["--embedded"]

    def prefix(self):
        if self.group is not None:
            return ["sh", "-c", f'echo $$ > {self.group}/cgroup.procs && exec "$@"', "sh"]
        return ["taskset", "-c", str(min(os.sched_getaffinity(0)))] if self.condition == "one-cpu" else []

    def play(self, *words, seconds=None):
        seconds = seconds or self.options.seconds
        with tempfile.TemporaryDirectory() as folder:
            command = [*self.prefix(), self.options.program, "run", *self.decider, "--scene", self.scene, "--objects", str(self.objects),
                       "--duration", f"{seconds}s", "--csv", folder, "--json", *words]
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            if done.returncode != 0:
                raise Failure(f"sweepstake run ended with {done.returncode}: {done.stderr.strip()[:800]}")
            self.summary = json.loads(done.stdout)
            self.read(pathlib.Path(folder))
        # Because of other load, a game of a few hundredths of a second may end without a frame. It is then played for twice the time.
        if not self.frame_ns and seconds < LONGEST_AGAIN_S:
            return self.play(*words, seconds=2 * seconds)
        return self.frame_ns

    def read(self, folder):
        with open(folder / "frames.csv", encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        self.arms = [row["arm"] for row in rows]
        self.frame_ns = [int(row["frame_time_ns"]) for row in rows]
        self.detection_ns = [int(row["detection_time_ns"]) for row in rows]
        self.rest_ns = [frame - detection for frame, detection in zip(self.frame_ns, self.detection_ns)]

    def fixed(self, arm, *words, seconds=None):
        return self.play("--mode", "manual", "--arm", arm, *words, seconds=seconds)

    def decided(self, *words):
        return self.play("--policy", self.options.policy, "--time-scale", str(self.options.time_scale), *words)


def over_same_frames(summary, games):
    """Summarizes each game over the frames that all games played."""
    count = min(map(len, games.values()))
    if count == 0:
        raise Failure("a game played no frame: increase --seconds")
    return {name: summary(frames[:count]) for name, frames in games.items()}


def means(games):
    return over_same_frames(statistics.fmean, games)


def at_equal_speed(frame_ns, rest_ns, other_rest_ns):
    """Returns the mean frame time at the machine speed at which the same frames' rest took other_rest_ns."""
    count = min(len(frame_ns), len(other_rest_ns))
    starts = range(0, count - BLOCK_FRAMES + 1, BLOCK_FRAMES) if count >= BLOCK_FRAMES else (0,)
    total = frames = 0
    for start in starts:
        block = slice(start, min(start + BLOCK_FRAMES, count))
        total += sum(frame_ns[block]) * sum(other_rest_ns[block]) / sum(rest_ns[block])
        frames += block.stop - block.start
    return total / frames


def median_frames(game, options):
    """Returns the median frame ÷ the median rest of every arm, from one short game each."""
    def play(arm):
        frame_ns = game.fixed(arm, "--shadow", "off", seconds=max(options.seconds / 10, 0.05))
        return [frame / rest for frame, rest in zip(frame_ns, game.rest_ns)]
    return over_same_frames(statistics.median, {arm: play(arm) for arm in ARMS})


def choice(arms, medians):
    """Returns the loss by the choice of these frames' arms."""
    return statistics.fmean(medians[arm] for arm in arms) / min(medians.values()) - 1


def trials(arms, incumbent):
    """Returns the trials as (first frame, end). A trial begins on an arm that has run less than the incumbent so far, and is at most twice
    as long as that; it includes the frame that switches back."""
    before = collections.Counter()
    frame = 0
    for is_own, stretch in itertools.groupby(arms, lambda arm: arm == incumbent):
        stretch = list(stretch)
        if not is_own and before[stretch[0]] < before[incumbent] and len(stretch) <= 2 * before[incumbent]:
            yield frame, min(frame + len(stretch) + 1, len(arms))
        before.update(stretch)
        frame += len(stretch)


def worst_ratio(stretch, frame_ns, rest_ns, other_frame_ns, other_rest_ns):
    """Returns the worst frame of the trial ÷ the other game's worst one, at equal machine speed."""
    frames = slice(*stretch)
    speed = statistics.median(other_rest_ns[frames]) / statistics.median(rest_ns[frames])
    return speed * max(frame_ns[frames]) / max(other_frame_ns[frames])


def interval(values):
    """Returns the mean and half the width of its 95 % interval (None for one value)."""
    if len(values) < 2:
        return values[0], None
    quantile = STUDENT[len(values) - 2] if len(values) - 2 < len(STUDENT) else 1.96
    return statistics.fmean(values), quantile * statistics.stdev(values) / math.sqrt(len(values))


def tail(frames):
    return sorted(frames)[min(len(frames) - 1, int(0.999 * len(frames)))]


class Cell:
    """A scene under a condition, and the measurements of its rounds."""

    def __init__(self, game, options):
        self.game, self.options = game, options
        self.medians = median_frames(game, options)
        best = min(self.medians.values())
        self.arms = sorted((arm for arm in ARMS if self.medians[arm] <= options.near * best), key=self.medians.get)
        self.regrets, self.raw_regrets, self.choices, self.lane_shares = [], [], [], []
        self.lane_means, self.lane_tails, self.best_arms = [], [], []
        self.trial_ratios, self.control_ratios = [], []

    def play_lane(self, arm, without):
        """Plays the game with the lane that forms a pair with the game `without` it."""
        with_lane = self.game.fixed(arm, "--shadow", "on")
        mean = means({"on": with_lane, "off": without})
        count = min(len(with_lane), len(without))
        self.lane_means.append(mean["on"] / mean["off"])
        self.lane_tails.append(tail(with_lane[:count]) / tail(without[:count]))
        self.best_arms.append(arm)

    def compare_trials(self, arms, games, best, with_lane):
        """Compares trials. `games` has frame and rest times by name; the control compares the best arm with its own game with the lane."""
        decided, without = games["AI Decides"], games[best]
        name = max(sorted(set(arms)), key=arms.count)
        incumbent = games.get(name, without)
        count = min(len(frame_ns) for frame_ns, _ in (decided, incumbent, without, with_lane))
        for stretch in trials(arms[:count], name):
            self.trial_ratios.append(worst_ratio(stretch, *decided, *incumbent))
            self.control_ratios.append(worst_ratio(stretch, *with_lane, *without))

    def play_all(self, number):
        names = ["AI Decides", *self.arms]
        turn = number % len(names)
        games, rest_ns = {}, {}
        for name in names[turn:] + names[:turn]:
            games[name] = self.game.decided() if name == "AI Decides" else self.game.fixed(name, "--shadow", "off")
            rest_ns[name] = self.game.rest_ns
            if name == "AI Decides":
                arms = self.game.arms
                self.choices.append(choice(self.game.arms, self.medians))
                self.lane_shares.append(self.game.summary["shadow"]["frame_share"])
        reference = over_same_frames(lambda frames: frames, rest_ns)["AI Decides"]
        mean = {name: at_equal_speed(games[name], rest_ns[name], reference) for name in games}
        best = min(self.arms, key=mean.get)
        self.regrets.append(mean["AI Decides"] / mean[best] - 1 + self.lane_shares[-1])
        raw = means(games)
        self.raw_regrets.append(raw["AI Decides"] / min(raw[arm] for arm in self.arms) - 1)
        self.play_lane(best, games[best])
        self.compare_trials(arms, {name: (games[name], rest_ns[name]) for name in games}, best, (self.game.frame_ns, self.game.rest_ns))

    def play_round(self, number):
        with quota_group(self.game.condition, self.options.cpu_quota) as self.game.group, other_work(self.game.condition):
            if self.options.lane_only:
                self.play_lane(self.arms[0], self.game.fixed(self.arms[0], "--shadow", "off"))
            else:
                self.play_all(number)
        latest = f"lane p99.9 {self.lane_tails[-1]:.2f}" + (f", regret {percent(self.regrets[-1])}" if self.regrets else "")
        return f"{self.game.condition} {self.game.scene} {self.game.objects}: {latest}"

    def row(self):
        regret, half_width = interval(self.regrets) if self.regrets else (None, None)
        raw_regret, raw_half_width = interval(self.raw_regrets) if self.regrets else (None, None)
        log_tail, log_half_width = interval([math.log(ratio) for ratio in self.lane_tails])
        return {"condition": self.game.condition, "scene": self.game.scene, "objects": self.game.objects,
                "rounds": len(self.lane_tails), "best_arm": max(set(self.best_arms), key=self.best_arms.count),
                "near_arms": self.arms, "regret": regret, "half_width": half_width, "regrets": self.regrets,
                "raw_regret": raw_regret, "raw_half_width": raw_half_width, "raw_regrets": self.raw_regrets,
                "lane_share": statistics.fmean(self.lane_shares) if self.lane_shares else None,
                "trials": len(self.trial_ratios),
                "trial_worst_ratio": worst_of_trials(self.trial_ratios, self.control_ratios) if self.trial_ratios else None,
                "trial_ratios": self.trial_ratios, "control_ratios": self.control_ratios,
                "choice": statistics.fmean(self.choices) if self.choices else None, "choices": self.choices,
                "lane_mean_ratio": statistics.median(self.lane_means), "lane_tail_ratio": math.exp(log_tail),
                "lane_tail_half_width": None if log_half_width is None else math.exp(log_tail) * math.expm1(log_half_width),
                "lane_tail_ratios": self.lane_tails}


def parse_scenes(words):
    for word in words.split(","):
        scene, _, objects = word.partition(":")
        if not scene or not objects.isdigit():
            raise Failure(f"'{word}' is not SCENE:OBJECTS, for example hurricane:2000")
        yield scene, int(objects)


def make_cells(options):
    cells = []
    for condition in options.conditions.split(","):
        if condition not in CONDITIONS:
            raise Failure(f"unknown condition '{condition}', must be one of {', '.join(CONDITIONS)}")
        cells += [Cell(Game(options, scene, objects, condition), options) for scene, objects in parse_scenes(options.scenes)]
    return cells


def run(options):
    begin_s = time.monotonic()
    cells = make_cells(options)
    rounds_begin_s = time.monotonic()
    for number in range(options.rounds):
        spent_s = time.monotonic() - rounds_begin_s
        round_s = spent_s / number if number else 0
        if options.minutes and number and time.monotonic() - begin_s + round_s > 60 * options.minutes:
            break
        for cell in cells:
            line = cell.play_round(number)
            print(f"round {number + 1} of {options.rounds}, {(time.monotonic() - begin_s) / 60:.1f} minutes: {line}",
                  file=sys.stderr, flush=True)
    return {"command": "live", "policy": options.policy, "seconds": options.seconds, "time_scale": options.time_scale,
            "rows": [cell.row() for cell in cells]}


def half(value):
    return or_dash(value, lambda width: f"{100 * width:.2f}%")


def text(document):
    rounds = min(row["rounds"] for row in document["rows"])
    few = "" if rounds >= MIN_ROUNDS else f"\nRounds played: {rounds}. The goals need at least {MIN_ROUNDS}.\n"
    return table(("condition", "scene", "objects", "rounds", "best arm", "regret", "± 95 %", "choice", "lane", "raw regret", "± 95 %",
                  "lane mean", "lane p99.9", "± 95 %", "trials", "worst frame"), [
        (row["condition"], row["scene"], str(row["objects"]), str(row["rounds"]), row["best_arm"], or_dash(row["regret"], percent),
         half(row["half_width"]), or_dash(row["choice"], percent), or_dash(row["lane_share"], percent),
         or_dash(row["raw_regret"], percent), half(row["raw_half_width"]), f"{row['lane_mean_ratio']:.3f}",
         f"{row['lane_tail_ratio']:.2f}",
         or_dash(row["lane_tail_half_width"], "{:.2f}".format), str(row["trials"]),
         or_dash(row["trial_worst_ratio"], "{:.2f}".format)) for row in document["rows"]]) + few


def add_game_options(parser, seconds, rounds=None, near=None):
    """Adds the options of all commands that play live games; `rounds` for those that compare, `near` for those that select arms."""
    if rounds is not None:
        parser.add_argument("--policy", default="default", help="the policy to measure (default: %(default)s)")
        parser.add_argument("--rounds", type=int, default=rounds, help="rounds of games (default: %(default)s)")
    if near is not None:
        parser.add_argument("--near", type=float, default=near, metavar="RATIO",
                            help="a fixed arm takes part if its median frame in a short game is at most this ratio × that of the best arm, "
                            "without other work (default: %(default)s)")
    parser.add_argument("--seconds", type=float, default=seconds, help="duration of a game (default: %(default)s)")
    parser.add_argument("--time-scale", type=float, default=20, help="time scale of the decider and the lane (default: %(default)s)")
    parser.add_argument("--json", action="store_true", help="one JSON document on stdout")


def check_game_options(parser, options, programs, option="--program"):
    if getattr(options, "rounds", 1) < 1 or not options.seconds > 0:
        parser.error("give at least one round of more than 0 seconds")
    for program in programs:
        if not os.access(program, os.X_OK):
            parser.error(f"no program at {program}: build preset release, or give {option}")


def parse(words):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="examples:\n"
        "  tests/bench/live.py\n"
        "  tests/bench/live.py --conditions one-cpu --scenes hurricane:2000 --rounds 3\n"
        "  tests/bench/live.py --conditions quiet,one-cpu,neighbours --json | tests/bench/judge.py live\n"
        "  tests/bench/live.py --lane-only --conditions quiet,neighbours --json | tests/bench/judge.py live\n"
        "  tests/bench/live.py --minutes 30 --conditions quiet,neighbours --scenes hurricane:2000,suite-g:10000\n"
        "All conditions with four scenes take about two hours; the machine should be otherwise idle.")
    parser.add_argument("--program", default=ROOT / "build/release/bin/sweepstake", metavar="PATH", help="the program sweepstake (default: %(default)s)")
    parser.add_argument("--scenes", default=SCENES, metavar="SCENE:OBJECTS,…", help="scenes and their object counts (default: %(default)s)")
    parser.add_argument("--conditions", default=DEFAULT_CONDITIONS, metavar="NAME,…", help="conditions to measure (default: %(default)s)")
    parser.add_argument("--minutes", type=float, default=0, help="stop after the last round that fits into this time (default: play all rounds)")
    parser.add_argument("--lane-only", action="store_true", help="play only the pairs of games with and without the lane")
    parser.add_argument("--cpu-quota", type=float, default=1, metavar="CORES", help="processors of the game in the condition quota (default: %(default)s)")
    add_game_options(parser, seconds=15, rounds=5, near=1.15)
    options = parser.parse_args(words)
    check_game_options(parser, options, [options.program])
    if not options.cpu_quota > 0:
        parser.error("give a --cpu-quota above 0")
    return options


def main(words):
    options = parse(words)
    try:
        document = run(options)
    except (Failure, OSError) as failure:
        print(f"live.py: {failure}", file=sys.stderr)
        return 2
    print(json.dumps(document, indent=2) if options.json else text(document), end="\n" if options.json else "")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
