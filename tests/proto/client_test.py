#!/usr/bin/env python3
"""Runs proto/client.py against a daemon that needs a token and is killed in between: the session resumes, and the daemon learns the costs.

    client_test.py ROOT BIN

Run it with the system's Python. Exit status: 0 passed, 1 failed, 77 skipped because protoc, grpcio or protobuf is missing.
"""

import importlib.util
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import urllib.request

ROOT, BIN = (pathlib.Path(folder).resolve() for folder in sys.argv[1:3])
PATIENCE_S = 120


def missing():
    found = {name: importlib.util.find_spec(name) for name in ("grpc", "google")} | {"protoc": shutil.which("protoc")}
    return [name for name, path in found.items() if not path]


class Daemon:
    def __init__(self, folder, listen):
        ports = folder / "ports"
        ports.unlink(missing_ok=True)
        self.process = subprocess.Popen([BIN / "sweepstaked", "--data", folder / "data", "--listen", listen, "--http", "127.0.0.1:0",
                                         "--port-file", ports, "--max-time-scale", "100"], stderr=subprocess.DEVNULL)
        end = time.monotonic() + PATIENCE_S
        while not ports.exists():
            assert time.monotonic() < end and self.process.poll() is None, "the daemon has not started"
            time.sleep(0.05)
        self.port, self.http = ports.read_text(encoding="utf-8").split()

    def get(self, path, body=None, token=""):
        headers = {"X-Sweepstake": "1", "Authorization": f"Bearer {token}"}
        with urllib.request.urlopen(urllib.request.Request(f"http://127.0.0.1:{self.http}{path}", body, headers), timeout=PATIENCE_S) as response:
            return response.read().decode()

    def stop(self, number=signal.SIGTERM):
        self.process.send_signal(number)
        self.process.wait()


def await_line(client, pattern):
    """Returns the first line that matches. The client ends after PATIENCE_S, and with it its output."""
    for line in client.stdout:
        if match := re.search(pattern, line):
            return match
    raise AssertionError(f"the client has ended without a line like {pattern!r}")


def tokens(folder):
    for name, role in (("game", "ingest"), ("reader", "watch")):
        subprocess.run([BIN / "sweepstaked", "token", "create", name, "--role", role, "--out", folder / name, "--data", folder / "data"],
                       check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        yield (folder / name).read_text(encoding="utf-8").strip()


def play(folder, daemon, token):
    """Plays until the daemon has commanded a switch, has been killed, and is there again. Returns the daemon that runs then."""
    subprocess.run(["protoc", "-I", ROOT / "proto", f"--python_out={folder}", ROOT / "proto/sweepstake/v1/telemetry.proto"], check=True)
    command = [sys.executable, ROOT / "proto/client.py", f"127.0.0.1:{daemon.port}", "--seconds", str(PATIENCE_S), "--time-scale", "20", "--token"]
    environment = os.environ | {"PYTHONPATH": str(folder)}
    refused = subprocess.run([*command, "wrong"], env=environment, capture_output=True, text=True, check=False)
    assert refused.returncode == 1 and "UNAUTHENTICATED" in refused.stderr, refused
    client = subprocess.Popen([*command, token], env=environment, stdout=subprocess.PIPE, text=True)
    try:
        session = await_line(client, r"session (\w+), resumed: False")[1]
        await_line(client, "switched to KDTree")
        daemon.stop(signal.SIGKILL)
        await_line(client, "connection lost")
        daemon = Daemon(folder, f"127.0.0.1:{daemon.port}")
        assert await_line(client, r"session (\w+), resumed: True")[1] == session
        end = time.monotonic() + PATIENCE_S
        while "sweepstake_stored_commits_total 0\n" in daemon.get("/metrics"):
            assert time.monotonic() < end, "nothing is stored after the restart"
            time.sleep(0.1)
        client.send_signal(signal.SIGINT)
        assert client.wait(PATIENCE_S) == 0
        return daemon
    finally:
        client.kill()
        client.wait()


def check(daemon, token):
    metrics = daemon.get("/metrics")
    value = {name: float(text) for name, text in re.findall(r"^(\S+) (\S+)$", metrics, re.MULTILINE)}
    assert value["sweepstake_resumed_sessions_total"] == value["sweepstake_ended_sessions_total"] == 1, metrics
    wrong = re.compile(r"sweepstake_(invalid|malformed|unknown)_messages_total|sweepstake_rejected_(frames|shadow_samples)_total")
    assert not [name for name, number in value.items() if wrong.match(name) and number], metrics
    scene = json.loads(daemon.get("/api/sweepstake.v1.PosteriorsService/GetPosterior",
                                  json.dumps({"project": "example", "scene": "simulated", "machineClass": "example", "rewardVersion": 3}).encode(), token))["scene"]
    ratios = {arm["arm"]: arm["costRatio"]["median"] for arm in scene["arms"]}
    assert scene["leaderArm"] == "KDTree" and abs(ratios["Grid"] - 3) < 0.3 and abs(ratios["SAP"] - 2) < 0.2, scene


def main():
    if names := missing():
        print(f"LEFT OUT: the client in Python. Missing: {', '.join(names)}. Install protobuf-compiler, python3-grpcio and python3-protobuf")
        return 77
    with tempfile.TemporaryDirectory(prefix="sweepstake-") as name:
        folder = pathlib.Path(name)
        (folder / "data").mkdir(mode=0o700)
        game, reader = tokens(folder)
        daemon = Daemon(folder, "127.0.0.1:0")
        try:
            daemon = play(folder, daemon, game)
            check(daemon, reader)
        finally:
            daemon.stop()
    return 0


if __name__ == "__main__":
    sys.exit(main())
