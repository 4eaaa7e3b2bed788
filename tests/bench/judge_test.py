"""Tests judge.py: goals that are met and missed, and errors for incomplete input."""

import contextlib
import copy
import io
import json
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import judge  # noqa: E402
from judging import backends, common, decisions  # noqa: E402


def run(words, documents=()):
    """Returns exit code, stdout and stderr of judge.py; `documents` are written to files and passed as the last arguments."""
    out, err = io.StringIO(), io.StringIO()
    with tempfile.TemporaryDirectory() as folder:
        paths = []
        for number, document in enumerate(documents):
            paths.append(pathlib.Path(folder) / f"{number}.json")
            paths[-1].write_text(document if isinstance(document, str) else json.dumps(document))
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = judge.main([*words, *map(str, paths)])
    return code, out.getvalue(), err.getvalue()


# Backends -----------------------------------------------------------------------------------------------------------------


def bench_row(arm, ms=1.0, kind="arm", family=None, scene="suite-b", objects=10_000, threads=1, simd="avx512", **more):
    return {"scene": scene, "objects": objects, "arm": arm, "simd": simd if kind == "arm" else None, "threads": threads,
            "frames": 10, "ms_median": ms, "ms_mean": ms, "ms_min": ms, "ms_p99": ms, "pairs_mean": 5.0,
            "aabb_checks_mean": None, "bytes": None, "kind": kind, "family": family or arm} | more


def ratio(kind, ours, other, value, scene="suite-b", objects=10_000, threads=1, family=None, simd="avx512"):
    return {"scene": scene, "objects": objects, "threads": threads, "kind": kind, "family": family or ours, "ours": ours,
            "simd": simd, "other": other, "value": value, "value_mean": value}


def speedup(arm, peer, times, scene="suite-b", objects=10_000, simd="avx512"):
    return {"scene": scene, "objects": objects, "arm": arm, "simd": simd, "peer": peer, "median": times, "mean": 2 * times}


def bench_document(rows, ratios=(), speedups=(), simd=("avx512",), cold=False):
    machine = {"date": "2026-01-31", "program": "1", "cpu": "A processor", "cores": 2, "system": "Linux", "compiler": "gcc",
               "simd": simd[0], "libraries": {"hwy": "1"}, "absent_peers": []}
    return {"command": "bench", "cold": cold, "simd": list(simd), "machine": machine, "rows": list(rows),
            "ratios": list(ratios), "speedups": list(speedups)}


def judged(document):
    code, out, err = run(["bench", "--json"], [document])
    return code, json.loads(out), err


