#!/usr/bin/env python3
"""Runs the demo of deploy/quickstart.sh --stay: the page can be loaded, all scenes are learnt live, and the end leaves nothing behind.

    quickstart_test.py ROOT BIN
"""

import json
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time
import urllib.request

PATIENCE_S = 240
GAMES = 9
SCENES = 8  # seven scenes, one of them on two classes of machines


def until(what, condition):
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        if found := condition():
            return found
        time.sleep(0.1)
    raise SystemExit(f"quickstart_test.py: never: {what}")


def called(origin, method, fields=None):
    request = urllib.request.Request(f"{origin}/api/sweepstake.v1.{method}", json.dumps(fields or {}).encode(), {"X-Sweepstake": "1"})
    with urllib.request.urlopen(request, timeout=PATIENCE_S) as response:
        return json.load(response)


def children_of(pid):
    return [int(child) for child in pathlib.Path(f"/proc/{pid}/task/{pid}/children").read_text(encoding="utf-8").split()]


def is_learnt(scene):
    return any("windowCount" in arm for arm in scene.get("arms", []))


def play(script, bin_folder, data):
    demo = subprocess.Popen([script, "--stay", "--bin", bin_folder, "--data", data], stdout=subprocess.PIPE, text=True)
    try:
        line = next(line for line in demo.stdout if "dashboard" in line)
        origin = re.search(r"http://127\.0\.0\.1:\d+", line)[0]
        with urllib.request.urlopen(f"{origin}/", timeout=PATIENCE_S) as page:
            assert "text/html" in page.headers["Content-Type"], page.headers
        until("each game has a session", lambda: [
            session["state"] for session in called(origin, "SessionsService/ListSessions").get("sessions", [])
        ] == ["SESSION_STATE_CONNECTED"] * GAMES)
        until("each scene is learnt", lambda: sum(map(is_learnt, called(origin, "PosteriorsService/ListPosteriors").get("scenes", []))) == SCENES)
        builds = {session["build"] for session in called(origin, "SessionsService/ListSessions")["sessions"]}
        assert builds == {"1.4", "1.5"}, builds
        children = children_of(demo.pid)
        assert len(children) == 1 + GAMES, children
    finally:
        demo.send_signal(signal.SIGTERM)
    demo.stdout.read()
    assert demo.wait(PATIENCE_S) == 0, demo.returncode
    left = [pid for pid in children if pathlib.Path(f"/proc/{pid}").exists()]
    assert not left, f"still there: {left}"


def main():
    root, bin_folder = pathlib.Path(sys.argv[1]), sys.argv[2]
    script = root / "deploy/quickstart.sh"
    refused = subprocess.run([script, "--stayy"], capture_output=True, text=True, check=False)
    assert refused.returncode == 2 and "--stay" in refused.stderr, refused
    described = subprocess.run([script, "--help"], capture_output=True, text=True, check=True).stdout
    for option in ("--fresh", "--stay", "--bin", "--data"):
        assert option in described, described
    with tempfile.TemporaryDirectory() as folder:
        data = pathlib.Path(folder) / "data"
        play(script, bin_folder, data)
        games = (data / "games.log").read_text(encoding="utf-8")
        assert games.count("Posteriors learnt in") == GAMES, "each game says goodbye and reports\n" + games


if __name__ == "__main__":
    main()
