"""Runs decisions.sh on one tiny cell with the real programs: judge.py must read all that they print.

decisions_test.py SWEEPSTAKE DECISION_TICK_BENCH
"""

import contextlib
import io
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import judge  # noqa: E402

CELL = "brownian-60-3"
SCENES = "brownian 60 40 3 1s stationary\n"
# Keys of the programs' documents that the table of decisions uses.
KEYS = ("command", "seeds", "scenes", "costs", "control_regret", "rows", "policy", "priors", "pass_ns", "regret_best_fixed",
        "ci95", "regret_after_start", "headroom", "headroom_captured", "switches", "active_share", "bail_outs", "arms", "p99_ms")
# Calls the real program and keeps the output of `sweepstake-lab replay`, which decisions.sh deletes.
RECORDER = """#!/usr/bin/env bash
set -euo pipefail
if [[ $1 == replay ]]; then
  '{program}' "$@" | tee "$(mktemp '{folder}/replay-XXXXXX')"
else
  exec '{program}' "$@"
fi
"""
TICK_RECORDER = """#!/usr/bin/env bash
set -euo pipefail
'{program}' "$@" | tee '{folder}/time'
"""


def renamed(value, key):
    """Returns the document with `key` renamed wherever it occurs."""
    if isinstance(value, dict):
        return {name + "_renamed" if name == key else name: renamed(inner, key) for name, inner in value.items()}
    return [renamed(inner, key) for inner in value] if isinstance(value, list) else value


class DecisionsOfOneCell(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = pathlib.Path(temporary.name)
        cls.scenes = cls.folder / "one_cell.txt"
        cls.scenes.write_text(SCENES)
        documents = cls.folder / "documents"
        documents.mkdir()
        for name, text, program in (("sweepstake", RECORDER, PROGRAM), ("decision_tick_bench", TICK_RECORDER, TICK_BENCH)):
            recorder = cls.folder / name
            recorder.write_text(text.format(program=program, folder=documents))
            recorder.chmod(0o755)
        cls.run_of_script = subprocess.run(
            [pathlib.Path(__file__).with_name("decisions.sh"), "--program", cls.folder / "sweepstake", "--traces",
             cls.folder / "traces", cls.scenes, "--", "--json", "--seeds", "2"], capture_output=True, text=True, check=False)
        cls.documents = [json.loads(path.read_text()) for path in sorted(documents.iterdir())]

    def judge(self, documents):
        """Returns the exit code and stderr of judge.py with text tables."""
        paths = []
        for number, document in enumerate(documents):
            paths.append(self.folder / f"{number}.json")
            paths[-1].write_text(json.dumps(document))
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = judge.main(["decisions", "--policy", "default", "--cells", str(self.scenes), *map(str, paths)])
        return code, err.getvalue()

    def test_the_script_judges_the_cell(self):
        # 1 means a missed goal, which is likely in a trace of 40 frames.
        self.assertIn(self.run_of_script.returncode, (0, 1), self.run_of_script.stderr)
        document = json.loads(self.run_of_script.stdout)
        self.assertEqual((document["policy"], document["seeds"]), ("default", 2))
        self.assertEqual([(cell["cell"], cell["category"]) for cell in document["cells"]], [(CELL, "stationary")])
        self.assertEqual([(pathlib.PurePath(row["costs"]).stem, row["policy"], row["priors"]) for row in document["rows"]],
                         [(CELL, "default", "none"), (CELL, "paper", "none")])
        behind = {goal["goal"]: [cell["cell"] for cell in goal["cells"]] for goal in document["goals"]}
        self.assertEqual(behind["wrong prior"], [CELL])
        self.assertEqual(behind["bail-outs with the shadow lane"], [CELL])
        reached = {goal["goal"]: goal["reached"] for goal in document["goals"]}
        self.assertGreater(reached["a decision, p99 with 32 arms"], 0)

    def test_the_script_replays_with_each_kind_of_priors_and_times_a_decision(self):
        self.assertEqual(sorted({row["priors"] for document in self.documents if document["command"] == "replay"
                                 for row in document["rows"]}), ["class", "none", "right", "scenes", "wrong"])
        self.assertEqual(len(self.documents), 6)

    def test_a_key_under_another_name_is_an_error(self):
        code, err = self.judge(self.documents)
        self.assertIn(code, (0, 1), err)
        for key in KEYS:
            changed = [renamed(document, key) for document in self.documents]
            with self.subTest(key=key):
                self.assertNotEqual(changed, self.documents, "no document has the key")
                self.assertEqual(self.judge(changed)[0], 2)


if __name__ == "__main__":
    PROGRAM, TICK_BENCH = (pathlib.Path(word).resolve() for word in sys.argv[1:3])
    unittest.main(argv=sys.argv[:1])