class BenchGoals(unittest.TestCase):
    def goal_of(self, cold=False, published=False, **fields):
        goals = common.read_goals(judge.DATA / "goals.toml")
        compared = ratio(**({"kind": "family", "ours": "Grid", "other": "Peer", "value": 1.0} | fields))
        if published:
            compared["derived_through"] = "Embree"
        document = bench_document([], simd=("avx512", "avx2", "sse4"), cold=cold)
        return backends.bench_goal(goals, compared, document)["goal"]

    def test_depend_on_the_scene_and_its_size(self):
        for fields, goal in (
            ({"kind": "overall", "objects": 1_000}, 5),
            ({"kind": "overall", "scene": "suite-h", "objects": 100_000}, 10),
            ({"kind": "overall", "scene": "suite-g", "objects": 1_000}, 10),
            ({"kind": "overall", "scene": "beams"}, 5),
            ({"kind": "overall", "scene": "nearly-resting"}, None),
            ({"ours": "DBVT", "objects": 1_000}, 7),
            ({"ours": "DBVT", "scene": "nearly-resting"}, 1.3),
            ({"ours": "DBVT", "scene": "beams"}, None),
            ({"ours": "Tracy"}, 20),
            ({"ours": "Tracy", "other": "PhysxMbp"}, 4),
            ({"kind": "threads", "threads": 2}, 1.7),
            ({"kind": "threads", "threads": 4}, None),
            ({"kind": "threads", "threads": 2, "objects": 1_000}, None),
            ({"kind": "spike"}, 2),
            ({"kind": "growth"}, 2),
        ):
            self.assertEqual(self.goal_of(**fields), goal, fields)

    def test_depend_on_the_instruction_set(self):
        for fields, goal in (
            ({"kind": "overall", "simd": "avx2", "objects": 1_000}, 10),
            ({"kind": "overall", "simd": "avx2", "scene": "beams"}, None),
            ({"kind": "overall", "simd": "sse4"}, None),
            ({"simd": "avx2"}, None),
            ({"kind": "spike", "simd": "sse4"}, 2),
            ({"kind": "simd", "simd": "avx2", "other": "avx512"}, 1.7),
            ({"kind": "simd", "simd": "avx2", "other": "avx512", "ours": "BruteForce"}, 1.2),
            ({"kind": "simd", "simd": "sse4", "other": "avx2", "ours": "BruteForce"}, 2),
            ({"kind": "simd", "simd": "sse4", "other": "avx512"}, None),
            ({"kind": "simd", "simd": "sse4", "other": "avx2", "scene": "beams"}, None),
            ({"kind": "simd", "simd": "sse4", "other": "avx2", "objects": 400}, None),
        ):
            self.assertEqual(self.goal_of(**fields), goal, fields)

    def test_of_the_best_instruction_set_apply_to_the_best_measured_one(self):
        goals = common.read_goals(judge.DATA / "goals.toml")
        for measured, goal in ((("avx2", "sse4"), 6), (("avx512", "avx2"), None)):
            found = backends.bench_goal(goals, ratio("family", "Grid", "Peer", 1.0, simd="avx2"), bench_document([], simd=measured))
            self.assertEqual(found["goal"], goal, measured)

    def test_depend_on_whether_the_peer_ran(self):
        for fields, goal in (
            ({"simd": "avx2", "published": True, "other": "PhysxAbp"}, 4),
            ({"simd": "avx2", "published": True, "other": "PhysxAbp", "objects": 100_000}, 8),
            ({"simd": "avx2", "published": True, "other": "BroadmarkSap"}, None),
            ({"simd": "avx2", "published": False, "other": "PhysxAbp"}, 10),
            ({"simd": "avx512", "published": True, "other": "PhysxAbp"}, 5),
            ({"simd": "avx512", "published": True, "other": "BroadmarkSap", "scene": "suite-g", "objects": 1_000}, 10),
        ):
            self.assertEqual(self.goal_of(kind="overall", **fields), goal, fields)

    def test_differ_with_cold_caches(self):
        for fields, goal in (
            ({"kind": "overall"}, 8),
            ({"kind": "overall", "simd": "avx2"}, 8),
            ({"kind": "overall", "simd": "sse4"}, None),
            ({"kind": "overall", "published": True, "other": "PhysxAbp"}, None),
            ({"kind": "simd", "simd": "avx2", "other": "avx512"}, None),
            ({}, None),
        ):
            self.assertEqual(self.goal_of(cold=True, **fields), goal, fields)

    def test_of_instruction_sets_have_a_lower_and_an_upper_limit(self):
        for value, met in ((0.99, False), (1.0, True), (2.0, True), (2.01, False)):
            document = bench_document([bench_row("Grid", simd="sse4")], [ratio("simd", "Grid", "avx2", value, simd="sse4")],
                                      simd=("avx2", "sse4"))
            code, found, _ = judged(document)
            self.assertEqual(code, 0 if met else 1, value)
            self.assertEqual({key: found["goals"][0][key] for key in ("goal", "goal_at_least", "met")},
                             {"goal": 2.0, "goal_at_least": 1.0, "met": met})
            self.assertIn("1.0-2.0", run(["bench"], [document])[1])

    def test_exist_for_every_family(self):
        for family in ("BruteForce", "Grid", "SAP", "AxisSweep", "DBVT", "Tracy", "KDTree"):
            self.assertIsNotNone(self.goal_of(ours=family), family)

    def test_are_met_at_the_limit_and_missed_beyond_it(self):
        for kind, ours, value, code in (("family", "Grid", 6.0, 0), ("family", "Grid", 5.99, 1),
                                        ("spike", "KDTree", 2.0, 0), ("spike", "KDTree", 2.01, 1)):
            found, document, _ = judged(bench_document([bench_row(ours)], [ratio(kind, ours, "Peer", value)]))
            self.assertEqual(found, code, (kind, value))
            self.assertEqual(document["goals"][0]["met"], code == 0)
            self.assertEqual(document["rows"], [bench_row(ours)], "the document is kept completely")

    def test_of_memory_count_the_pairs(self):
        row = bench_row("KDTree", objects=100_000, bytes_with_pairs=9_000_000)
        code, document, _ = judged(bench_document([row]))
        self.assertEqual((code, document["goals"][0]["value"], document["goals"][0]["other"]), (0, 0.75, "12 MB"))
        row["bytes_with_pairs"] = 12_000_001
        self.assertEqual(judged(bench_document([row]))[0], 1)

    def test_of_memory_apply_to_each_instruction_set(self):
        rows = [bench_row("KDTree", objects=100_000, simd=simd, bytes_with_pairs=held)
                for simd, held in (("avx512", 6_000_000), ("avx2", 13_000_000))]
        code, document, _ = judged(bench_document(rows, simd=("avx512", "avx2")))
        self.assertEqual((code, [(each["simd"], each["met"]) for each in document["goals"]]),
                         (1, [("avx512", True), ("avx2", False)]))


