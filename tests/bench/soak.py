#!/usr/bin/env python3
"""Runs a daemon under load for a long time, and fails if it grows.

Starts `sweepstaked` like daemon_load.py and repeats typical events: `sweepstake-lab load` plays a round and says goodbye or, every
second time, is killed during it; a watcher connects and leaves; /metrics is scraped. Meanwhile it samples the daemon's resident
memory, descriptors and threads. It fits a straight line to each measure over the second half, when the tables have filled. If a
line rises by more than --max-growth of its mean, the daemon leaks. Needs Linux and Python 3.11.
Exit code: 0 flat, 1 grows, 2 the run failed.
"""

import argparse
import json
import os
import pathlib
import signal
import statistics
import subprocess
import sys
import tempfile
import time

from daemon_load import ROOT, Daemon, Failure, await_value

MEASURED = {"rss_kib": "resident memory, KiB", "descriptors": "descriptors", "threads": "threads"}
PLAYED = ("sweepstake_welcomed_streams_total", "sweepstake_ended_sessions_total", "sweepstake_applied_messages_total",
          "sweepstake_decisions_total", "sweepstake_stored_commits_total", "sweepstake_failed_commits_total")
BAR_WIDTH = 40


def sample(daemon, begin_s):
    process = pathlib.Path("/proc") / str(daemon.process.pid)
    return {"time_s": round(time.monotonic() - begin_s, 1), "rss_kib": daemon.rss_kib(),
            "descriptors": len(os.listdir(process / "fd")), "threads": len(os.listdir(process / "task"))}


def judge(samples, max_growth):
    """Returns for each measure over the second half: its mean, the rise of a fitted line, and whether it is flat."""
    half = samples[len(samples) // 2:]
    if len(half) < 3:
        raise Failure("too few samples: increase --minutes, or sample more often")
    times = [one["time_s"] for one in half]
    rows = {}
    for name in MEASURED:
        values = [one[name] for one in half]
        mean = statistics.fmean(values)
        growth = statistics.linear_regression(times, values).slope * (times[-1] - times[0]) / mean
        rows[name] = {"first": samples[0][name], "mean": mean, "last": half[-1][name], "peak": max(one[name] for one in samples),
                      "growth_ratio": growth, "flat": growth <= max_growth}
    return rows


class Round:
    """A generator and a watcher, which end together, with a goodbye or killed."""

    def __init__(self, daemon, options, number):
        self.ends_politely = number % 2 == 0
        duration_s = options.round_seconds if self.ends_politely else 10 * options.round_seconds
        self.end_s = time.monotonic() + options.round_seconds
        self.load = subprocess.Popen(daemon.load(options.streams, 4, 15, duration_s), stdout=subprocess.DEVNULL,
                                     stderr=subprocess.PIPE, text=True)
        self.watcher = subprocess.Popen(daemon.sweepstake("watch", "--project", "load"), stdout=subprocess.DEVNULL,
                                        stderr=subprocess.DEVNULL)

    def over(self):
        if self.load.poll() not in (None, 0):
            raise Failure(f"sweepstake-lab load ended with {self.load.returncode}: {self.load.stderr.read().strip()}")
        return self.load.returncode == 0 if self.ends_politely else time.monotonic() > self.end_s

    def end(self):
        self.watcher.send_signal(signal.SIGINT)
        self.load.kill()
        self.watcher.wait()
        self.load.communicate()


class Progress:
    """A progress bar, on a terminal only."""

    def __init__(self, total_s):
        self.total_s = total_s

    def show(self, latest):
        if sys.stderr.isatty():
            done = min(latest["time_s"] / self.total_s, 1)
            bar = ("#" * int(done * BAR_WIDTH)).ljust(BAR_WIDTH)
            print(f"\r[{bar}] {done:4.0%}  {latest['rss_kib'] / 1024:.1f} MiB, {latest['descriptors']} descriptors ", end="",
                  file=sys.stderr, flush=True)

    def end(self):
        if sys.stderr.isatty():
            print(file=sys.stderr)


def soak(daemon, options):
    total_s = 60 * options.minutes
    begin_s = time.monotonic()
    progress, samples, rounds, current = Progress(total_s), [], 0, None
    try:
        while time.monotonic() - begin_s < total_s:
            if current is None:
                current, rounds = Round(daemon, options, rounds), rounds + 1
            time.sleep(options.sample_seconds)
            daemon.metric("sweepstake_open_streams")  # as Prometheus does
            samples.append(sample(daemon, begin_s))
            progress.show(samples[-1])
            if current.over():
                current.end()
                current = None
    finally:
        progress.end()
        if current is not None:
            current.end()
    await_value("the end of all streams", lambda: daemon.metric("sweepstake_open_streams") == 0)
    return {"command": "soak", "minutes": options.minutes, "streams": options.streams, "rounds": rounds,
            "measures": judge(samples, options.max_growth), "played": {name: daemon.metric(name) for name in PLAYED},
            "samples": samples}


def text(document):
    rows = [f"{document['rounds']} rounds of {document['streams']} streams in {document['minutes']:g} minutes",
            f"{'':24}{'first':>10}{'mean':>10}{'last':>10}{'peak':>10}{'growth':>10}"]
    for name, row in document["measures"].items():
        rows.append(f"{MEASURED[name]:24}{row['first']:10}{row['mean']:10.0f}{row['last']:10}{row['peak']:10}"
                    f"{row['growth_ratio']:10.1%}  {'flat' if row['flat'] else 'GROWS'}")
    rows += [f"{name:44}{value:12.0f}" for name, value in document["played"].items()]
    return "\n".join(rows)


def parse(words):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="examples:\n  tests/bench/soak.py --minutes 480\n  tests/bench/soak.py --minutes 5 --streams 200 --json > soak.json")
    parser.add_argument("--programs", type=pathlib.Path, default=ROOT / "build/release/bin", metavar="FOLDER",
                        help="folder with sweepstaked and sweepstake (default: build/release/bin)")
    parser.add_argument("--minutes", type=float, default=60, help="duration of the run (default: %(default)s)")
    parser.add_argument("--streams", type=int, default=500, help="concurrent games (default: %(default)s)")
    parser.add_argument("--round-seconds", type=int, default=15, help="duration of each round of games (default: %(default)s)")
    parser.add_argument("--sample-seconds", type=float, default=2, help="interval of samples (default: %(default)s)")
    parser.add_argument("--max-growth", type=float, default=0.05, metavar="RATIO",
                        help="allowed growth of a measure in the second half (default: %(default)s)")
    parser.add_argument("--json", action="store_true", help="one JSON document on stdout, with the samples")
    return parser.parse_args(words)


def main(words):
    options = parse(words)
    try:
        with tempfile.TemporaryDirectory(prefix="sweepstake-soak-") as data:
            # Lost sessions stay in memory for ten minutes, or until this limit is reached.
            daemon = Daemon(options.programs, data, max_sessions=2 * options.streams)
            try:
                document = soak(daemon, options)
            finally:
                daemon.stop()
    except (Failure, OSError, subprocess.SubprocessError) as failure:
        print(failure, file=sys.stderr)
        return 2
    print(json.dumps(document, indent=2) if options.json else text(document))
    return 0 if all(row["flat"] for row in document["measures"].values()) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
