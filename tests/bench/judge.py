#!/usr/bin/env python3
"""Holds what `sweepstake bench` and `sweepstake replay` measured against the goals.

Reads documents that these commands print with --json, the goals of data/goals.toml and the times that were published or
measured elsewhere, data/published_figures.csv. Needs Python 3.11 and nothing else. Exit code: 0 every goal is met, 1 a
goal is missed, 2 the input is wrong or incomplete: a cell without its rows is never taken for one that meets its goal.
"""

import argparse
import csv
import fnmatch
import json
import math
import pathlib
import sys
import tomllib

DATA = pathlib.Path(__file__).resolve().parent / "data"
LIMITS = ("at_least", "at_most", "below")


class InputError(Exception):
    """What a user gave cannot be judged; the message says why."""


# Text --------------------------------------------------------------------------------------------------------------------


def percent(ratio):
    text = f"{100 * ratio:.2f}"
    text = "0.00" if text == "-0.00" else text
    return ("" if text.startswith("-") else "+") + text + "%"


def is_number(cell):
    return cell != "" and not cell.strip("+-.0123456789e%")


def table(header, rows):
    """Aligned columns, numbers to the right; a row of one cell is a title. The layout of engine_client/cli/io/text_table.h."""
    body = [row for row in rows if len(row) == len(header)]
    widths = [max(len(row[i]) for row in [header, *body]) for i in range(len(header))]
    right = [len(rows) > 0 and all(is_number(row[i]) for row in body) for i in range(len(header))]
    lines = []
    for row in [header, *rows]:
        if len(row) < len(header):
            lines += ["", row[0]]
            continue
        cells = [cell.rjust(width) if to_right else cell.ljust(width) for cell, width, to_right in zip(row, widths, right)]
        lines.append("  ".join(cells).rstrip())
    return "\n".join(lines) + "\n"


def or_dash(value, text=str):
    return "-" if value is None else text(value)


# Goals -------------------------------------------------------------------------------------------------------------------


def limit_of(goal):
    """The word and the number of a goal's limit."""
    given = [word for word in LIMITS if word in goal]
    if len(given) != 1:
        raise InputError(f"a goal has to have one of {', '.join(LIMITS)}: {goal}")
    return given[0], goal[given[0]]


def meets(goal, value):
    word, limit = limit_of(goal)
    return value >= limit if word == "at_least" else value <= limit if word == "at_most" else value < limit


def read_goals(path):
    with open(path, "rb") as file:
        goals = tomllib.load(file)
    for goal in goals["bench"] + goals["decisions"]:
        limit_of(goal)
    return goals


# `sweepstake bench` ------------------------------------------------------------------------------------------------------


