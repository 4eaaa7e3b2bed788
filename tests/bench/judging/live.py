"""AI Decides in live games: compares the rows of `live.py --json` with its goals."""

import statistics

from judging.common import InputError, limit_of, meets, nine_in_ten, percent, table

# Minimum numbers for a judgement; fewer are too noisy.
MIN_ROUNDS = 5
MIN_SCENES = 4
MIN_TRIALS = 10


def worst_of_trials(ratios, controls):
    """Returns the 90th percentile of the trials' ratios ÷ that of their controls."""
    return nine_in_ten(ratios) / nine_in_ten(controls)


def pooled_trials(rows):
    """Returns this quotient over the trials of all scenes; None if there are too few."""
    ratios, controls = ([ratio for row in rows for ratio in row[name]] for name in ("trial_ratios", "control_ratios"))
    return worst_of_trials(ratios, controls) if len(ratios) >= MIN_TRIALS else None


# For each figure of a goal: the column of the rows, and the function that combines the rows of the scenes.
FIGURES = {
    "mean_regret": ("regret", lambda rows: statistics.fmean(row["regret"] for row in rows)),
    "largest_regret": ("regret", lambda rows: max(row["regret"] for row in rows)),
    "lane_tail_ratio": ("lane_tail_ratio", lambda rows: max(row["lane_tail_ratio"] for row in rows)),
    "trial_worst_ratio": ("trial_worst_ratio", pooled_trials),
}


def judge_goal(goal, played):
    """Judges a goal by the rows of its condition; without enough data the reached value is None."""
    column, over = FIGURES[goal["figure"]]
    rows = [row for row in played if row[column] is not None]
    value = over(rows) if rows else None
    if value is None:
        too_few = {"too_few": "trials", "trials": sum(row["trials"] for row in rows)} if rows else {"too_few": None}
        return {"condition": goal["condition"], "figure": goal["figure"], "met": None, **too_few}
    limit, number = limit_of(goal)
    rounds = min(row["rounds"] for row in played)
    scenes = len({(row["scene"], row["objects"]) for row in played})
    worst = max(rows, key=lambda row: row[column])
    too_few = "rounds" if rounds < MIN_ROUNDS else "scenes" if scenes < MIN_SCENES else None
    return {"condition": goal["condition"], "figure": goal["figure"], "scenes": scenes, "rounds": rounds, "value": value,
            "worst": f"{worst['scene']}-{worst['objects']}", "limit": limit, "goal": number,
            "too_few": too_few, "met": too_few is None and meets(goal, value),
            "cells": [{"cell": f"{row['scene']}-{row['objects']}", "value": row[column]} for row in rows]}


def judge(document, goals):
    """Returns one row per goal, without a value if its condition or figure was not measured."""
    if document.get("command") != "live" or not isinstance(document.get("rows"), list):
        raise InputError("this is not a document of `live.py --json`")
    judged = [judge_goal(goal, [row for row in document["rows"] if row["condition"] == goal["condition"]]) for goal in goals]
    if all(row["met"] is None for row in judged):
        raise InputError("the goals have none of the document's conditions")
    return judged


def live_text(rows):
    def number(row, value):
        return percent(value) if "regret" in row["figure"] else f"{value:.3f}"

    def result(row):
        if row["too_few"]:
            return f"too few {row['too_few']}"
        return "met" if row["met"] else "NOT MET"
    measured = [row for row in rows if row["met"] is not None]
    few, missing = (", ".join(f"{row['condition']} {row['figure']}" for row in rows if row["met"] is None and row["too_few"] == reason)
                    for reason in ("trials", None))
    text = table(("condition", "figure", "scenes", "rounds", "value", "at most", "worst", ""), [
        (row["condition"], row["figure"], str(row["scenes"]), str(row["rounds"]), number(row, row["value"]), number(row, row["goal"]),
         row["worst"], result(row)) for row in measured])
    return text + (f"\nToo few trials, at least {MIN_TRIALS} are needed: {few}.\n" if few else "") + (
        f"\nNot in this document: {missing}.\n" if missing else "")
