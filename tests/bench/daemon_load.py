#!/usr/bin/env python3
"""Measures the capacity of a daemon: many streams at two rates, a restart, watchers, files of priors, and a scene with many sources.

Starts `sweepstaked` from the folder of programs, on a free loopback port with its own data directory, and loads it with
`sweepstake-lab load`. Prints a table with the goals of data/goals.toml, or one JSON document for `judge.py daemon`. The generator
runs on the same machine and uses a part of its processors. If tick_lateness is large, or if there are fewer batches than
streams × rate, the machine is too small for the load. server_cpu is the time of the daemon, generator_cpu that of the generator.
Needs Linux, Python 3.11 and openssl. Exit code: 0 measured, 2 the measurement failed.
"""

import argparse
import json
import os
import pathlib
import random
import selectors
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import urllib.parse
import urllib.request

from judging import daemon as judging
from judging.common import read_goals

ROOT = pathlib.Path(__file__).resolve().parents[2]
GOALS = ROOT / "tests/bench/data/goals.toml"
PATIENCE_S = 60
ARMS = ("AxisSweep", "BruteForce", "DBVT", "Grid", "KDTree", "SAP", "Tracy")


class Failure(Exception):
    pass


class Daemon:
    """A daemon process; its data is kept over a restart."""

    def __init__(self, programs, data, with_tls=False, max_sessions=20_000, server_options=()):
        self.programs, self.data, self.address, self.process = programs, pathlib.Path(data), "127.0.0.1:0", None
        self.max_sessions = max_sessions
        self.server_options, self.client_options = self.make_certificate() if with_tls else ([], [])
        self.server_options = [*self.server_options, *server_options]
        self.start()

    def make_certificate(self):
        """Creates a certificate; returns the options of the daemon and of its clients."""
        certificate, key = self.data / "cert.pem", self.data / "key.pem"
        subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-days",
                        "2", "-subj", "/CN=load", "-addext", "subjectAltName=IP:127.0.0.1", "-keyout", key, "-out", certificate],
                       check=True, capture_output=True)
        return ["--tls-cert", certificate, "--tls-key", key], ["--tls-ca", certificate]

    def start(self):
        port_file = self.data / "port"
        port_file.unlink(missing_ok=True)
        self.process = subprocess.Popen(
            [self.programs / "sweepstaked", "--listen", self.address, "--data", self.data / "priors", "--log-level", "error",
             "--port-file", port_file, "--http", "127.0.0.1:0", "--max-sessions", str(self.max_sessions), "--max-watchers", "600",
             *self.server_options])
        try:
            ports = await_value("the daemon's ports", lambda: port_file.exists() and port_file.read_text("ascii").split())
        except Failure:
            self.stop()
            raise
        self.address, self.http_address = (f"127.0.0.1:{port}" for port in ports)

    def stop(self):
        self.process.send_signal(signal.SIGTERM)
        try:
            self.process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise Failure("the daemon did not end") from None

    def metric(self, name):
        with urllib.request.urlopen(f"http://{self.http_address}/metrics", timeout=PATIENCE_S) as page:
            lines = page.read().decode().splitlines()
        return next(float(line.split()[1]) for line in lines if line.startswith(name + " "))

    def rss_kib(self):
        with open(f"/proc/{self.process.pid}/status", encoding="ascii") as status:
            return next(int(line.split()[1]) for line in status if line.startswith("VmRSS:"))

    def cpu_s(self):
        with open(f"/proc/{self.process.pid}/stat", encoding="utf-8") as stat:
            fields = stat.read().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def sweepstake(self, *arguments):
        program = "sweepstake-lab" if arguments[0] == "load" else "sweepstake"
        return [self.programs / program, *map(str, arguments), "--daemon", self.address, *self.client_options]

    def load(self, streams, rate, frames, duration_s, **options):
        words = [word for name, value in options.items() for word in ("--" + name.replace("_", "-"), value)]
        return self.sweepstake("load", "--streams", streams, "--rate", rate, "--frames-per-batch", frames, "--duration",
                               f"{duration_s}s", "--server-pid", self.process.pid, "--json", *words)


def await_value(what, get):
    deadline = time.monotonic() + PATIENCE_S
    while time.monotonic() < deadline:
        if value := get():
            return value
        time.sleep(0.05)
    raise Failure(f"{what} did not appear within {PATIENCE_S} s")


def run(command):
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise Failure(f"{' '.join(map(str, command))} ended with {done.returncode}: {done.stderr.strip()}")
    return done.stdout


def run_json(command):
    return json.loads(run(command))


def seconds_of(command):
    start = time.monotonic()
    run(command)
    return time.monotonic() - start