class PublishedFigures(unittest.TestCase):
    def test_are_derived_from_times_of_embree(self):
        _, document, _ = judged(bench_document(
            [bench_row("SAP")], speedups=[speedup("SAP", "Embree", 5), speedup("SAP", "BulletDbvtDeferred", 7)]))
        own = [each for each in document["published"] if each["kind"] == "family"]
        self.assertEqual([(each["other"], each["derived_through"]) for each in own], [("BroadmarkSap", "Embree")])
        self.assertAlmostEqual(own[0]["value"], 5 * 2.39 / 2.50)
        self.assertAlmostEqual(own[0]["value_mean"], 10 * 2.39 / 2.50)

    def test_apply_to_warm_caches_only(self):
        _, document, _ = judged(bench_document([bench_row("SAP")], speedups=[speedup("SAP", "Embree", 5)], cold=True))
        self.assertEqual(document["published"], [])

    def test_are_derived_from_times_of_bullet_without_embree(self):
        _, document, _ = judged(bench_document([bench_row("SAP")], speedups=[speedup("SAP", "BulletDbvtDeferred", 7)]))
        overall = [each for each in document["published"] if each["kind"] == "overall"]
        self.assertEqual([(each["other"], each["derived_through"]) for each in overall], [("PhysxAbp", "BulletDbvtDeferred")])
        self.assertAlmostEqual(overall[0]["value"], 7 * 1.00 / 5.93)

    def test_are_compared_with_our_fastest_single_threaded_arm(self):
        rows = [bench_row("Grid", 2.0), bench_row("SAP", 1.0), bench_row("KDTree", 0.5, threads=2)]
        _, document, _ = judged(bench_document(rows, speedups=[speedup(arm, "Embree", 5) for arm in ("Grid", "SAP")]))
        self.assertEqual([each["ours"] for each in document["published"] if each["kind"] == "overall"], ["SAP"])

    def test_are_compared_with_the_fastest_arm_of_each_instruction_set(self):
        rows = [bench_row("Grid", 2.0), bench_row("SAP", 1.0), bench_row("Grid", 3.0, simd="avx2"), bench_row("SAP", 4.0, simd="avx2")]
        times = {("Grid", "avx512"): 5, ("SAP", "avx512"): 10, ("Grid", "avx2"): 4, ("SAP", "avx2"): 3}
        document = bench_document(rows, speedups=[speedup(arm, "Embree", value, simd=simd) for (arm, simd), value in times.items()],
                                  simd=("avx512", "avx2"))
        published = judged(document)[1]["published"]
        overall = [(each["ours"], each["simd"], each["goal"]) for each in published if each["kind"] == "overall"]
        self.assertEqual(overall, [("SAP", "avx512", 5), ("Grid", "avx2", 4)])
        family = {(each["ours"], each["simd"]): each["value"] for each in published if each["other"] == "BroadmarkSap"}
        self.assertEqual(family.keys(), {("SAP", "avx512"), ("SAP", "avx2")})
        self.assertAlmostEqual(family["SAP", "avx2"], 3 * 2.39 / 2.50)

    def test_are_compared_with_the_best_peer_and_with_peers_that_goals_name(self):
        rows = [bench_row("SAP", simd=simd, scene="suite-g", objects=1_000) for simd in ("avx512", "avx2")]
        speedups = [speedup("SAP", "Embree", 20, "suite-g", 1_000, simd) for simd in ("avx512", "avx2")]
        _, document, _ = judged(bench_document(rows, speedups=speedups, simd=("avx512", "avx2")))
        overall = [(each["simd"], each["other"], each["goal"]) for each in document["published"] if each["kind"] == "overall"]
        self.assertEqual(overall, [("avx512", "BroadmarkSap", 10), ("avx2", "BroadmarkSap", None), ("avx2", "PhysxAbp", 4)])

    def test_do_not_exist_for_other_cells(self):
        for scene, objects in (("suite-b", 2_000), ("planar", 10_000), ("suite-h", 1_000_000)):
            row = bench_row("SAP", scene=scene, objects=objects)
            _, document, _ = judged(bench_document([row], speedups=[speedup("SAP", "Embree", 5, scene, objects)]))
            self.assertEqual(document["published"], [])

    def test_belong_to_families_and_have_a_figure_of_the_suite(self):
        figures, families, bridges = backends.read_published(judge.DATA / "published_figures.csv")
        self.assertEqual(bridges, ["Embree", "BulletDbvtDeferred"])
        for peer, family in families.items():
            self.assertIn((peer, "suite-b", 10_000), figures)
            self.assertIn(family, ("any", "BruteForce", "Grid", "SAP", "AxisSweep", "DBVT", "Tracy", "KDTree"))


