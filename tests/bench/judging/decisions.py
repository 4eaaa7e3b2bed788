"""The policy of AI Decides: compares rows of `sweepstake-lab replay --json` with its goals."""

import math
import pathlib

from judging.common import InputError, limit_of, meets, or_dash, percent, table

UNIT_NS = {"ms": 1e6, "s": 1e9, "m": 60e9, "h": 3600e9}
CATEGORIES = ("stationary", "changing", "resonant")
PRIORS = ("right", "wrong", "class", "scenes")


def duration_ns(text):
    number = text.rstrip("hms")
    unit = UNIT_NS.get(text[len(number):])
    if unit is None:
        raise InputError(f"'{text}' is not a duration: give a number and ms, s, m or h")
    return round(float(number) * unit)


def read_scenes(path):
    """Reads a list: scene, objects, frames, seed, pass and category of each line (data/tuning_scenes.txt), and the cell's name."""
    scenes = []
    for number, line in enumerate(pathlib.Path(path).read_text(encoding="utf-8").splitlines(), 1):
        words = line.split("#")[0].split()
        if not words:
            continue
        if len(words) != 6 or words[5] not in CATEGORIES or not words[2].isdigit():
            raise InputError(f"{path}: line {number} must be scene, objects, frames, seed, pass and "
                             f"{', '.join(CATEGORIES)}")
        scene = pathlib.PurePath(words[0]).stem
        scenes.append({"cell": f"{scene}-{words[1]}-{words[3]}", "scene": scene, "frames": int(words[2]), "pass": words[4],
                       "category": words[5]})
    if not scenes:
        raise InputError(f"{path}: the list has no scene")
    return scenes


def read_cells(path):
    """Returns the cells of a list."""
    return [{"cell": scene["cell"], "category": scene["category"], "pass": scene["pass"], "pass_ns": duration_ns(scene["pass"])}
            for scene in read_scenes(path)]


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
                raise InputError("a document is neither from `sweepstake-lab replay --json` nor from `decision_tick_bench --json`")
        if not self.rows:
            raise InputError("a document of `sweepstake-lab replay --json` is missing")

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
            raise InputError(f"a row is missing: policy {policy}, priors {priors}, {cell['cell']} "
                             f"at a pass of {cell['pass']}")
        return row

    def decision(self, policy, arms):
        rows = [row for row in self.decisions if (row["policy"], row["arms"]) == (policy, arms)]
        if not rows:
            raise InputError(f"the time of a decision of {policy} with {arms} arms is missing")
        return rows[0]["p99_ms"]


def figure_of(goal, cell, policy, replays, priors="priors"):
    """Returns the policy's figure in the cell; None if the goal does not judge the cell."""
    rows = [replays.row(cell, policy, each) for each in goal[priors]]
    if goal.get("category", cell["category"]) != cell["category"] or rows[0]["headroom"] < goal.get("min_headroom", -math.inf):
        return None
    values = [row[goal["figure"]] for row in rows]
    if None in values:
        raise InputError(f"{cell['cell']} has no {goal['figure']}")
    return sum(values)


def judged_cells(goal, cells, policy, replays):
    """Returns the cells of a goal, the worst first."""
    values = [(cell["cell"], figure_of(goal, cell, policy, replays)) for cell in cells]
    judged = [{"cell": name, "value": value, "met": meets(goal, value)} for name, value in values if value is not None]
    return sorted(judged, key=lambda each: each["value"], reverse="at_least" not in goal)


def against_peer(goal, cells, policy, replays):
    own = [figure_of(goal, cell, policy, replays) for cell in cells]
    peer = [figure_of(goal, cell, goal.get("peer", policy), replays, "peer_priors" if "peer_priors" in goal else "priors") for cell in cells]
    own, peer = (sum(value for value in values if value is not None) for values in (own, peer))
    if not any(cell["category"] == goal.get("category", cell["category"]) for cell in cells):
        return None
    nothing_lost = own <= 0 or ("peer_priors" in goal and peer <= 0)
    return math.inf if nothing_lost else peer / own


def judge_goal(goal, cells, policy, replays):
    behind = []
    if "decision_arms" in goal:
        reached = replays.decision(policy, goal["decision_arms"])
    elif "peer" in goal or "peer_priors" in goal:
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
        after = [percent(replays.row(cell, policy, priors)["regret_best_fixed"]) for priors in PRIORS]
        paper = replays.row(cell, "paper", "none")["regret_best_fixed"]
        rows.append([cell["cell"], cell["category"], percent(abs(replays.controls[cell["cell"]])), percent(row["headroom"]),
                     percent(row["regret_best_fixed"]), percent(row["ci95"][0]) + " to " + percent(row["ci95"][1]),
                     or_dash(row["regret_after_start"], percent), *after,
                     or_dash(row["headroom_captured"], lambda ratio: f"{100 * ratio:.0f}%"), f"{row['switches']:.1f}",
                     f"{row['active_share']:.2f}", or_dash(row["bail_outs"], "{:.2f}".format), percent(paper)])
    return table(["cell", "category", "floor", "headroom", "regret", "ci95", "after_start", *PRIORS, "captured",
                  "switches", "share", "bail_outs", "paper"], rows)


def mean(values):
    """Returns the mean of the values that are not None, or None."""
    known = [value for value in values if value is not None]
    return sum(known) / len(known) if known else None


def policies_text(cells, replays):
    rows = []
    for policy in replays.policies:
        for category in CATEGORIES:
            own = [replays.row(cell, policy, "none") for cell in cells if cell["category"] == category]
            if own:
                regret = [row["regret_best_fixed"] for row in own]
                rows.append([policy, category, str(len(own)), percent(mean(regret)), percent(max(regret)),
                             or_dash(mean([row["regret_after_start"] for row in own]), percent),
                             f"{mean([row['switches'] for row in own]):.1f}",
                             f"{mean([row['bail_outs'] or 0 for row in own]):.2f}"])
    return table(["policy", "category", "cells", "regret", "worst", "after_start", "switches", "bail_outs"], rows)


def decisions_text(goals, cells, policy, replays):
    return (f"Policy {policy}, {replays.seeds} seeds in each of {len(cells)} cells; regret is frame time ÷ that of the "
            f"best fixed arm, minus 1.\n\n{goals_text(goals)}\n{cells_text(cells, policy, replays)}\n"
            "floor: the same arm measured twice. headroom: what the best sequence of arms would save, including the\n"
            "cost of its switches. captured: the part of the headroom that the policy saved. right, wrong, class,\n"
            "scenes: with stored priors from other games (`sweepstake-lab replay --priors`).\n\n"
            + policies_text(cells, replays))


def decisions_json(goals, cells, policy, replays):
    return {"command": "replay", "policy": policy, "seeds": replays.seeds,
            "goals": [goal | {"reached": None if goal["reached"] == math.inf else goal["reached"]} for goal in goals],
            "cells": [{"cell": cell["cell"], "category": cell["category"], "pass_ns": cell["pass_ns"],
                       "control_regret": replays.controls[cell["cell"]],
                       **{f"regret_{priors}_prior": replays.row(cell, policy, priors)["regret_best_fixed"] for priors in PRIORS}}
                      for cell in cells],
            "rows": [replays.row(cell, each, "none") for cell in cells for each in replays.policies]}
