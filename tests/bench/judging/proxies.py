"""The cost of proxies: the figures of `proxy_ratios_bench` or `proxy_steps_bench`, with their goals if they have any."""

from judging.common import InputError, limit_of, meets, or_dash, table

SIGNS = {"at_least": "≥", "at_most": "≤", "below": "<"}


def judge(document, goals):
    """Returns one row per figure. Every goal of the program must have its figure."""
    by_figure = {goal["figure"]: goal for goal in goals if goal["by"] == document.get("command")}
    if not by_figure:
        raise InputError("this is not a document of `proxy_ratios_bench` or `proxy_steps_bench`")
    absent = by_figure.keys() - document.keys()
    if absent:
        raise InputError(f"{', '.join(sorted(absent))} was not measured")
    return [row_of(figure, value, by_figure.get(figure)) for figure, value in document.items() if figure != "command"]


def row_of(figure, value, goal):
    limit, number = limit_of(goal) if goal else (None, None)
    return {"figure": figure, "value": value, "limit": limit, "goal": number, "met": goal and meets(goal, value)}


def proxies_text(rows):
    return table(("figure", "value", "goal", ""), [
        (row["figure"], f"{row['value']:.3f}", or_dash(row["goal"], lambda number, row=row: f"{SIGNS[row['limit']]} {number:g}"),
         "" if row["met"] is None else "met" if row["met"] else "NOT MET") for row in rows])
