#!/usr/bin/env python3
"""Tests conditions.py and sealed.py with the real program on tiny scenes, and how judging/ combines cells.

conditions_test.py SWEEPSTAKE
"""

import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

import conditions
import sealed
from judging import ablation, choosing
from judging.common import InputError, read_goals

HERE = pathlib.Path(__file__).resolve().parent
PROGRAM = ""
SCENES = "brownian 60 40 3 1s stationary\nhurricane 90 40 3 1s stationary\nwaves 60 80 4 1s changing\nwaves 60 80 4 2s resonant\n"
QUICK = ("--seeds", "2", "--run", "20s")


def called(tool, *words):
    return subprocess.run([HERE / tool, "--program", PROGRAM, *QUICK, *words], capture_output=True, text=True, check=False)


def cell(name="a", condition="clean", category="stationary", flip_s=None, **figures):
    return {"cell": name, "condition": condition, "category": category, "flip_s": flip_s} | figures


def judged(over, cells, **more):
    goal = {"goal": "g", "row": "r", "figure": "x", "over": over, "unit": "percent", "at_most": 0.1} | more
    return choosing.judge({"row": "r", "cells": cells}, [goal])[0]


class Goals(unittest.TestCase):
    def test_combine_the_cells(self):
        cells = [cell(x=0.05, w=1, p=1.0), cell(x=0.2, w=3, p=2.0), cell(condition="noise", x=0.0, w=1, p=1.0)]
        for over, more, reached, met in (
                ("each", {}, 0.2, False), ("mean", {}, 0.25 / 3, True), ("group", {}, 0.125, False),
                ("weighted", {"weight": "w"}, 0.65 / 5, False), ("share", {"weight": "w"}, 0.25 / 5, True),
                ("times", {"peer": "p", "unit": "times"}, 4.0 / 0.25, False),
                ("each", {"condition": "noise"}, 0.0, True)):
            goal = judged(over, cells, **more)
            self.assertAlmostEqual(goal["reached"], reached, msg=over)
            self.assertEqual(goal["met"], met, over)

    def test_of_groups_separate_paces_and_categories(self):
        cells = [cell(x=0.0), cell(x=0.1, flip_s=8), cell(x=0.4, flip_s=16), cell(x=0.0, flip_s=16), cell(x=0.15, category="changing")]
        self.assertAlmostEqual(judged("group", cells)["reached"], 0.2)

    def test_at_least_judges_the_smallest_value(self):
        goal = choosing.judge({"row": "r", "cells": [cell("a", x=0.3), cell("b", x=0.2)]}, [
            {"goal": "g", "row": "r", "figure": "x", "over": "each", "unit": "percent", "at_least": 0.25}])[0]
        self.assertEqual((goal["reached"], goal["met"], goal["cells"][0]["cell"]), (0.2, False, "b, clean"))

    def test_a_cell_without_a_value_is_not_judged_and_one_without_the_figure_is_an_error(self):
        goal = judged("each", [cell(x=None)])
        self.assertEqual((goal["reached"], goal["met"]), (None, False))
        with self.assertRaises(InputError):
            judged("each", [cell(y=1)])
        with self.assertRaises(InputError):
            choosing.judge({"row": "other", "cells": [cell(x=1)]}, [])

    def test_use_only_conditions_and_flips_of_their_row(self):
        plan, goals = conditions.read_plan(), read_goals(choosing.GOALS)["choosing"]
        for name, row in plan["row"].items():
            own = [goal for goal in goals if goal["row"] == name]
            self.assertNotEqual(bool(own), plan["row"][name].get("compares_policies", False), name)
            for goal in own:
                self.assertIn(goal.get("condition", row["conditions"][0]), row["conditions"], goal)
                self.assertIn(goal.get("flip_s"), [None, *row.get("flip_s", [])], goal)
            for condition in row["conditions"]:
                self.assertIn(condition, plan["condition"])


