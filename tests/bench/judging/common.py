"""Shared by all judgements: text tables, limits of goals, and reading input."""

import json
import math
import sys
import tomllib

LIMITS = ("at_least", "at_most", "below")


class InputError(Exception):
    """The input cannot be judged; the message says why."""


def percent(ratio):
    text = f"{100 * ratio:.2f}"
    text = "0.00" if text == "-0.00" else text
    return ("" if text.startswith("-") else "+") + text + "%"


def is_number(cell):
    return cell != "" and not cell.strip("+-.0123456789e%")


def table(header, rows):
    """Formats aligned columns with numbers on the right; a row of one cell is a title. Same layout as engine_client/cli/io/text_table.h."""
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


def nine_in_ten(values):
    """Returns the smallest value that 90 % of the values do not exceed."""
    return sorted(values)[math.ceil(0.9 * len(values)) - 1]


def or_dash(value, text=str):
    return "-" if value is None else text(value)


def limits_of(goal):
    """Returns the kinds and the numbers of a goal's limits, in the order of LIMITS."""
    given = [(word, goal[word]) for word in LIMITS if word in goal]
    if not given:
        raise InputError(f"a goal must have one of {', '.join(LIMITS)}: {goal}")
    return given


def limit_of(goal):
    """Returns the kind and the number of the goal's only limit."""
    limits = limits_of(goal)
    if len(limits) != 1:
        raise InputError(f"a goal has more than one of {', '.join(LIMITS)}: {goal}")
    return limits[0]


def is_within(word, limit, value):
    return value >= limit if word == "at_least" else value <= limit if word == "at_most" else value < limit


def meets(goal, value):
    return all(is_within(word, limit, value) for word, limit in limits_of(goal))


def read_goals(path):
    with open(path, "rb") as file:
        goals = tomllib.load(file)
    for goal in goals["bench"]:
        limits_of(goal)
    for goal in goals["decisions"] + goals["choosing"] + goals["live"] + goals["daemon"]["goal"] + goals["proxies"]:
        limit_of(goal)
    return goals


def read_json(path):
    try:
        with sys.stdin if path == "-" else open(path, encoding="utf-8") as file:
            document = json.load(file)
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: {error}") from error
    if not isinstance(document, dict):
        raise InputError(f"{path} does not contain a JSON object")
    return document
