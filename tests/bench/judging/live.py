"""AI Decides in live games: the rows of `live.py --json` against its goals."""

import statistics

from judging.common import InputError, limit_of, meets, percent, table

# Fewer tell too little.
MIN_ROUNDS = 5
MIN_SCENES = 4

# The column of a figure, and what becomes of the scenes' values.
FIGURES = {
    "mean_regret": ("regret", statistics.fmean),
    "largest_regret": ("regret", max),
    "lane_tail_ratio": ("lane_tail_ratio", max),
    "trial_worst_ratio": ("trial_worst_ratio", max),
}


def judge_goal(goal, rows):
    column, over = FIGURES[goal["figure"]]
    limit, number = limit_of(goal)
    value = over([row[column] for row in rows])
    rounds = min(row["rounds"] for row in rows)
    scenes = len({(row["scene"], row["objects"]) for row in rows})
    worst = max(rows, key=lambda row: row[column])
    return {"condition": goal["condition"], "figure": goal["figure"], "scenes": scenes, "rounds": rounds, "value": value,
            "worst": f"{worst['scene']}-{worst['objects']}", "limit": limit, "goal": number,
            "met": rounds >= MIN_ROUNDS and scenes >= MIN_SCENES and meets(goal, value),
            "cells": [{"cell": f"{row['scene']}-{row['objects']}", "value": row[column]} for row in rows]}


def judge(document, goals):
    """One row per goal; one whose condition or figure was not measured has no value."""
    if document.get("command") != "live" or not isinstance(document.get("rows"), list):
        raise InputError("this is no document of `live.py --json`")
    judged = []
    for goal in goals:
        column = FIGURES[goal["figure"]][0]
        rows = [row for row in document["rows"] if row["condition"] == goal["condition"] and row[column] is not None]
        judged.append(judge_goal(goal, rows) if rows else {"condition": goal["condition"], "figure": goal["figure"], "met": None})
    if all(row["met"] is None for row in judged):
        raise InputError("no goal has a condition of the document")
    return judged


def live_text(rows):
    def number(row, value):
        return percent(value) if "regret" in row["figure"] else f"{value:.3f}"

    def result(row):
        if row["rounds"] < MIN_ROUNDS or row["scenes"] < MIN_SCENES:
            return "too few " + ("rounds" if row["rounds"] < MIN_ROUNDS else "scenes")
        return "met" if row["met"] else "NOT MET"
    measured = [row for row in rows if row["met"] is not None]
    missing = ", ".join(f"{row['condition']} {row['figure']}" for row in rows if row["met"] is None)
    text = table(("condition", "figure", "scenes", "rounds", "value", "at most", "worst", ""), [
        (row["condition"], row["figure"], str(row["scenes"]), str(row["rounds"]), number(row, row["value"]), number(row, row["goal"]),
         row["worst"], result(row)) for row in measured])
    return text + (f"\nNot in this document: {missing}.\n" if missing else "")