class BenchText(unittest.TestCase):
    def test_has_every_row_and_marks_missed_goals(self):
        document = bench_document(
            [bench_row("Grid"), bench_row("Peer", kind="peer", family="Grid", note="stopped by the cap of 2.0 s"),
             bench_row("Wrong", kind="peer", family="Grid", difference="step 1: other pairs")],
            [ratio("overall", "Grid", "Peer", 9.0), ratio("family", "Grid", "Peer", 2.0)])
        code, out, _ = run(["bench"], [document])
        self.assertEqual(code, 1)
        for text in ("suite-b, 10000 objects, 5.0 pairs per frame", "Peer in suite-b (10000 objects): stopped by the cap",
                     "FAILED Wrong in suite-b", "A processor, 2 cores"):
            self.assertIn(text, out)
        lines = [line.split() for line in out.splitlines()]
        self.assertIn(["overall", "Grid", "1", "Peer", "9.00", "9.00", "5.0", "met", "-"], lines)
        self.assertIn(["family", "Grid", "1", "Peer", "2.00", "2.00", "6.0", "NOT", "MET", "-"], lines)
        self.assertNotIn("simd", lines[0])

    def test_names_the_instruction_set_if_several_were_measured(self):
        document = bench_document(
            [bench_row("Grid", simd="avx2"), bench_row("Grid", 2.5, simd="sse4", difference="step 1: other pairs"),
             bench_row("Peer", kind="peer", family="Grid")],
            [ratio("simd", "Grid", "avx2", 2.5, simd="sse4")], simd=("avx2", "sse4"), cold=True)
        lines = [line.split() for line in run(["bench"], [document])[1].splitlines()]
        self.assertEqual(lines[0][:5], ["family", "arm", "simd", "thr", "frames"])
        self.assertIn(["Grid", "Grid", "sse4", "1", "10", "2.5000", "2.5000", "2.5000", "2.5000", "-", "-"], lines)
        self.assertIn(["Grid", "Peer", "-", "1", "10", "1.0000", "1.0000", "1.0000", "1.0000", "-", "-"], lines)
        self.assertIn("FAILED Grid with sse4 in suite-b (10000 objects): step 1: other pairs".split(), lines)
        self.assertTrue(any("cold" in line for line in lines))

    def test_has_comparisons_beside_their_row(self):
        document = bench_document([bench_row("Grid", simd="avx2"), bench_row("Grid", simd="sse4")],
                                  [ratio("simd", "Grid", "avx2", 1.5, simd="sse4")], simd=("avx2", "sse4"))
        lines = [line.split() for line in run(["bench"], [document])[1].splitlines()]
        self.assertEqual([line for line in lines if line[:1] == ["simd"]],
                         [["simd", "Grid", "sse4", "1", "avx2", "1.50", "1.50", "1.0-2.0", "met", "-"]])

    def test_lists_published_figures_after_measured_ones(self):
        document = bench_document([bench_row("SAP"), bench_row("Grid")],
                                  [ratio("overall", "SAP", "Peer", 9.0), ratio("family", "SAP", "Peer", 8.0),
                                   ratio("family", "Grid", "Peer", 7.0)],
                                  [speedup("SAP", "Embree", 50), speedup("Grid", "Embree", 50)])
        ratios = backends.BenchJudge(document, common.read_goals(judge.DATA / "goals.toml"),
                                  backends.read_published(judge.DATA / "published_figures.csv")).ratios()
        self.assertEqual([(each["kind"], each["ours"], each["other"]) for each in ratios],
                         [("overall", "SAP", "Peer"), ("overall", "SAP", "PhysxAbp"), ("family", "SAP", "Peer"),
                          ("family", "SAP", "BroadmarkSap"), ("family", "Grid", "Peer"), ("family", "Grid", "BroadmarkGrid")])


