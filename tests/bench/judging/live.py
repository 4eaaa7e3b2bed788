"""AI Decides in live games: the rows of `live.py --json` against its goals."""

import statistics

from judging.common import InputError, limit_of, meets, percent, table

FIGURES = {
    "mean_regret": lambda rows: statistics.fmean(row["regret"] for row in rows),
    "largest_regret": lambda rows: max(row["regret"] for row in rows),
    "lane_tail_ratio": lambda rows: max(row["lane_tail_ratio"] for row in rows),
}


def judge(document, goals):
    """One row per goal whose condition was measured."""
    if document.get("command") != "live" or not document["rows"]:
        raise InputError("this is no document of `live.py --json`")
    judged = []
    for goal in goals:
        rows = [row for row in document["rows"] if row["condition"] == goal["condition"]]
        if not rows:
            continue
        value = FIGURES[goal["figure"]](rows)
        limit, number = limit_of(goal)
        judged.append({"condition": goal["condition"], "figure": goal["figure"], "scenes": len(rows), "value": value,
                       "limit": limit, "goal": number, "met": meets(goal, value)})
    if not judged:
        raise InputError("no goal has a condition of the document")
    return judged


def live_text(rows):
    def number(row, value):
        return percent(value) if "regret" in row["figure"] else f"{value:.3f}"
    return table(("condition", "figure", "scenes", "value", "at most", ""), [
        (row["condition"], row["figure"], str(row["scenes"]), number(row, row["value"]), number(row, row["goal"]),
         "met" if row["met"] else "NOT MET") for row in rows])
