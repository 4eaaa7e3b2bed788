#!/usr/bin/env python3
"""Tests live.py with the real program and tiny games, and how judge.py judges its documents."""

import json
import pathlib
import subprocess
import sys
import tempfile
import types
import unittest

from judging.common import nine_in_ten
from live import Cell, Game, at_equal_speed, choice, trials, worst_ratio

HERE = pathlib.Path(__file__).resolve().parent
PROGRAM = ""


def live(*words):
    return subprocess.run([HERE / "live.py", "--program", PROGRAM, "--rounds", "2", "--seconds", "0.1", *words],
                          capture_output=True, text=True, check=False)


def judged(document):
    done = subprocess.run([HERE / "judge.py", "live", "--json"], input=json.dumps(document), capture_output=True, text=True, check=False)
    return done.returncode, done.stdout, done.stderr


def rows(condition, regret, tail=1.0, rounds=5, scenes="abcd", trial=1.0):
    return [{"condition": condition, "scene": scene, "objects": 100, "rounds": rounds, "regret": regret, "lane_tail_ratio": tail,
             "trial_worst_ratio": trial, "trial_ratios": [] if trial is None else [trial] * 3, "control_ratios": [1.0] * 3, "trials": 3}
            for scene in scenes]


class Live(unittest.TestCase):
    def test_writes_a_document_that_judge_reads(self):
        done = live("--scenes", "brownian:100", "--conditions", "one-cpu,bursts", "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        document = json.loads(done.stdout)
        self.assertEqual([one["condition"] for one in document["rows"]], ["one-cpu", "bursts"])
        for one in document["rows"]:
            self.assertEqual(len(one["regrets"]), 2)
            self.assertGreater(one["half_width"], 0)
            self.assertEqual(len(one["choices"]), 2)
            self.assertEqual(len(one["raw_regrets"]), 2)
            self.assertGreaterEqual(one["lane_share"], 0)
            self.assertEqual(len(one["trial_ratios"]), one["trials"])
            self.assertEqual(one["trial_worst_ratio"] is None, one["trials"] == 0)
            self.assertIn(one["best_arm"], one["near_arms"])
        code, _, error = judged(document)
        self.assertIn(code, (0, 1), error)

    def test_ends_with_the_last_round_that_fits(self):
        done = live("--scenes", "brownian:100", "--conditions", "quiet", "--minutes", "0.0001", "--rounds", "50", "--json")
        self.assertEqual(json.loads(done.stdout)["rows"][0]["rounds"], 1, done.stderr)

    def test_can_play_only_the_games_with_and_without_the_lane(self):
        done = live("--scenes", "brownian:100", "--conditions", "quiet", "--lane-only", "--json")
        one = json.loads(done.stdout)["rows"][0]
        self.assertEqual((one["regret"], len(one["lane_tail_ratios"])), (None, 2))
        self.assertGreater(one["lane_tail_half_width"], 0)
        self.assertIn(judged(json.loads(done.stdout))[0], (0, 1))

    def test_a_game_without_a_frame_is_played_again_longer(self):
        with tempfile.TemporaryDirectory() as folder:
            program = pathlib.Path(folder) / "no_frame_in_0.1s"
            program.write_text('''#!/bin/sh
while [ "$1" != --duration ]; do shift; done
case $2 in 0.1s) row= ;; *) row="SAP,9,5" ;; esac
printf 'arm,frame_time_ns,detection_time_ns\\n%s\\n' "$row" > "$4/frames.csv"
echo {}
''', encoding="utf-8")
            program.chmod(0o755)
            game = Game(types.SimpleNamespace(program=program, seconds=0.1), "brownian", 100)
            self.assertEqual(game.fixed("SAP"), [9])

    def test_plays_with_a_quota_if_the_system_allows_one(self):
        done = live("--scenes", "brownian:100", "--conditions", "quota", "--lane-only", "--cpu-quota", "0.5", "--json")
        if done.returncode == 2:
            self.assertIn("quota", done.stderr)
            return
        self.assertEqual(json.loads(done.stdout)["rows"][0]["condition"], "quota")

    def test_a_slower_machine_does_not_count_as_regret(self):
        rest, detection = [100] * 1000, [50] * 1000
        frames = [a + b for a, b in zip(rest, detection)]
        speed = [1 if number < 512 else 2 for number in range(1000)]
        slow = [round(frame * factor) for frame, factor in zip(frames, speed)]
        slow_rest = [round(one * factor) for one, factor in zip(rest, speed)]
        self.assertAlmostEqual(at_equal_speed(slow, slow_rest, rest), at_equal_speed(frames, rest, rest))
        dearer = [frame + 15 for frame in slow]
        self.assertGreater(at_equal_speed(dearer, slow_rest, rest), 1.05 * at_equal_speed(frames, rest, rest))
        self.assertEqual(at_equal_speed(frames[:10], rest[:10], rest), 150, "fewer frames than a block")

    def test_a_choice_is_judged_by_the_arms_own_costs(self):
        medians = {"Grid": 30, "KDTree": 10}
        self.assertEqual(choice(["KDTree"] * 4, medians), 0)
        self.assertEqual(choice(["KDTree", "Grid", "KDTree", "KDTree"], medians), 0.5)

    def test_a_trial_is_on_an_arm_other_than_the_incumbent_and_ends_with_the_switch_back(self):
        arms = ["Grid", "Grid", *["SAP"] * 9, "Grid", "Tracy", "SAP", "SAP", "Grid"]
        self.assertEqual(list(trials(arms, "SAP")), [(11, 14), (15, 16)])
        self.assertEqual(list(trials(["Grid"] * 30 + ["SAP"] * 5 + ["Grid"] * 15 + ["SAP"] * 90, "SAP")), [], "SAP's own trial")
        learning = ["SAP"] * 40 + ["Grid"] * 40 + ["SAP"] * 40 + ["Tracy"] * 39 + ["SAP"] * 9
        self.assertEqual(list(trials(learning, "SAP")), [(40, 81), (120, 160)], "as long as the incumbent's stretches between them")
        self.assertEqual(list(trials(["SAP"] * 4 + ["Grid"] * 9, "SAP")), [], "which stays")
        self.assertEqual(list(trials(["SAP"] * 5, "SAP")), [])

    def test_trials_are_compared_with_the_incumbent_and_the_best_arm_with_itself(self):
        cell = types.SimpleNamespace(trial_ratios=[], control_ratios=[])
        arms = ["SAP"] * 4 + ["Grid"] + ["SAP"] * 3
        games = {"AI Decides": ([9] * 8, [1] * 8), "SAP": ([3] * 7, [1] * 7), "KDTree": ([2] * 8, [1] * 8)}
        Cell.compare_trials(cell, arms, games, "KDTree", ([4] * 9, [1] * 9))
        self.assertEqual((cell.trial_ratios, cell.control_ratios), ([3], [2]))
        del games["SAP"]  # it was too expensive to take part
        Cell.compare_trials(cell, arms, games, "KDTree", ([4] * 9, [1] * 9))
        self.assertEqual((cell.trial_ratios, cell.control_ratios), ([3, 4.5], [2, 2]))

    def test_a_trial_is_judged_by_its_worst_frame_at_equal_speed(self):
        rest = [100] * 8
        incumbent = [150, 150, 150, 160, 150, 150, 150, 900]
        trial = [150, 150, 150, 150, 240, 150, 150, 150]
        self.assertAlmostEqual(worst_ratio((2, 6), trial, rest, incumbent, rest), 240 / 160)
        slow = [2 * frame for frame in trial]
        self.assertAlmostEqual(worst_ratio((2, 6), slow, [200] * 8, incumbent, rest), 240 / 160, msg="the machine was slower")
        self.assertEqual([nine_in_ten(range(count)) for count in (1, 2, 10, 20)], [0, 1, 8, 17])

    def test_reports_errors(self):
        for words, expected in ((("--scenes", "brownian"), "brownian"), (("--conditions", "loud"), "quiet"),
                                (("--scenes", "nowhere:10"), "nowhere")):
            done = live(*words)
            self.assertEqual(done.returncode, 2)
            self.assertIn(expected, done.stderr)

    def test_goals_are_judged_per_condition(self):
        met = {"command": "live", "rows": rows("quiet", 0.02, scenes="ab") + rows("quiet", -0.01, scenes="cd")}
        self.assertEqual(judged(met)[0], 0)
        figures = json.loads(judged(met)[1])["figures"]
        self.assertEqual({each["met"] for each in figures if each["condition"] == "quiet"}, {True})
        self.assertEqual({each["met"] for each in figures if each["condition"] == "one-cpu"}, {None}, "not measured is not met")
        for bad in (rows("quiet", 0.031), rows("quiet", 0.0, 1.2), rows("neighbours", 0.021), rows("quiet", 0.0, trial=1.3)):
            self.assertEqual(judged({"command": "live", "rows": bad})[0], 1, bad)
        for too_few, given in (("rounds", rows("quiet", 0.0, rounds=4)), ("scenes", rows("quiet", 0.0, scenes="abca"))):
            code, out, _ = judged({"command": "live", "rows": given})
            self.assertEqual((code, json.loads(out)["figures"][0]["too_few"]), (1, too_few), "four rounds or three scenes are too few")
        self.assertEqual(judged({"command": "live", "rows": rows("quiet", 0.0, trial=None)})[0], 0, "without a trial none can hurt")
        one_without = {"command": "live", "rows": rows("quiet", 0.0, scenes="abcd") + rows("quiet", 0.0, scenes="e", trial=None)}
        figures = {each["figure"]: each["met"] for each in json.loads(judged(one_without)[1])["figures"] if each["condition"] == "quiet"}
        self.assertEqual(figures["trial_worst_ratio"], True)
        few = rows("quiet", 0.0, scenes="abc", trial=9.0) + rows("quiet", 0.0, scenes="d", trial=None)
        figures = [each for each in json.loads(judged({"command": "live", "rows": few})[1])["figures"] if each["condition"] == "quiet"]
        self.assertEqual([(each["met"], each["trials"]) for each in figures if "trials" in each], [(None, 9)], "nine trials are too few")
        of_lane = {"command": "live", "rows": rows("quiet", None, 1.05, trial=None)}
        figures = json.loads(judged(of_lane)[1])["figures"]
        self.assertEqual([each["figure"] for each in figures if each["met"]], ["lane_tail_ratio"])
        self.assertEqual(judged({"command": "live", "rows": 5})[0], 2)
        self.assertEqual(judged({"command": "bench", "rows": rows("quiet", 0)})[0], 2)
        self.assertEqual(judged({"command": "live", "rows": rows("loud", 0)})[0], 2)


if __name__ == "__main__":
    PROGRAM = sys.argv.pop(1)
    unittest.main()
