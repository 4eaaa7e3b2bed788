"""The choices of AI Decides: compares cells of `conditions.py`, `stored_priors.py` and `worth.py` with the goals of [[choosing]]."""

import json
import math
import pathlib
import statistics

from judging.common import InputError, limit_of, meets, or_dash, percent, read_goals, table
from judging.decisions import goals_text, limit_text

GOALS = pathlib.Path(__file__).resolve().parents[1] / "data/goals.toml"
# If a goal has one of these keys, it judges only the cells with the same value.
SELECTING = ("condition", "category", "flip_s")
# Columns of the cells' table that are printed as percent.
PERCENT = ("headroom", "captured", "regret", "excess", "half_width", "saving_error")


def mean(goal, cells):
    return statistics.fmean(cell[goal["figure"]] for cell in cells)


def weighted(goal, cells):
    weight = sum(cell[goal["weight"]] for cell in cells)
    return sum(cell[goal["figure"]] * cell[goal["weight"]] for cell in cells) / weight if weight else None


def times(goal, cells):
    """Returns the mean of the peer's figure ÷ the mean of the policy's figure; infinite if the latter is 0."""
    own = mean(goal, cells)
    return statistics.fmean(cell[goal["peer"]] for cell in cells) / own if own > 0 else math.inf


def share(goal, cells):
    """Returns the sum of the figure ÷ the sum of the weight."""
    weight = sum(cell[goal["weight"]] for cell in cells)
    return sum(cell[goal["figure"]] for cell in cells) / weight if weight > 0 else None


def worst_group(goal, cells):
    """Returns the worst mean over the cells of one condition, category and interval of flips."""
    groups = {}
    for cell in cells:
        groups.setdefault((cell["condition"], cell["category"], cell["flip_s"]), []).append(cell)
    return worst(goal, [mean(goal, group) for group in groups.values()])


def worst(goal, values):
    return min(values) if "at_least" in goal else max(values)


OVER = {"each": lambda goal, cells: worst(goal, [cell[goal["figure"]] for cell in cells]), "mean": mean, "weighted": weighted,
        "share": share, "times": times, "group": worst_group}
# A goal with one of these values of `over` is judged only over all cells together, and not for each cell.
WITHOUT_CELLS = ("share", "times")


def cells_of(goal, cells):
    """Returns the cells that the goal judges. Cells with a null figure (for example without headroom) are skipped."""
    chosen = [cell for cell in cells if all(cell.get(word) == goal[word] for word in SELECTING if word in goal)]
    for cell in chosen:
        if goal["figure"] not in cell:
            raise InputError(f"{cell['cell']} has no {goal['figure']}")
    return [cell for cell in chosen if cell[goal["figure"]] is not None]


def name_of(cell):
    pace = "" if cell.get("flip_s") is None else f" at {cell['flip_s']:g} s"
    return f"{cell['cell']}{pace}" + (f", {cell['condition']}" if "condition" in cell else "")


def judge_goal(goal, all_cells):
    cells = cells_of(goal, all_cells)
    reached = OVER[goal["over"]](goal, cells) if cells else None
    behind = [{"cell": name_of(cell), "value": cell[goal["figure"]], "met": meets(goal, cell[goal["figure"]])}
              for cell in cells] if goal["over"] not in WITHOUT_CELLS else []
    behind.sort(key=lambda each: each["value"], reverse="at_least" not in goal)
    return {"goal": goal["goal"], "limit": limit_of(goal)[1], "limit_text": limit_text(goal), "unit": goal["unit"],
            "reached": reached, "met": reached is not None and meets(goal, reached), "cells": behind}


def judge(document, goals):
    """Judges each goal of the document's row in [[choosing]]."""
    if not document.get("cells"):
        raise InputError("the document has no cells")
    judged = [judge_goal(goal, document["cells"]) for goal in goals if goal["row"] == document["row"]]
    if not judged:
        raise InputError(f"the row {document['row']} has no goal")
    return judged


def cell_text(name, value):
    if value is None:
        return "-"
    if isinstance(value, str):
        return value
    return percent(value) if name.startswith(PERCENT) else f"{value:.4g}"


def cells_text(cells):
    columns = [name for name, value in cells[0].items() if not isinstance(value, list)]
    return table(columns, [[cell_text(name, cell[name]) for name in columns] for cell in cells])


def conclusion(document, goals):
    """Returns the output as text and for --json, and whether a goal with cells was missed."""
    judged = judge(document, goals)
    head = ", ".join(f"{name} {cell_text(name, value) if isinstance(value, float) else value}" for name, value in document.items()
                     if name not in ("command", "cells", "goals"))
    text = f"{head}\n\n{goals_text(judged)}\n{cells_text(document['cells'])}"
    whole = document | {"goals": [goal | {"reached": None if goal["reached"] == math.inf else goal["reached"]} for goal in judged]}
    return text, whole, any(goal["reached"] is not None and not goal["met"] for goal in judged)


def conclude(document, as_json, goals_path=GOALS):
    """Prints the document with its goals. Returns the exit code: 0 met, 1 missed."""
    text, whole, missed = conclusion(document, read_goals(goals_path)["choosing"])
    print(json.dumps(whole, indent=2, ensure_ascii=False) if as_json else text, end="\n" if as_json else "")
    return 1 if missed else 0