class Ablation(unittest.TestCase):
    CELLS = [cell(name, condition, flip_s=flip_s, policies={policy: {"regret": factor * regret, "headroom": headroom, "captured": captured}
                                                            for policy, factor in (("default", 1), ("paper", 10))})
             for name, condition, flip_s, regret, headroom, captured in (
                 ("a", "clean", None, 0.01, 0.0, None), ("b", "clean", None, 0.03, 0.0, None), ("c", "clean", 8, 0.5, 0.1, 0.2),
                 ("d", "clean", 16, 0.5, 0.3, 0.6), ("e", "clean", 16, 0.5, 0.0, None), ("a", "load", None, 0.05, 0.0, None))]

    def test_has_a_row_for_each_policy_and_condition(self):
        rows = ablation.compare(self.CELLS)
        self.assertEqual([(row["policy"], row["condition"]) for row in rows],
                         [("default", "clean"), ("default", "load"), ("paper", "clean"), ("paper", "load")])
        self.assertAlmostEqual(rows[0]["regret"], 0.02, msg="flips do not count")
        self.assertAlmostEqual(rows[0]["worst_regret"], 0.03)
        self.assertAlmostEqual(rows[0]["captured"], 0.5, msg="the cells count with their headroom")
        self.assertAlmostEqual(rows[2]["worst_regret"], 0.3)
        self.assertIsNone(rows[1]["captured"])

    def test_prints_a_column_for_each_condition(self):
        text = ablation.ablation_text({"list": "tiny.txt", "seeds": 2, "cells": self.CELLS}, ablation.compare(self.CELLS))
        self.assertIn("policy   clean          load\ndefault  2.00 (3.00)    5.00 (5.00)\npaper    20.00 (30.00)  50.00 (50.00)\n", text)
        self.assertIn("regimes of 8, 16 s: captured headroom in percent\npolicy   clean  load\ndefault     50     -\n", text)


