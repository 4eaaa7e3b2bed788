#!/usr/bin/env python3
"""Tests stored_priors.py, worth.py and lane_model.py with real programs and tiny games, and their arithmetic on given figures.

games_test.py FOLDER, with sweepstake and sweepstaked
"""

import json
import math
import pathlib
import subprocess
import sys
import tomllib
import unittest

import conditions
import lane_model
import stored_priors
import worth

HERE = pathlib.Path(__file__).resolve().parent
PROGRAMS = pathlib.Path()


def called(tool, *words):
    return subprocess.run([HERE / tool, *map(str, words)], capture_output=True, text=True, check=False)


class StoredPriors(unittest.TestCase):
    def test_go_through_a_daemon_s_store(self):
        done = called("stored_priors.py", "--programs", PROGRAMS, "--scenes", "brownian:100", "--rounds", 2, "--seconds", 2,
                      "--time-scale", 60, "--json")
        self.assertIn(done.returncode, (0, 1), done.stderr)
        document = json.loads(done.stdout)
        self.assertEqual([cell["cell"] for cell in document["cells"]], ["brownian-100"])
        for kind in stored_priors.KINDS:
            self.assertIsInstance(document["cells"][0]["regret_" + kind], float)
            self.assertGreater(document["cells"][0]["half_width_" + kind], 0)
        self.assertEqual(len(document["goals"]), 2)

    def test_wrong_priors_reverse_the_ranking(self):
        def record(arm, alpha, beta, count):
            return {"arm": arm, "alpha_increment": alpha, "beta_increment": beta, "window_count": count, "scene": "s"}
        wrong = stored_priors.reversed_ranking([record("Grid", 9, 1, 3), record("SAP", 1, 9, 2), record("DBVT", 5, 5, 1)])
        self.assertEqual({each["arm"]: (each["alpha_increment"], each["beta_increment"], each["window_count"]) for each in wrong},
                         {"Grid": (1, 9, 2), "SAP": (9, 1, 3), "DBVT": (5, 5, 1)})


class Worth(unittest.TestCase):
    def test_is_measured_and_judged(self):
        done = called("worth.py", "--program", PROGRAMS / "sweepstake", "--scenes", "brownian,nearly-resting", "--objects", "60,90",
                      "--seconds", 0.2, "--json")
        self.assertIn(done.returncode, (0, 1), done.stderr)
        document = json.loads(done.stdout)
        self.assertEqual([cell["cell"] for cell in document["cells"]],
                         ["brownian-60", "nearly-resting-60", "brownian-90", "nearly-resting-90"])
        for cell in document["cells"]:
            if cell["best"] == worth.ALWAYS:
                self.assertEqual(cell["worth"], 1)
            self.assertAlmostEqual(cell["gain"] * (1 + cell["regret"]), cell["worth"])
        possible, gain = (sum(cell[name] for cell in document["cells"]) for name in ("log_worth", "log_gain"))
        self.assertAlmostEqual(document["goals"][0]["reached"] or 0, gain / possible if possible else 0)

    def test_compares_the_reported_saving_with_the_measured_one(self):
        self.assertEqual(worth.saving_of(100, 80, [30, None, 40]), {"saved_us": 20, "reported_us": 35, "saving_error": 0.15})
        self.assertEqual(worth.saving_of(100, 80, [None]), {"saved_us": 20, "reported_us": None, "saving_error": None})

    def test_compares_games_at_equal_speed_including_the_lane(self):
        decided, always = ([10, 10], [30, 30]), ([30, 30], [60, 60])  # detection and other work: the second game ran at half the speed
        self.assertEqual(worth.mean_detections({"AI Decides": decided, "KDTree": always}, 0.05), {"AI Decides": 12, "KDTree": 15})
        little = ([1000, 3000], [1, 1])
        self.assertEqual(worth.mean_detections({"AI Decides": decided, "KDTree": little}, 0.05), {"AI Decides": 10, "KDTree": 2000})


class LaneModel(unittest.TestCase):
    def test_is_accepted_by_replays(self):
        done = called("lane_model.py", "--program", PROGRAMS / "sweepstake", "--scenes", "brownian:200", "--arms", "SAP,KDTree",
                      "--seconds", 2, "--time-scale", 60)
        if done.returncode == 2:
            self.assertIn("too few visits", done.stderr)
            self.assertRegex(done.stderr, "lane (running|off, no core to spare): left out")
            self.skipTest("the machine was too busy for the lane's visits")
        words = conditions.lane_words(tomllib.loads(done.stdout))
        self.assertEqual(words[0:4:2], ["--lane-noise", "--lane-contention"])
        self.assertIn("--lane-ratio", words)

    def test_is_not_measured_if_the_lane_does_not_run(self):
        for words, reason in ((("--condition", "one-cpu"), "invalid choice: 'one-cpu'"),
                              (("--condition", "quota", "--cpu-quota", "1.5"), "the lane rests")):
            done = called("lane_model.py", "--program", PROGRAMS / "sweepstake", *words)
            self.assertEqual((done.returncode, reason in done.stderr), (2, True), done.stderr)

    def test_compares_a_visit_with_the_frames_that_it_measured(self):
        row = {"shadow_first_frame_index": "10", "shadow_detection_time_ns": "500", "shadow_build_time_ns": "9000", "shadow_flags": "1"}
        capped = {**row, "shadow_detection_time_ns": "70", "shadow_flags": "3"}
        of_another_arm = {**capped, "shadow_flags": "0"}
        visits = [lane_model.visit_of(each) for each in (row, of_another_arm, capped)]
        frames = [1] * 13 + [900, 950, 1000, 1050, 1100] + [1] * 9
        self.assertEqual(lane_model.errors_of(visits, frames), [math.log(0.5)])
        self.assertAlmostEqual(lane_model.spread([-1.349, 0, 1.349] * 9), 2, places=5)

    def test_contention_compares_frames_during_and_before_a_sweep(self):
        visits = [(10, 10, 130, lane_model.ACTIVE)]  # 200 ns of work
        frames = [40] * 18 + [50] * 4 + [40] * 20
        self.assertEqual(lane_model.contention_of(visits, frames), 1.25)
        self.assertIsNone(lane_model.contention_of(visits, frames[:20]))

    def test_is_measured_on_the_lanes_frames(self):
        header = (HERE.parents[1] / "engine_client/adaptive/shadow_schedule.h").read_text()
        self.assertIn(f"kShadowBurstFrames = {lane_model.VISIT_FRAMES};", header)
        self.assertIn(f"kShadowWarmUpFrames = {lane_model.UNMEASURED_FRAMES - 1};", header)


class Mistakes(unittest.TestCase):
    def test_are_reported(self):
        for words, expected in ((("stored_priors.py", "--programs", "/nowhere"), "no program at /nowhere/sweepstake"),
                                (("worth.py", "--program", PROGRAMS / "sweepstake", "--seconds", 0), "more than 0 seconds"),
                                (("worth.py", "--program", PROGRAMS / "sweepstake", "--scenes", "nowhere", "--seconds", 0.1), "nowhere"),
                                (("lane_model.py", "--program", PROGRAMS / "sweepstake", "--arms", "Tree"), "unknown arm 'Tree'")):
            done = called(*words)
            self.assertEqual(done.returncode, 2, words)
            self.assertIn(expected, done.stderr)


if __name__ == "__main__":
    PROGRAMS = pathlib.Path(sys.argv.pop(1))
    unittest.main()