# Decisions ----------------------------------------------------------------------------------------------------------------


CELLS = {"stationary": "brownian-1000-1", "changing": "waves-3000-2", "resonant": "waves-3000-2"}
LIST = ("# a comment\n\nbrownian 1000 3000 1 15m stationary # the paper's\n"
        "waves 3000 3600 2 12m changing\nwaves 3000 3600 2 90s resonant\n")
PRIORS = ("none", "right", "wrong", "class", "scenes")
PASS_NS = {"stationary": 900_000_000_000, "changing": 720_000_000_000, "resonant": 90_000_000_000}


def replay_row(category, policy, priors, **figures):
    good = {"none": -0.08 if category == "changing" else 0.01, "right": 0.005, "wrong": 0.03, "class": 0.008, "scenes": 0.004}[priors]
    return {"costs": f"traces/{CELLS[category]}.costs", "policy": policy, "priors": priors, "pass_ns": PASS_NS[category],
            "regret_best_fixed": 0.2 if policy == "paper" else good, "ci95": [0.0, 0.02], "regret_after_start": 0.005,
            "headroom": 0.1, "headroom_captured": 0.8, "switches": 1.0, "active_share": 0.9, "bail_outs": 0.0} | figures


class Replays:
    """Documents of a policy that reaches every goal, which tests change."""

    def __init__(self):
        scenes = [{"costs": f"traces/{cell}.costs", "control_regret": -0.004} for cell in CELLS.values()]
        self.documents = [{"command": "replay", "seeds": 30, "scenes": scenes, "rows": []} for _ in PRIORS]
        for document, priors in zip(self.documents, PRIORS):
            for category in CELLS:
                for policy in ("default", "paper") if priors == "none" else ("default",):
                    document["rows"].append(replay_row(category, policy, priors))
        self.documents.append({"command": "decision_tick_bench", "rows": [
            {"policy": "default", "arms": 7, "p99_ms": 0.02}, {"policy": "default", "arms": 32, "p99_ms": 0.2}]})

    def change(self, category, priors, policy="default", **figures):
        for document in self.documents[:-1]:
            for row in document["rows"]:
                if (row["pass_ns"], row["priors"], row["policy"]) == (PASS_NS[category], priors, policy):
                    row.update(figures)
        return self

    def judge(self, words=()):
        with tempfile.TemporaryDirectory() as folder:
            cells = pathlib.Path(folder) / "cells.txt"
            cells.write_text(LIST)
            return run(["decisions", "--cells", str(cells), *words], copy.deepcopy(self.documents))

    def missed(self):
        code, out, err = self.judge(["--json"])
        assert code in (0, 1), err
        goals = json.loads(out)["goals"]
        names = [goal["goal"] for goal in goals if goal["reached"] is not None and not goal["met"]]
        assert code == (1 if names else 0)
        return names