class Conditions(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = pathlib.Path(temporary.name)
        cls.scenes = cls.folder / "tiny.txt"
        cls.scenes.write_text(SCENES)

    def run_row(self, row, *words):
        return called("conditions.py", row, self.scenes, "--traces", self.folder / "traces", *words)

    def test_measure_every_goal_of_the_rows(self):
        goals = read_goals(choosing.GOALS)["choosing"]
        for row, plan in conditions.read_plan()["row"].items():
            if plan.get("compares_policies"):
                continue
            with self.subTest(row=row):
                done = self.run_row(row, "--json")
                self.assertIn(done.returncode, (0, 1), done.stderr)
                document = json.loads(done.stdout)
                self.assertEqual([goal["goal"] for goal in document["goals"]], [goal["goal"] for goal in goals if goal["row"] == row])
                self.assertEqual({one["condition"] for one in document["cells"]}, set(plan["conditions"]))
                self.assertEqual({one["flip_s"] for one in document["cells"] if one["category"] == "flipping"},
                                 set(plan.get("flip_s", [])))
                if "priors" in plan:
                    opening = [(one["regret_first_10_s"], one["regret_first_10_s_cold"]) for one in document["cells"]]
                    self.assertTrue(any(own != cold for own, cold in opening), opening)
                for peer in plan["peers"]:
                    self.assertIsInstance(document["cells"][0]["excess_" + peer], float)
                again = subprocess.run([HERE / "judge.py", "choosing", "--json"], input=done.stdout, capture_output=True, text=True,
                                       check=False)
                self.assertEqual((again.returncode, json.loads(again.stdout)["goals"]), (done.returncode, document["goals"]))

    def test_the_ablation_compares_every_part_in_every_condition(self):
        done = self.run_row("ablation", "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        document, plan = json.loads(done.stdout), conditions.read_plan()["row"]["ablation"]
        rows = {(row["policy"], row["condition"]): row for row in document["policies"]}
        policies = list(dict.fromkeys(policy for policy, _ in rows))
        self.assertEqual(policies[0], "default")
        self.assertTrue(set(plan["peers"]) - {"ablations"} < set(policies), policies)
        self.assertGreater(sum(policy.startswith("adaptive-without-") for policy in policies), 3)
        self.assertEqual(len(rows), len(policies) * len(plan["conditions"]))
        self.assertNotEqual(rows["default", "clean"], rows["default", "one-cpu"] | {"condition": "clean"}, "the lane rests on one processor")
        self.assertEqual(rows["fixed:KDTree", "clean"], rows["fixed:KDTree", "one-cpu"] | {"condition": "clean"})

    def test_milliseconds_compare_with_other_arms_and_policies(self):
        frame = {"detection": 2, "best": 1, "median": 5, "worst": 9, "regret": 1, "lane": 4}
        self.assertEqual(conditions.milliseconds(frame), {
            "ms_best": 1, "ms_lost": 1, "ms_saved_median": 3, "ms_saved_worst": 7, "ms_lane": 4, "ms_lane_unpaid": 1})
        own = dict.fromkeys(("headroom", "regret_best_fixed", "ci95", "regret_after_start", "headroom_captured", "switches",
                             "switches_after_start"), 0) | {"reliability": []}
        rows = {"default": own | {"ms_per_frame": frame}, "paper": own | {"ms_per_frame": frame | {"detection": 2.5}}}
        self.assertEqual(conditions.cell_of("clean", cell(), rows, "default", ["paper"], None)["ms_saved_paper"], 0.5)

    def test_decisions_are_counted_by_their_p_best(self):
        bins = [{"low": low, "high": high, "decisions": 10, "best": best} for low, high, best in ((0.7, 0.8, 1), (0.8, 0.9, 0.5))]
        self.assertEqual(conditions.said(bins, 0.8, 0.9), {"p_best_said": 10, "p_best_right": 5})

    def test_the_lane_model_changes_the_replay(self):
        regrets = []
        for arm in ("Grid", "AxisSweep"):  # a policy that only takes the cheapest arm would choose this one
            model = self.folder / f"{arm}.toml"
            model.write_text(f"[lane-ratio]\n{arm} = 0.01\n")
            cells = json.loads(self.run_row("stationary", "--json", "--lane-model", model).stdout)["cells"]
            regrets.append({one["condition"]: one["regret_lane-argmin"] for one in cells})
        self.assertNotEqual(regrets[0]["measured"], regrets[1]["measured"])
        self.assertEqual(regrets[0]["bias"], regrets[1]["bias"], "the condition bias has no lane model")
        self.assertEqual(conditions.condition_words({"lane_model": True, "options": {"lane-noise": 0.3}},
                                                    {"lane-noise": 0.15, "lane-ratio": {"SAP": 0.9}}),
                         ["--lane-noise", "0.3", "--lane-ratio", "SAP", "0.9"])

    def test_flips_have_the_requested_duration(self):
        row = {"categories": [], "flip_s": [8]}
        games = conditions.games_of(row, [{"cell": "waves-3000-2", "scene": "waves", "frames": 3600, "pass": "1m", "category": "changing"}],
                                    {"waves": 400})
        self.assertEqual([game["pass"] for game in games], ["72000ms"])

    def test_reports_errors(self):
        self.assertIn("invalid choice", called("conditions.py", "nothing").stderr)
        empty = self.folder / "empty.txt"
        empty.write_text("suite-b 60 40 1 1s resonant\n")
        done = called("conditions.py", "stationary", empty, "--traces", self.folder / "traces")
        self.assertEqual(done.returncode, 2)
        self.assertIn("no scene of the row's categories", done.stderr)


class Sealed(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.list = pathlib.Path(temporary.name) / "mine.toml"
        self.regime_frames = conditions.read_plan()["regime_frames"]
        sealed.seal(self.list, self.regime_frames, stationary=1, changing=1, objects=[50, 60], frames=80)

    def test_the_committed_list_matches_its_hashes(self):
        self.assertGreaterEqual(len(sealed.read_sealed(sealed.LIST, self.regime_frames)), 8)

    def test_a_changed_rule_is_detected(self):
        self.list.write_text(self.list.read_text().replace("objects = [50, 60]", "objects = [500, 600]"))
        with self.assertRaisesRegex(InputError, "other scenes than those that were sealed"):
            sealed.read_sealed(self.list, self.regime_frames)

    def test_a_sealed_list_is_never_replaced(self):
        with self.assertRaises(FileExistsError):
            sealed.seal(self.list, self.regime_frames)

    def test_a_look_is_logged_and_names_no_scene(self):
        done = called("sealed.py", "--list", self.list, "--json")
        self.assertIn(done.returncode, (0, 1), done.stderr)
        rows = json.loads(done.stdout)["rows"]
        self.assertEqual([row["row"] for row in rows], list(sealed.ROWS))
        self.assertEqual({one["cell"] for row in rows for one in row["cells"]}, {"sealed-1", "sealed-2"})
        begun, ended = self.list.with_name("mine_looks.log").read_text().splitlines()
        self.assertRegex(begun, r"^\d{4}-\d\d-\d\dT[\d:]{8}Z  \w{7,12}(-changed)?  begun  tests/bench/sealed.py .*--list")
        for row in rows:
            for goal in row["goals"]:
                self.assertIn(goal["goal"], ended)
        for scene in sealed.read_sealed(self.list, self.regime_frames):
            for text in (done.stdout, done.stderr, begun, ended):
                self.assertNotIn(f'"{scene["scene"]}"', text)
                self.assertNotIn(f" {scene['scene']} ", text)

    def test_a_failed_look_is_logged_too(self):
        done = subprocess.run([HERE / "sealed.py", "--program", "/bin/false", "--list", self.list], capture_output=True, text=True,
                              check=False)
        self.assertEqual(done.returncode, 2)
        self.assertEqual(len(self.list.with_name("mine_looks.log").read_text().splitlines()), 1)


if __name__ == "__main__":
    PROGRAM = sys.argv.pop(1)
    unittest.main()
