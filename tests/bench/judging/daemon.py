"""The capacity of a daemon: the figures of `daemon_load.py --json`, each with its goal."""

from judging.common import InputError, limit_of, meets, or_dash, table

SIGNS = {"at_least": "≥", "at_most": "≤", "below": "<"}


def judge(document, goals):
    """Returns one row per figure. It has a goal if the numbers of streams and sources are those of the goals."""
    if document.get("command") != "daemon_load" or not document.get("loads"):
        raise InputError("this is not a document of `daemon_load.py --json` with loads")
    by_figure = {(goal["load"], goal["figure"]): goal for goal in goals["goal"]} if is_whole(document, goals) else {}
    rows = []
    for load in document["loads"]:
        absent = [figure for name, figure in by_figure if name == load["name"] and figure not in load["figures"]]
        if absent:
            raise InputError(f"{load['title']}: {', '.join(absent)} was not measured")
        rows += [row_of(load["name"], figure, value, by_figure.get((load["name"], figure)))
                 for figure, value in load["figures"].items() if isinstance(value, (int, float))]
    return rows


def is_whole(document, goals):
    return document["streams"] == goals["streams"] and document["sources"] == goals["sources"]


def require_all(document, goals):
    """Fails if a goal cannot be judged."""
    if not is_whole(document, goals):
        raise InputError(f"the goals require {goals['streams']} streams and {goals['sources']} sources")
    absent = {goal["load"] for goal in goals["goal"]} - {load["name"] for load in document["loads"]}
    if absent:
        raise InputError(f"the document has no load {', '.join(sorted(absent))}")


def row_of(load, figure, value, goal):
    limit, number = limit_of(goal) if goal else (None, None)
    return {"load": load, "figure": figure, "value": value, "limit": limit, "goal": number, "met": goal and meets(goal, value)}


def daemon_text(document, rows):
    lines = []
    for load in document["loads"]:
        lines.append((load["title"],))
        lines += [(row["figure"], f"{row['value']:.2f}", or_dash(row["goal"], lambda number, sign=SIGNS.get(row["limit"]): f"{sign} {number:g}"), verdict(row["met"]))
                  for row in rows if row["load"] == load["name"]]
    return table(("figure", "value", "goal", ""), lines)


def verdict(met):
    return "" if met is None else "met" if met else "NOT MET"


def daemon_json(document, rows):
    return {"streams": document["streams"], "sources": document["sources"], "figures": rows}
