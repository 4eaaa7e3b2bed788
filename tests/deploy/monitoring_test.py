#!/usr/bin/env python3
"""Tests deploy/monitoring with promtool and a daemon: the alert rules on recorded faults, and that the rules and the dashboard of Grafana
use only metrics that a daemon with TLS and a game exposes. The dashboard has to show each of these metrics, and the runbook each alert.

    monitoring_test.py ROOT BIN

Exit status: 0 passed, 1 failed, 77 skipped because promtool (Prometheus) is missing.
"""

import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time
import urllib.request

ROOT, BIN = (pathlib.Path(folder).resolve() for folder in sys.argv[1:3])
MONITORING = ROOT / "deploy/monitoring"
CASES = (ROOT / "tests/deploy/alerts.test.yml").read_text(encoding="utf-8")
RULES = (MONITORING / "alerts.yml").read_text(encoding="utf-8")
ALERTS = re.findall(r"- alert: (\w+)", RULES)
PATIENCE_S = 120
METRIC = re.compile(r"\b(?:sweepstake|process)_[a-z_]+\b")
SUFFIX = re.compile(r"_(?:bucket|sum|count)$")


def promtool(*arguments):
    result = subprocess.run(["promtool", *arguments], capture_output=True, text=True, check=False)
    if result.returncode != 0:
        raise SystemExit(f"promtool {' '.join(map(str, arguments))}:\n{result.stdout}{result.stderr}")


def check_rules(folder):
    promtool("check", "config", MONITORING / "prometheus.yml")
    cases = folder / "cases.yml"
    cases.write_text(CASES.replace("[RULES]", f"[{MONITORING}/alerts.yml]"), encoding="utf-8")
    promtool("test", "rules", cases)
    fired = re.findall(r"- alertname: (\w+)", CASES)
    silent = re.findall(r"- \{ alertname: (\w+), .*exp_alerts: \[\]", CASES)
    assert sorted(fired) == sorted(silent) == sorted(ALERTS), "each alert needs a case in which it fires and one in which it does not"


def check_runbook():
    headings = re.findall(r"^### (\w+)$", (ROOT / "deploy/RUNBOOK.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert headings == ALERTS, f"deploy/RUNBOOK.md has a section per alert, in the order of the rules: {set(headings) ^ set(ALERTS)}"
    links = re.findall(r"runbook: deploy/RUNBOOK\.md#(\w+)", RULES)
    assert links == [alert.lower() for alert in ALERTS], "each alert links its own section of the runbook"


def metrics(url):
    with urllib.request.urlopen(url, timeout=PATIENCE_S) as response:
        return set(re.findall(r"^# TYPE (\w+)", response.read().decode(), re.MULTILINE))


def exposed(folder):
    """Returns the names of all metrics of a daemon with TLS, to which a game is connected."""
    subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-days", "2", "-subj",
                    "/CN=localhost", "-addext", "subjectAltName=DNS:localhost,IP:127.0.0.1", "-keyout", "key.pem", "-out", "cert.pem"],
                   cwd=folder, capture_output=True, check=True)
    certificate, ports = folder / "cert.pem", folder / "ports"
    daemon = subprocess.Popen([BIN / "sweepstaked", "--data", folder / "data", "--listen", "127.0.0.1:0", "--http", "127.0.0.1:0", "--port-file", ports,
                               "--tls-cert", certificate, "--tls-key", folder / "key.pem", "--metrics-scenes", "10"], stderr=subprocess.DEVNULL)
    game = None
    try:
        end = time.monotonic() + PATIENCE_S
        while len(lines := ports.read_text(encoding="utf-8").split() if ports.exists() else []) < 2:
            assert time.monotonic() < end and daemon.poll() is None, "the daemon has not started"
            time.sleep(0.05)
        game = subprocess.Popen([BIN / "sweepstake", "run", "--scene", "storms", "--objects", "100", "--fps", "60", "--duration", "1h", "--daemon",
                                 f"127.0.0.1:{lines[0]}", "--tls-ca", certificate], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        # The series of a scene appear when its first saving and its first loss are known.
        while "sweepstake_scene_frame_saving_seconds" not in (names := metrics(f"http://127.0.0.1:{lines[1]}/metrics")) or \
                "sweepstake_scene_frame_loss_seconds" not in names:
            assert time.monotonic() < end and game.poll() is None, "the game has not been measured"
            time.sleep(0.2)
        return names
    finally:
        for process in filter(None, (game, daemon)):
            process.terminate()
            process.wait()


def used(text):
    return {SUFFIX.sub("", name) for name in METRIC.findall(text)}


def check_dashboard(folder, names):
    dashboard = json.loads((MONITORING / "dashboard.json").read_text(encoding="utf-8"))
    expressions = [target["expr"] for panel in dashboard["panels"] for target in panel.get("targets", [])]
    rules = folder / "expressions.yml"
    plain = [text.replace("$__rate_interval", "5m").replace("$instance", ".*") for text in expressions]
    groups = {"groups": [{"name": "dashboard", "rules": [{"record": f"panel:{i}", "expr": text} for i, text in enumerate(plain)]}]}
    rules.write_text(json.dumps(groups), encoding="utf-8")
    promtool("check", "rules", rules)
    shown = used("\n".join(expressions))
    assert shown == names, f"not shown: {sorted(names - shown)}; not exposed: {sorted(shown - names)}"
    identifiers = [panel["id"] for panel in dashboard["panels"]]
    assert len(set(identifiers)) == len(identifiers)


def main():
    if not shutil.which("promtool"):
        print("LEFT OUT: the alert rules and the dashboard of Grafana. promtool is missing: install the package prometheus")
        return 77
    with tempfile.TemporaryDirectory(prefix="sweepstake-") as name:
        folder = pathlib.Path(name)
        check_runbook()
        check_rules(folder)
        names = exposed(folder)
        unknown = used(RULES) - names
        assert not unknown, f"the rules use metrics that the daemon does not expose: {sorted(unknown)}"
        check_dashboard(folder, names)
    return 0


if __name__ == "__main__":
    sys.exit(main())
