"""What each part of AI Decides contributes: compares the policies of `conditions.py ablation` in each condition."""

import json
import statistics

from judging.choosing import weighted
from judging.common import or_dash, table


def cell_of(place, rows):
    """Returns the cell of one game in one condition, with the results of every policy."""
    return place | {"policies": {policy: {"regret": row["regret_best_fixed"], "headroom": row["headroom"],
                                          "captured": row["headroom_captured"]} for policy, row in rows.items()}}


def compare(cells):
    """Returns a row for each policy and condition.

    Each has the mean and the worst regret of the stationary scenes, and the share that the policy captured of the time that switching
    could save in the changing ones. The share is over the headroom of all cells together, as in the goals; None without headroom.
    """
    rows = []
    for policy in cells[0]["policies"]:
        for condition in dict.fromkeys(cell["condition"] for cell in cells):
            own = [cell for cell in cells if cell["condition"] == condition]
            regrets = [cell["policies"][policy]["regret"] for cell in own if cell["flip_s"] is None]
            flips = [cell["policies"][policy] for cell in own if cell["flip_s"] is not None]
            flips = [flip for flip in flips if flip["captured"] is not None]
            rows.append({"policy": policy, "condition": condition, "regret": statistics.fmean(regrets) if regrets else None,
                         "worst_regret": max(regrets, default=None),
                         "captured": weighted({"figure": "captured", "weight": "headroom"}, flips)})
    return rows


def policies_table(rows, text):
    """Formats a table with a line for each policy and a column for each condition."""
    conditions = list(dict.fromkeys(row["condition"] for row in rows))
    lines = {}
    for row in rows:
        lines.setdefault(row["policy"], []).append(text(row))
    return table(["policy", *conditions], [[policy, *texts] for policy, texts in lines.items()])


def regret_text(row):
    return "-" if row["regret"] is None else f"{100 * row['regret']:.2f} ({100 * row['worst_regret']:.2f})"


def ablation_text(document, rows):
    paces = dict.fromkeys(cell["flip_s"] for cell in document["cells"] if cell["flip_s"] is not None)
    return (f"{document['list']}, {document['seeds']} seeds\n\n"
            "Stationary scenes: mean regret in percent, and that of the worst scene\n" + policies_table(rows, regret_text) +
            f"\nChanging scenes, regimes of {', '.join(f'{pace:g}' for pace in paces)} s: captured headroom in percent\n"
            + policies_table(rows, lambda row: or_dash(row["captured"], lambda ratio: f"{100 * ratio:.0f}")))


def conclude(document, as_json):
    """Prints the comparison. Returns the exit code 0, because it has no goals."""
    rows = compare(document["cells"])
    print(json.dumps(document | {"policies": rows}, indent=2) + "\n" if as_json else ablation_text(document, rows), end="")
    return 0