def read_published(path):
    """Milliseconds by (peer, scene, objects), and the family that each peer without a package is compared with."""
    figures, families = {}, {}
    with open(path, newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            figures[row["peer"], row["scene"], int(row["objects"])] = float(row["ms_median"])
            families[row["peer"]] = row["family"]
    bridges = [peer for peer, family in families.items() if family == "bridge"]
    return figures, {peer: family for peer, family in families.items() if family != "bridge"}, bridges


def cell_of(row):
    return row["scene"], row["objects"]


def bench_goal(goals, ratio):
    """The number that a comparison is held against, or None, and whether it is reached."""
    def fits(goal):
        return (
            goal["compared"] == ratio["kind"]
            and goal.get("family", ratio["family"]) == ratio["family"]
            and goal.get("with", ratio["other"]) == ratio["other"]
            and goal.get("threads", ratio["threads"]) == ratio["threads"]
            and goal.get("min_objects", 0) <= ratio["objects"]
            and any(fnmatch.fnmatchcase(ratio["scene"], each) for each in goal.get("scenes", ["*"]))
            and not any(fnmatch.fnmatchcase(ratio["scene"], each) for each in goal.get("not_scenes", []))
        )

    goal = next((each for each in goals["bench"] if fits(each)), None)
    return (None, None) if goal is None else (limit_of(goal)[1], meets(goal, ratio["value"]))


class BenchJudge:
    """The comparisons of one document, in the order of its cells and arms, each with its goal."""

    def __init__(self, document, goals, published):
        if document.get("command") != "bench" or not document.get("rows"):
            raise InputError("this is no document of `sweepstake bench --json` with rows")
        self.document, self.goals = document, goals
        self.figures, self.published_families, self.bridges = published
        self.speedups = {(cell_of(row), row["arm"], row["peer"]): row for row in document.get("speedups", [])}

    def ratios(self):
        ratios = []
        for cell in dict.fromkeys(cell_of(row) for row in self.document["rows"]):
            ratios += self.of_cell(cell)
        for ratio in ratios:
            ratio["goal"], ratio["met"] = bench_goal(self.goals, ratio)
        return ratios

    def of_cell(self, cell):
        measured = [self.plain(ratio) for ratio in self.document["ratios"] if cell_of(ratio) == cell]
        overall = [ratio for ratio in measured if ratio["kind"] == "overall"]
        at = 1 if overall and overall[0]["threads"] == 1 else 0
        ratios = overall[:at] + self.published_overall(cell) + overall[at:]
        for row in self.document["rows"]:
            if cell_of(row) != cell or row["kind"] != "arm" or not counts(row):
                continue
            own = [each for each in measured if each["kind"] != "overall" and own_key(each) == (row["arm"], row["threads"])]
            family = [each for each in own if each["kind"] == "family"]
            rest = [each for each in own if each["kind"] != "family"]
            ratios += family + self.published_family(row) + rest + self.memory(row)
        return ratios

    @staticmethod
    def plain(ratio):
        return {key: value for key, value in ratio.items() if key not in ("goal", "met")}

    def published_family(self, row):
        if row["threads"] != 1:
            return []
        peers = [peer for peer, family in self.published_families.items() if family == row["family"]]
        return [ratio for ratio in (self.derived("family", row, peer) for peer in peers) if ratio]

    def published_overall(self, cell):
        """Our fastest arm against the best of all peers that are published."""
        arms = [row for row in self.document["rows"]
                if cell_of(row) == cell and row["kind"] == "arm" and row["threads"] == 1 and counts(row)]
        if not arms:
            return []
        fastest = min(arms, key=lambda row: row["ms_median"])
        ratios = [ratio for ratio in (self.derived("overall", fastest, peer) for peer in self.published_families) if ratio]
        return [min(ratios, key=lambda ratio: ratio["value"])] if ratios else []

    def derived(self, kind, row, peer):
        """What `peer` would take here: a bridge's time here × the quotient of their published figures of the cell."""
        for bridge in self.bridges:
            speedup = self.speedups.get((cell_of(row), row["arm"], bridge))
            figure, of_bridge = (self.figures.get((each, *cell_of(row))) for each in (peer, bridge))
            if speedup is None or figure is None or of_bridge is None:
                continue
            quotient = figure / of_bridge
            return ratio_row(row, kind, peer, speedup["median"] * quotient, speedup["mean"] * quotient) | {
                "derived_through": bridge}
        return None

    def memory(self, row):
        goal = self.goals["memory"]
        held = row.get("bytes_with_pairs")
        if cell_of(row) != (goal["scene"], goal["objects"]) or held is None:
            return []
        return [ratio_row(row, "memory", f"{goal['bytes'] / 1e6:.0f} MB", held / goal["bytes"], None)]


def counts(row):
    return row["frames"] > 0 and "difference" not in row


def own_key(ratio):
    return ratio["ours"], ratio["threads"]


def ratio_row(row, kind, other, value, value_mean):
    return {"scene": row["scene"], "objects": row["objects"], "threads": row["threads"], "kind": kind,
            "family": row["family"], "ours": row["arm"], "other": other, "value": value, "value_mean": value_mean}


def bench_json(document, ratios):
    """The document with its goals: `goals` holds the comparisons measured here, `published` those with figures from elsewhere."""
    measured = [ratio for ratio in ratios if "derived_through" not in ratio and ratio["goal"] is not None]
    derived = [ratio for ratio in ratios if "derived_through" in ratio]
    return document | {"goals": measured, "published": derived}


def title_of(cell):
    return f"{cell[0]}, {cell[1]} objects"


def bench_rows_text(document):
    peers = any(row["kind"] == "peer" for row in document["rows"])
    header = ["arm", "thr", "ms_median", "ms_mean", "ms_min", "ms_p99", "aabb_checks", "bytes"]
    if peers:
        header = ["family", "arm", "thr", "frames", *header[2:]]
    rows, before = [], None
    for row in document["rows"]:
        if cell_of(row) != before:
            before = cell_of(row)
            arm = next((each for each in document["rows"] if cell_of(each) == before and each["kind"] == "arm"), None)
            pairs = "" if arm is None else f", {arm['pairs_mean']:.1f} pairs per frame"
            rows.append([title_of(before) + pairs])
        cells = [row["arm"], str(row["threads"]), *(f"{row[key]:.4f}" for key in ("ms_median", "ms_mean", "ms_min", "ms_p99")),
                 or_dash(row["aabb_checks_mean"], "{:.0f}".format), or_dash(row["bytes"])]
        rows.append([row["family"], *cells[:2], str(row["frames"]), *cells[2:]] if peers else cells)
    return table(header, rows)


def notes_text(document):
    text = ""
    for row in document["rows"]:
        where = f"{row['arm']} in {row['scene']} ({row['objects']} objects): "
        if "note" in row:
            text += where + row["note"] + "\n"
        if "difference" in row:
            text += "FAILED " + where + row["difference"] + "\n"
    return text


def ratios_text(ratios):
    rows, before = [], None
    for ratio in ratios:
        if cell_of(ratio) != before:
            before = cell_of(ratio)
            rows.append([title_of(before)])
        result = "-" if ratio["goal"] is None else "met" if ratio["met"] else "NOT MET"
        rows.append([ratio["kind"], ratio["ours"], str(ratio["threads"]), ratio["other"], f"{ratio['value']:.2f}",
                     or_dash(ratio["value_mean"], "{:.2f}".format), or_dash(ratio["goal"], "{:.1f}".format), result,
                     ratio.get("derived_through", "-")])
    return table(["compared", "ours", "thr", "with", "ratio", "mean", "goal", "result", "through"], rows)


def machine_text(machine):
    text = f"{machine['cpu']}, {machine['cores']} cores, {machine['compiler']}, {machine['simd']}, {machine['date']}\n"
    text += ", ".join(f"{name} {version}" for name, version in machine["libraries"].items()) + "\n"
    return text + "".join(f"Left out: {absent}\n" for absent in machine["absent_peers"])


def bench_text(document, ratios):
    text = bench_rows_text(document) + notes_text(document)
    if ratios:
        text += "\n" + ratios_text(ratios)
    if any(row["kind"] == "peer" for row in document["rows"]):
        text += "\n" + machine_text(document["machine"])
    return text


def judge_bench(options):
    document = read_json(options.document)
    ratios = BenchJudge(document, read_goals(options.goals), read_published(options.published)).ratios()
    print_result(bench_json(document, ratios) if options.json else bench_text(document, ratios))
    return all(ratio["met"] is not False for ratio in ratios)


# `sweepstake replay` -----------------------------------------------------------------------------------------------------


UNIT_NS = {"ms": 1e6, "s": 1e9, "m": 60e9, "h": 3600e9}
CATEGORIES = ("stationary", "changing", "resonant")


def duration_ns(text):
    number = text.rstrip("hms")
    unit = UNIT_NS.get(text[len(number):])
    if unit is None:
        raise InputError(f"'{text}' is no duration: give a number and ms, s, m or h")
    return round(float(number) * unit)


def read_cells(path):
    """The cells of a list: lines of scene, objects, frames, seed, pass and category (data/tuning_scenes.txt)."""
    cells = []
    for number, line in enumerate(pathlib.Path(path).read_text(encoding="utf-8").splitlines(), 1):
        words = line.split("#")[0].split()
        if not words:
            continue
        if len(words) != 6 or words[5] not in CATEGORIES:
            raise InputError(f"{path}: line {number} is no line of scene, objects, frames, seed, pass and "
                             f"{', '.join(CATEGORIES)}")
        name = f"{pathlib.PurePath(words[0]).stem}-{words[1]}-{words[3]}"
        cells.append({"cell": name, "category": words[5], "pass": words[4], "pass_ns": duration_ns(words[4])})
    if not cells:
        raise InputError(f"{path}: there is no scene in the list")
    return cells


class Replays:
    """The rows of several replay documents, found by cell, policy and priors."""

    def __init__(self, documents):
        self.rows, self.controls, self.decisions, self.policies, self.seeds = {}, {}, [], [], 0
        for document in documents:
            if document.get("command") == "decision_tick_bench":
                self.decisions += document["rows"]
            elif document.get("command") == "replay" and "scenes" in document:
                self.add(document)
            else:
                raise InputError("a document is neither of `sweepstake replay --json` nor of `decision_tick_bench --json`")
        if not self.rows:
            raise InputError("there is no document of `sweepstake replay --json`")

    def add(self, document):
        self.seeds = document["seeds"]
        for scene in document["scenes"]:
            self.controls[pathlib.PurePath(scene["costs"]).stem] = scene["control_regret"]
        for row in document["rows"]:
            self.rows[pathlib.PurePath(row["costs"]).stem, row["pass_ns"], row["policy"], row["priors"]] = row
            if row["policy"] not in self.policies:
                self.policies.append(row["policy"])

    def row(self, cell, policy, priors):
        row = self.rows.get((cell["cell"], cell["pass_ns"], policy, priors))
        if row is None:
            raise InputError(f"there is no row of policy {policy} with priors {priors} in {cell['cell']} "
                             f"at a pass of {cell['pass']}")
        return row

    def decision(self, policy, arms):
        rows = [row for row in self.decisions if (row["policy"], row["arms"]) == (policy, arms)]
        if not rows:
            raise InputError(f"there is no time of a decision of {policy} with {arms} arms")
        return rows[0]["p99_ms"]


def figure_of(goal, cell, policy, replays):
    """What the policy reached in the cell; None: the goal does not judge it."""
    rows = [replays.row(cell, policy, priors) for priors in goal["priors"]]
    if goal.get("category", cell["category"]) != cell["category"] or rows[0]["headroom"] < goal.get("min_headroom", -math.inf):
        return None
    values = [row[goal["figure"]] for row in rows]
    if None in values:
        raise InputError(f"{cell['cell']} has no {goal['figure']}")
    return sum(values)


def judged_cells(goal, cells, policy, replays):
    """The cells behind a goal, the worst first."""
    values = [(cell["cell"], figure_of(goal, cell, policy, replays)) for cell in cells]
    judged = [{"cell": name, "value": value, "met": meets(goal, value)} for name, value in values if value is not None]
    return sorted(judged, key=lambda each: each["value"], reverse="at_least" not in goal)


def against_peer(goal, cells, policy, replays):
    own, peer = ([figure_of(goal, cell, each, replays) for cell in cells] for each in (policy, goal["peer"]))
    own, peer = (sum(value for value in values if value is not None) for values in (own, peer))
    if not any(cell["category"] == goal.get("category", cell["category"]) for cell in cells):
        return None
    return peer / own if own > 0 else math.inf


def judge_goal(goal, cells, policy, replays):
    behind = []
    if "decision_arms" in goal:
        reached = replays.decision(policy, goal["decision_arms"])
    elif "peer" in goal:
        reached = against_peer(goal, cells, policy, replays)
    else:
        behind = judged_cells(goal, cells, policy, replays)
        reached = behind[0]["value"] if behind else None
    return {"goal": goal["goal"], "limit": limit_of(goal)[1], "limit_text": limit_text(goal), "unit": goal["unit"],
            "reached": reached, "met": reached is not None and meets(goal, reached), "cells": behind}


def figure_text(unit, value):
    if unit == "times":
        return "none left" if math.isinf(value) else f"{value:.1f}x"
    return {"percent": percent, "count": "{:.2f}".format, "milliseconds": "{:.3f} ms".format}[unit](value)


def limit_text(goal):
    word, limit = limit_of(goal)
    return word.replace("_", " ") + " " + figure_text(goal["unit"], limit)


def goals_text(goals):
    rows = []
    for goal in goals:
        met = sum(cell["met"] for cell in goal["cells"])
        cells = f"{met} of {len(goal['cells'])}, worst {goal['cells'][0]['cell']}" if goal["cells"] else "-"
        result = "nothing to judge" if goal["reached"] is None else "met" if goal["met"] else "NOT MET"
        reached = or_dash(goal["reached"], lambda value, unit=goal["unit"]: figure_text(unit, value))
        rows.append([goal["goal"], goal["limit_text"], reached, cells, result])
    return table(["goal", "limit", "reached", "cells", "result"], rows)


def cells_text(cells, policy, replays):
    rows = []
    for cell in cells:
        row = replays.row(cell, policy, "none")
        prior, wrong_prior, paper = (replays.row(cell, each, priors)["regret_best_fixed"]
                                     for each, priors in ((policy, "right"), (policy, "wrong"), ("paper", "none")))
        rows.append([cell["cell"], cell["category"], percent(abs(replays.controls[cell["cell"]])), percent(row["headroom"]),
                     percent(row["regret_best_fixed"]), percent(row["ci95"][0]) + " to " + percent(row["ci95"][1]),
                     percent(row["regret_after_start"]), percent(prior), percent(wrong_prior),
                     or_dash(row["headroom_captured"], lambda ratio: f"{100 * ratio:.0f}%"), f"{row['switches']:.1f}",
                     f"{row['active_share']:.2f}", or_dash(row["bail_outs"], "{:.2f}".format), percent(paper)])
    return table(["cell", "category", "floor", "headroom", "regret", "ci95", "after_start", "prior", "wrong_prior", "captured",
                  "switches", "share", "bail_outs", "paper"], rows)


def mean(values):
    return sum(values) / len(values)


def policies_text(cells, replays):
    rows = []
    for policy in replays.policies:
        for category in CATEGORIES:
            own = [replays.row(cell, policy, "none") for cell in cells if cell["category"] == category]
            if own:
                regret = [row["regret_best_fixed"] for row in own]
                rows.append([policy, category, str(len(own)), percent(mean(regret)), percent(max(regret)),
                             percent(mean([row["regret_after_start"] for row in own])),
                             f"{mean([row['switches'] for row in own]):.1f}",
                             f"{mean([row['bail_outs'] or 0 for row in own]):.2f}"])
    return table(["policy", "category", "cells", "regret", "worst", "after_start", "switches", "bail_outs"], rows)


def decisions_text(goals, cells, policy, replays):
    return (f"Policy {policy}, {replays.seeds} seeds in each of {len(cells)} cells; regret is frame time against the best "
            f"fixed arm's.\n\n{goals_text(goals)}\n{cells_text(cells, policy, replays)}\n"
            "floor: the same arm measured twice. headroom: of the best sequence of arms that pays for\n"
            "its switches; captured: how much of it was reached. prior: with what another seed's game\nhad learnt.\n\n"
            + policies_text(cells, replays))


def decisions_json(goals, cells, policy, replays):
    return {"command": "replay", "policy": policy, "seeds": replays.seeds,
            "goals": [goal | {"reached": None if goal["reached"] == math.inf else goal["reached"]} for goal in goals],
            "cells": [{"cell": cell["cell"], "category": cell["category"], "pass_ns": cell["pass_ns"],
                       "control_regret": replays.controls[cell["cell"]],
                       "regret_right_prior": replays.row(cell, policy, "right")["regret_best_fixed"],
                       "regret_wrong_prior": replays.row(cell, policy, "wrong")["regret_best_fixed"]} for cell in cells],
            "rows": [replays.row(cell, each, "none") for cell in cells for each in replays.policies]}


def judge_decisions(options):
    cells = read_cells(options.cells)
    replays = Replays([read_json(path) for path in options.documents])
    policy = options.policy or replays.policies[0]
    goals = [judge_goal(goal, cells, policy, replays) for goal in read_goals(options.goals)["decisions"]]
    write = decisions_json if options.json else decisions_text
    print_result(write(goals, cells, policy, replays))
    return all(goal["met"] or goal["reached"] is None for goal in goals)


# Command line ------------------------------------------------------------------------------------------------------------


def read_json(path):
    try:
        with sys.stdin if path == "-" else open(path, encoding="utf-8") as file:
            document = json.load(file)
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: {error}") from error
    if not isinstance(document, dict):
        raise InputError(f"{path} holds no JSON object")
    return document


def print_result(result):
    print(result if isinstance(result, str) else json.dumps(result, indent=2, ensure_ascii=False) + "\n", end="")


def parse(words):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="examples:\n"
        "  sweepstake bench --scene suite-b --objects 1000,10000 --peers --json | tests/bench/judge.py bench\n"
        "  tests/bench/judge.py bench --json build/bench/suite.json\n"
        "  tests/bench/judge.py decisions --cells tests/bench/data/held_out_scenes.txt none.json right.json wrong.json time.json\n"
        "tests/bench/run.sh and tests/bench/decisions.sh measure and call it.")
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    bench = commands.add_parser("bench", help="backends against peers: the document of `sweepstake bench --peers --json`")
    bench.add_argument("document", nargs="?", default="-", help="a file, or - for stdin (the default)")
    bench.add_argument("--published", default=DATA / "published_figures.csv", metavar="FILE.csv",
                       help="times measured elsewhere (default: %(default)s)")
    bench.set_defaults(judge=judge_bench)
    decisions = commands.add_parser("decisions", help="the policy of AI Decides on replayed traces")
    decisions.add_argument("documents", nargs="+", metavar="document",
                           help="of `sweepstake replay --json` with --priors none, right and wrong, and of "
                           "`decision_tick_bench --json`")
    decisions.add_argument("--cells", required=True, metavar="LIST.txt", help="the scenes, one in a line")
    decisions.add_argument("--policy", help="the judged one (default: the first of the first document)")
    decisions.set_defaults(judge=judge_decisions)
    for command in (bench, decisions):
        command.add_argument("--goals", default=DATA / "goals.toml", metavar="FILE.toml", help="(default: %(default)s)")
        command.add_argument("--json", action="store_true", help="one JSON document on stdout")
    return parser.parse_args(words)


def main(words):
    options = parse(words)
    try:
        return 0 if options.judge(options) else 1
    except (InputError, OSError, tomllib.TOMLDecodeError) as error:
        print(f"judge.py: {error}", file=sys.stderr)
    except (KeyError, TypeError) as error:
        print(f"judge.py: a document lacks {error}; it has to be one of this version's programs", file=sys.stderr)
    return 2


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