class DecisionGoals(unittest.TestCase):
    def test_are_all_met_by_a_policy_that_reaches_every_limit(self):
        self.assertEqual(Replays().missed(), [])

    def test_are_each_missed_by_their_own_figure(self):
        for category, priors, figures, goal in (
            ("stationary", "none", {"regret_after_start": 0.0101}, "stationary, after start-up"),
            ("stationary", "right", {"regret_best_fixed": 0.0051}, "stationary, with a same-class prior"),
            ("stationary", "class", {"regret_best_fixed": 0.0101}, "stationary, with a prior of another class of machines"),
            ("stationary", "scenes", {"regret_best_fixed": 0.0051}, "stationary: regret of a cold start ÷ that of a new scene with priors of other scenes"),
            ("changing", "none", {"regret_best_fixed": 0.0}, "changing: better than the best fixed arm"),
            ("changing", "none", {"headroom_captured": 0.49}, "changing: share of the oracle's headroom"),
            ("resonant", "none", {"regret_best_fixed": 0.041}, "regimes up to the cooldown"),
            ("stationary", "wrong", {"regret_best_fixed": 0.041}, "wrong prior"),
            ("resonant", "wrong", {"bail_outs": 0.1}, "bail-outs with the shadow lane"),
        ):
            self.assertEqual(Replays().change(category, priors, **figures).missed(), [goal])
        cold = Replays().change("stationary", "none", regret_best_fixed=0.0251)
        self.assertEqual(cold.change("stationary", "none", "paper", regret_best_fixed=0.5).missed(),
                         ["stationary, with the cold start"])
        self.assertEqual(Replays().change("stationary", "none", "paper", regret_best_fixed=0.09).missed(),
                         ["stationary: regret of paper ÷ that of the policy"])

    def test_of_a_decisions_time_are_missed_at_the_limit(self):
        replays = Replays()
        replays.documents[-1]["rows"][1]["p99_ms"] = 1.0
        self.assertEqual(replays.missed(), ["a decision, p99 with 32 arms"])

    def test_leave_out_changing_scenes_without_headroom(self):
        self.assertEqual(Replays().change("changing", "none", headroom=0.04, regret_best_fixed=0.02).missed(), [])

    def test_are_judged_by_the_worst_cell_which_is_listed_first(self):
        goals = json.loads(Replays().change("resonant", "wrong", regret_best_fixed=0.05).judge(["--json"])[1])["goals"]
        goal = next(each for each in goals if each["goal"] == "wrong prior")
        self.assertEqual(goal["reached"], 0.05)
        self.assertEqual([cell["met"] for cell in goal["cells"]], [False, True, True])

    def test_a_policy_without_regret_is_infinitely_better_than_paper(self):
        code, out, _ = Replays().change("stationary", "none", regret_best_fixed=-0.01).judge()
        self.assertEqual(code, 0)
        self.assertIn("none left", out)


def beside(goal, met):
    """Returns a figure just inside or outside the goal's limit."""
    word, limit = common.limit_of(goal)
    step = max(0.1 * limit, 0.01)
    return limit + step if (word == "at_least") == met else limit - step


class DaemonGoals(unittest.TestCase):
    def setUp(self):
        self.goals = common.read_goals(judge.DATA / "goals.toml")["daemon"]
        loads = {}
        for goal in self.goals["goal"]:
            loads.setdefault(goal["load"], {"more": 7.0})[goal["figure"]] = beside(goal, True)
        self.document = {"command": "daemon_load", "streams": self.goals["streams"], "sources": self.goals["sources"],
                         "loads": [{"name": name, "title": name, "figures": figures} for name, figures in loads.items()]}

    def test_all_are_met(self):
        code, out, _ = run(["daemon", "--json"], [self.document])
        self.assertEqual(code, 0)
        rows = json.loads(out)["figures"]
        self.assertEqual(sum(row["met"] is True for row in rows), len(self.goals["goal"]))
        self.assertEqual(sum(row["met"] is None for row in rows), len(self.document["loads"]))

    def test_each_can_be_missed(self):
        for goal in self.goals["goal"]:
            document = copy.deepcopy(self.document)
            figures = next(load["figures"] for load in document["loads"] if load["name"] == goal["load"])
            figures[goal["figure"]] = beside(goal, False)
            code, out, _ = run(["daemon"], [document])
            self.assertEqual((code, out.count("NOT MET")), (1, 1), goal)

    def test_a_missing_figure_is_an_error(self):
        fewer_streams = self.document | {"streams": 100}
        no_load = self.document | {"loads": self.document["loads"][1:]}
        no_figure = copy.deepcopy(self.document)
        no_figure["loads"][0]["figures"] = {"more": 7.0}
        for document in (fewer_streams, no_load, no_figure, self.document | {"loads": []}):
            code, out, err = run(["daemon"], [document])
            self.assertEqual((code, out), (2, ""), err)