def add_cost(figures):
    """Adds the daemon's processor time per message on its disk."""
    messages = figures["acknowledged_per_s"] * figures["measured_s"]
    if messages == 0:
        raise Failure("nothing was acknowledged: increase --seconds")
    figures["server_cores"] = figures["server_cpu_s"] / figures["measured_s"]
    figures["server_cpu_us_per_message"] = 1e6 * figures["server_cpu_s"] / messages
    return figures


def measure_rate(daemon, streams, rate, frames, options):
    return add_cost(run_json(daemon.load(streams, rate, frames, options.seconds)))


def measure_idle(daemon, streams, options):
    """Measures the resident memory of streams that send only a Hello."""
    before_kib = daemon.rss_kib()
    with subprocess.Popen(daemon.load(streams, 0.01, 1, 1000), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as load:
        try:
            await_value("a stream", lambda: daemon.metric("sweepstake_sessions") == streams)
            time.sleep(options.seconds)
            after_kib = daemon.rss_kib()
        finally:
            load.send_signal(signal.SIGINT)
    return {"streams": streams, "rss_kib_per_stream": (after_kib - before_kib) / streams}


def measure_restart(daemon, streams, options):
    """Measures the time from the first lost stream until all are back, while the daemon is restarted."""
    duration_s = options.seconds + 15 + streams // 200
    with subprocess.Popen(daemon.load(streams, 1, 60, duration_s), stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                          text=True) as load:
        time.sleep(max(options.seconds, streams / 1000))
        daemon.stop()
        daemon.start()
        output = load.communicate()[0]
    if load.returncode != 0:
        raise Failure(f"sweepstake-lab load ended with {load.returncode}")
    figures = json.loads(output)
    kept = ("streams", "rejected", "finished", "reconnect_s", "hello_latency_ms_p99")
    return {name: figures[name] for name in kept if name in figures}


def measure_watched(daemon, streams, options):
    """Measures the same load without watchers, then with them, and the ratio by which the throughput falls."""
    alone = measure_rate(daemon, streams, 1, 60, options)
    watched = measure_watchers(daemon, streams, 100, options)
    watched["ingest_loss_ratio"] = 1 - watched["acknowledged_per_s"] / alone["acknowledged_per_s"]
    watched["server_cpu_gain_ratio"] = watched["server_cpu_us_per_message"] / alone["server_cpu_us_per_message"] - 1
    return watched


def measure_watchers(daemon, streams, watchers, options):
    def all_watch():
        return daemon.metric("sweepstake_open_watchers") == watchers

    watching = [subprocess.Popen(daemon.sweepstake("watch", "--project", "load", "--scene", f"scene {i % 10}"),
                                 stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) for i in range(watchers)]
    try:
        await_value("a watcher", all_watch)
        figures = measure_rate(daemon, streams, 1, 60, options)
        if not all_watch():
            raise Failure("a watcher has ended during the measurement")
    finally:
        for watcher in watching:
            watcher.send_signal(signal.SIGINT)
        for watcher in watching:
            watcher.wait()
    return {"watchers": watchers, **figures}


class Browsers(threading.Thread):
    """Connections that each watch one scene (the scenes in turn) by server-sent events, and read everything."""

    PATH = "/events/sweepstake.v1.PosteriorsService/WatchPosteriors?request="

    def __init__(self, daemon, count, scenes):
        super().__init__(daemon=True)
        self.selector, self.sockets = selectors.DefaultSelector(), []
        self.event_count, self.is_ending = 0, False
        host, port = daemon.http_address.split(":")
        for i in range(count):
            request = json.dumps({"project": "load", "scene": f"scene {i % scenes}"})
            connection = socket.create_connection((host, int(port)), PATIENCE_S)
            connection.sendall(f"GET {self.PATH}{urllib.parse.quote(request)} HTTP/1.1\r\nHost: localhost\r\n\r\n".encode())
            self.sockets.append(connection)
            self.selector.register(connection, selectors.EVENT_READ)

    def run(self):
        while not self.is_ending:
            for key, _ in self.selector.select(0.1):
                read = key.fileobj.recv(1 << 18)
                if not read:
                    self.selector.unregister(key.fileobj)
                self.event_count += read.count(b"\ndata: {\"posterior\"")

    def end(self):
        self.is_ending = True
        self.join()
        for connection in self.sockets:
            connection.close()


def measure_midst(daemon, scenes, options, count):
    """Measures the daemon's time and counts events per second during a load of one game for each scene."""
    with subprocess.Popen(daemon.load(scenes, 4, 15, 10_000, scenes=scenes), stdout=subprocess.DEVNULL,
                          stderr=subprocess.DEVNULL) as load:
        try:
            await_value("a game", lambda: daemon.metric("sweepstake_open_streams") == scenes)
            time.sleep(3)  # until every game has learnt something
            start, cpu_s, before = time.monotonic(), daemon.cpu_s(), count()
            time.sleep(options.seconds)
            elapsed_s, cpu_s, after = time.monotonic() - start, daemon.cpu_s() - cpu_s, count()
        finally:
            load.send_signal(signal.SIGINT)
    return cpu_s / elapsed_s, [(now - then) / elapsed_s for then, now in zip(before, after)]


def measure_browsers(daemon, watchers, scenes, options):
    """Measures the daemon's cost of browsers that watch scenes with four changes of posteriors per second, without the games' cost."""
    alone, _ = measure_midst(daemon, scenes, options, lambda: [])
    browsers = Browsers(daemon, watchers, scenes)
    browsers.start()
    try:
        await_value("a browser", lambda: daemon.metric("sweepstake_http_watchers") == watchers)
        watched, (told, encoded) = measure_midst(
            daemon, scenes, options, lambda: [browsers.event_count, daemon.metric("sweepstake_http_encoded_events_total")])
        if not browsers.is_alive() or daemon.metric("sweepstake_http_watchers") != watchers:
            raise Failure("a browser has ended during the measurement")
    finally:
        browsers.end()
    return {"browsers": watchers, "scenes": scenes, "posteriors_per_s": told / watchers * scenes, "told_per_s": told,
            "encoded_per_s": encoded, "skips": daemon.metric("sweepstake_http_skips_total"), "server_cores_without": alone,
            "server_cores": watched, "browser_cores": watched - alone}


def import_records(daemon, records):
    """Imports a file of priors into a daemon. Returns the time until they were in quarantine, and until they were promoted."""
    path = daemon.data / "records.json"
    path.write_text(json.dumps({"format": "sweepstake-priors", "version": 1, "records": records}, separators=(",", ":")), encoding="utf-8")
    return (seconds_of(daemon.sweepstake("priors", "import", "--in", path)),
            seconds_of(daemon.sweepstake("priors", "promote", "--project", "load", "--yes")))


def measure_files(daemon, scenes, builds):
    """Measures the commands that write and read the evidence of these scenes and builds, and the size of the shipped files.

    Each scene and build has ten records, like a session: seven arms that the lane measured, three of them live too.
    """
    generator = random.Random(1)
    records = [{"project": "load", "scene": f"level {scene}", "arm": ARMS[place % 7], "backend_version": 1, "reward_version": 3,
                "measured_by": "lane" if place < 7 else "", "machine_class": "desktop", "build": f"1.{build}",
                "source_id": f"{scene * builds + build:032x}", "source_sequence": 1,
                "alpha_increment": generator.uniform(1, 10_000), "beta_increment": generator.uniform(1, 10_000),
                "window_count": 20} for scene in range(scenes) for build in range(builds) for place in range(10)]
    import_s, promote_s = import_records(daemon, records)
    sums = daemon.data / "sums.json"
    export_s = seconds_of(daemon.sweepstake("priors", "export", "--sums", "--out", sums))
    whole_s = seconds_of(daemon.sweepstake("priors", "export", "--out", daemon.data / "whole.json"))
    # A game that ships with this file reads and checks the whole file at its start, but uses the priors of one scene
    # only.
    read_s = seconds_of([daemon.programs / "sweepstake", "priors", "arm", "--in", sums, "--project", "load", "--scene", "level 0",
                         "--machine-class", "desktop"])
    return {"scenes": scenes, "builds": builds, "records": len(records), "import_s": import_s, "promote_s": promote_s, "export_s": export_s,
            "whole_export_s": whole_s, "read_s": read_s, "sums_bytes": sums.stat().st_size}


def measure_hello(daemon, sources, options):
    """Measures the welcome messages for a scene with this number of sources."""
    records = [{"project": "load", "scene": "scene 0", "arm": "arm 0", "backend_version": 1, "reward_version": 3,
                "source_id": f"{number:032x}", "source_sequence": 1, "alpha_increment": 1, "beta_increment": 1,
                "window_count": 2} for number in range(sources)]
    import_records(daemon, records)
    figures = run_json(daemon.load(2000, 0.1, 60, options.seconds, scenes=1))  # 200 Hellos a second
    check_taught(daemon, sources)
    return {"sources": sources, **{name: figures[name] for name in figures if name.startswith("hello")}}


def check_taught(daemon, sources):
    """Checks that a game's evidence is added to the imported scene, so that games start from the imported sources."""
    run_json(daemon.load(1, 10, 60, 3, scenes=1, bail_out_share=1))  # a bail-out is evidence even without other measurements
    listed = run_json(daemon.sweepstake("priors", "list", "--json"))
    taught = [scene["sources"] for scene in listed["scenes"]]
    if len(taught) != 1 or taught[0] <= sources:
        raise Failure(f"the games did not start from the imported sources, but from another scene: {taught}")


def plan(options):
    """Returns name, title, measurement and the daemon's options of each load."""
    streams = options.streams
    scenes, browsers, levels = max(streams // 40, 1), max(streams // 10, 1), max(options.sources // 100, 1)
    # The policy `paper` learns from every window, so each game's posterior changes at each tick of the updates to
    # watchers.
    quick = {"server_options": ["--decision-policy", "paper", "--decision-interval-ms", "200", "--decision-settling-ms", "0",
                                "--no-decision-explore"]}
    return [
        ("full", f"{streams} streams × 1 Hz × 60 frames", lambda daemon: measure_rate(daemon, streams, 1, 60, options), {}),
        ("half", f"{streams // 2} streams × 1 Hz × 60 frames", lambda daemon: measure_rate(daemon, streams // 2, 1, 60, options), {}),
        ("often", f"{streams // 5} streams × 4 Hz × 15 frames", lambda daemon: measure_rate(daemon, streams // 5, 4, 15, options), {}),
        ("idle", f"{streams} idle streams", lambda daemon: measure_idle(daemon, streams, options), {}),
        ("idle-tls", f"{streams} idle streams with TLS", lambda daemon: measure_idle(daemon, streams, options), {"with_tls": True}),
        ("restart", f"a restart under {streams} streams", lambda daemon: measure_restart(daemon, streams, options), {}),
        ("watched", f"100 watchers of {streams // 2} streams", lambda daemon: measure_watched(daemon, streams // 2, options), {}),
        ("browsers", f"{browsers} browsers that watch {scenes} scenes at 4 Hz",
         lambda daemon: measure_browsers(daemon, browsers, scenes, options), quick),
        ("files", f"files of {levels} scenes × 20 builds", lambda daemon: measure_files(daemon, levels, 20), {}),
        ("hello", f"Hellos of a scene with {options.sources} sources", lambda daemon: measure_hello(daemon, options.sources, options), {}),
    ]


def measure(options):
    loads = []
    wanted = [row for row in plan(options) if not options.only or row[0] in options.only]
    for number, (name, title, run, daemon_options) in enumerate(wanted, 1):
        print(f"{number} of {len(wanted)}: {title}", file=sys.stderr)
        with tempfile.TemporaryDirectory(prefix="sweepstake-load-") as data:
            daemon = Daemon(options.programs, data, **daemon_options)
            try:
                loads.append({"name": name, "title": title, "figures": run(daemon)})
            finally:
                daemon.stop()
    return {"command": "daemon_load", "streams": options.streams, "sources": options.sources, "loads": loads}


def parse(words):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="examples:\n  tests/bench/daemon_load.py\n  tests/bench/daemon_load.py --streams 1000 --only restart --json\n"
        "  tests/bench/daemon_load.py --json | tests/bench/judge.py daemon")
    parser.add_argument("--programs", type=pathlib.Path, default=ROOT / "build/release/bin", metavar="FOLDER",
                        help="folder with sweepstaked and sweepstake (default: build/release/bin)")
    parser.add_argument("--streams", type=int, default=10_000, help="concurrent games (default: %(default)s)")
    parser.add_argument("--sources", type=int, default=100_000,
                        help="sources of the scene; 1 measures connecting only (default: %(default)s)")
    parser.add_argument("--seconds", type=int, default=30, help="duration of each load (default: %(default)s)")
    parser.add_argument("--only", action="append", choices=[row[0] for row in plan(argparse.Namespace(streams=0, sources=0))],
                        help="only this load; may be repeated")
    parser.add_argument("--json", action="store_true", help="one JSON document on stdout")
    return parser.parse_args(words)


def main(words):
    options = parse(words)
    for program in ("sweepstaked", "sweepstake", "sweepstake-lab"):
        if not (options.programs / program).exists():
            print(f"No program {options.programs / program}: build preset release, or name the folder with --programs",
                  file=sys.stderr)
            return 2
    try:
        document = measure(options)
    except (Failure, OSError, subprocess.SubprocessError) as failure:
        print(failure, file=sys.stderr)
        return 2
    if options.json:
        print(json.dumps(document, indent=2, ensure_ascii=False))
    else:
        print(judging.daemon_text(document, judging.judge(document, read_goals(GOALS)["daemon"])), end="")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