class Proxies(unittest.TestCase):
    """Each goal can be met and missed, and must have its figure."""

    def setUp(self):
        self.goals = common.read_goals(judge.DATA / "goals.toml")["proxies"]
        self.documents = {program: {"command": program, "save_ms": 0.1} for program in ("proxy_ratios_bench", "proxy_steps_bench")}
        for goal in self.goals:
            self.documents[goal["by"]][goal["figure"]] = beside(goal, True)

    def test_all_can_be_met(self):
        for document in self.documents.values():
            code, out, _ = run(["proxies"], [document])
            self.assertEqual((code, out.count(" met"), "NOT" in out), (0, len(document) - 2, False))
            code, out, _ = run(["proxies", "--json"], [document])
            self.assertEqual([row["met"] for row in json.loads(out)["figures"]], [None] + [True] * (len(document) - 2))

    def test_each_can_be_missed(self):
        for goal in self.goals:
            code, out, _ = run(["proxies"], [self.documents[goal["by"]] | {goal["figure"]: beside(goal, False)}])
            self.assertEqual((code, out.count("NOT MET")), (1, 1), goal)

    def test_a_missing_figure_is_an_error(self):
        for document in ({"command": "proxy_steps_bench"}, self.documents["proxy_ratios_bench"] | {"command": "bench"}):
            code, out, err = run(["proxies"], [document])
            self.assertEqual((code, out), (2, ""), err)


class Incomplete(unittest.TestCase):
    """Missing input is an error, never a met goal."""

    def check(self, replays, *said):
        code, out, err = replays.judge()
        self.assertEqual((code, out), (2, ""))
        for text in said:
            self.assertIn(text, err)

    def test_a_cell_without_a_row_of_any_prior(self):
        for number, priors in enumerate(PRIORS):
            replays = Replays()
            rows = replays.documents[number]["rows"]
            rows[:] = [row for row in rows if row["pass_ns"] != PASS_NS["resonant"]]
            self.check(replays, "waves-3000-2", f"priors {priors}", "90s")

    def test_no_row_of_paper(self):
        replays = Replays()
        replays.documents[0]["rows"] = [row for row in replays.documents[0]["rows"] if row["policy"] != "paper"]
        self.check(replays, "policy paper")

    def test_no_time_of_a_decision(self):
        replays = Replays()
        del replays.documents[-1]
        self.check(replays, "time of a decision")

    def test_an_unknown_figure(self):
        self.check(Replays().change("changing", "none", headroom_captured=None), "waves-3000-2 has no headroom_captured")

    def test_a_row_without_a_column(self):
        replays = Replays()
        del replays.documents[0]["rows"][0]["headroom"]
        self.check(replays, "'headroom'")

    def test_documents_of_other_commands_and_broken_ones(self):
        for document in ("{", "[]", {"command": "trace", "rows": []}, bench_document([])):
            self.assertEqual(run(["bench"], [document])[0], 2, document)

    def test_lists_with_invalid_lines(self):
        for text in ("brownian 1000 3000 1 15m", "brownian 1000 3000 1 15m calm", "brownian 1000 3000 1 15 stationary", "# none"):
            with tempfile.TemporaryDirectory() as folder:
                path = pathlib.Path(folder) / "cells.txt"
                path.write_text(text)
                with self.assertRaises(common.InputError):
                    decisions.read_cells(path)

    def test_goals_without_a_limit(self):
        with self.assertRaises(common.InputError):
            common.limit_of({"goal": "nothing"})

    def test_goals_with_two_limits_instead_of_one(self):
        with self.assertRaises(common.InputError):
            common.limit_of({"at_least": 1.0, "at_most": 2.0})

    def test_documents_that_name_no_instruction_set(self):
        document = bench_document([bench_row("Grid")])
        del document["simd"]
        self.assertEqual(run(["bench"], [document])[0], 2)


if __name__ == "__main__":
    unittest.main()
