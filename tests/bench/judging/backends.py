"""Backends and peers: the comparisons of `sweepstake-lab bench --json`, each with its goal."""

import csv
import fnmatch

from judging.common import InputError, limits_of, meets, or_dash, table


def read_published(path):
    """Returns milliseconds by (peer, scene, objects), and the family with which each peer without a package is compared."""
    figures, families = {}, {}
    with open(path, newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            figures[row["peer"], row["scene"], int(row["objects"])] = float(row["ms_median"])
            families[row["peer"]] = row["family"]
    bridges = [peer for peer, family in families.items() if family == "bridge"]
    return figures, {peer: family for peer, family in families.items() if family != "bridge"}, bridges


def cell_of(row):
    return row["scene"], row["objects"]


def is_derived(ratio):
    return "derived_through" in ratio


def fits(goal, ratio, document):
    """Whether an entry of the goals applies to this comparison of the document."""
    simd = goal.get("simd", ratio["simd"])
    return (
        goal["compared"] == ratio["kind"]
        and goal.get("cold", False) == document["cold"]
        and (document["simd"][0] if simd == "best" else simd) == ratio["simd"]
        and goal.get("published", is_derived(ratio)) == is_derived(ratio)
        and goal.get("family", ratio["family"]) == ratio["family"]
        and goal.get("with", ratio["other"]) == ratio["other"]
        and goal.get("threads", ratio["threads"]) == ratio["threads"]
        and goal.get("min_objects", 0) <= ratio["objects"]
        and any(fnmatch.fnmatchcase(ratio["scene"], each) for each in goal.get("scenes", ["*"]))
        and not any(fnmatch.fnmatchcase(ratio["scene"], each) for each in goal.get("not_scenes", []))
    )


def bench_goal(goals, ratio, document):
    """Returns the goal of a comparison, or None, and whether it is reached.

    With two limits `goal` is the upper one, and `goal_at_least` the lower one."""
    goal = next((each for each in goals["bench"] if fits(each, ratio, document)), None)
    if goal is None:
        return {"goal": None, "met": None}
    limits = limits_of(goal)
    both = {"goal_at_least": goal["at_least"]} if len(limits) > 1 else {}
    return {"goal": limits[-1][1], **both, "met": meets(goal, ratio["value"])}


class BenchJudge:
    """The comparisons of one document, in the order of its cells and arms, each with its goal."""

    def __init__(self, document, goals, published):
        if document.get("command") != "bench" or not document.get("rows"):
            raise InputError("this is not a document of `sweepstake-lab bench --json` with rows")
        self.document, self.goals = document, goals
        self.figures, self.published_families, self.bridges = published
        self.speedups = {(cell_of(row), *arm_key(row), row["peer"]): row for row in document.get("speedups", [])}

    def ratios(self):
        ratios = []
        for cell in dict.fromkeys(cell_of(row) for row in self.document["rows"]):
            ratios += self.of_cell(cell)
        for ratio in ratios:
            ratio.update(bench_goal(self.goals, ratio, self.document))
        return ratios

    def of_cell(self, cell):
        measured = [self.plain(ratio) for ratio in self.document["ratios"] if cell_of(ratio) == cell]
        ratios = []
        for simd in self.document["simd"]:
            overall = [ratio for ratio in measured if ratio["kind"] == "overall" and ratio["simd"] == simd]
            at = 1 if overall and overall[0]["threads"] == 1 else 0
            ratios += overall[:at] + self.published_overall(cell, simd) + overall[at:]
        for row in self.document["rows"]:
            if cell_of(row) != cell or row["kind"] != "arm" or not counts(row):
                continue
            own = [each for each in measured if each["kind"] != "overall" and own_key(each) == (*arm_key(row), row["threads"])]
            family = [each for each in own if each["kind"] == "family"]
            rest = [each for each in own if each["kind"] != "family"]
            ratios += family + self.published_family(row) + rest + self.memory(row)
        return ratios

    @staticmethod
    def plain(ratio):
        return {key: value for key, value in ratio.items() if key not in ("goal", "goal_at_least", "met")}

    def published_family(self, row):
        if row["threads"] != 1:
            return []
        peers = [peer for peer, family in self.published_families.items() if family == row["family"]]
        return [ratio for ratio in (self.derived("family", row, peer) for peer in peers) if ratio]

    def published_overall(self, cell, simd):
        """Compares our fastest arm with this instruction set with the best of all published peers, and with every other
        published peer in a goal."""
        arms = [row for row in self.document["rows"] if cell_of(row) == cell and row["kind"] == "arm"
                and row["simd"] == simd and row["threads"] == 1 and counts(row)]
        if not arms:
            return []
        fastest = min(arms, key=lambda row: row["ms_median"])
        ratios = [ratio for ratio in (self.derived("overall", fastest, peer) for peer in self.published_families) if ratio]
        ratios.sort(key=lambda ratio: ratio["value"])
        return ratios[:1] + [ratio for ratio in ratios[1:] if self.is_named(ratio)]

    def is_named(self, ratio):
        return any("with" in goal and fits(goal, ratio, self.document) for goal in self.goals["bench"])

    def derived(self, kind, row, peer):
        """Derives the time of `peer` on this machine: the time of a bridge here × the quotient of their published figures for the
        cell, which were measured with warm caches."""
        if self.document["cold"]:
            return None
        for bridge in self.bridges:
            speedup = self.speedups.get((cell_of(row), *arm_key(row), bridge))
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


def arm_key(row):
    return row["arm"], row["simd"]


def own_key(ratio):
    return ratio["ours"], ratio["simd"], ratio["threads"]


def ratio_row(row, kind, other, value, value_mean):
    return {"scene": row["scene"], "objects": row["objects"], "threads": row["threads"], "kind": kind,
            "family": row["family"], "ours": row["arm"], "simd": row["simd"], "other": other, "value": value, "value_mean": value_mean}


def bench_json(document, ratios):
    """Returns the document with its goals: `goals` are the comparisons measured here, `published` those with published figures."""
    measured = [ratio for ratio in ratios if not is_derived(ratio) and ratio["goal"] is not None]
    derived = [ratio for ratio in ratios if is_derived(ratio)]
    return document | {"goals": measured, "published": derived}


def title_of(cell):
    return f"{cell[0]}, {cell[1]} objects"


def has_several_simd(document):
    return len(document["simd"]) > 1


def bench_rows_text(document):
    """Columns for peers or for several instruction sets appear only if the document has these."""
    peers = any(row["kind"] == "peer" for row in document["rows"])
    several = has_several_simd(document)
    header = [*["family"] * peers, "arm", *["simd"] * several, "thr", *["frames"] * peers,
              "ms_median", "ms_mean", "ms_min", "ms_p99", "aabb_checks", "bytes"]
    rows, before = [], None
    for row in document["rows"]:
        if cell_of(row) != before:
            before = cell_of(row)
            arm = next((each for each in document["rows"] if cell_of(each) == before and each["kind"] == "arm"), None)
            pairs = "" if arm is None else f", {arm['pairs_mean']:.1f} pairs per frame"
            rows.append([title_of(before) + pairs])
        rows.append([*[row["family"]] * peers, row["arm"], *[or_dash(row["simd"])] * several, str(row["threads"]),
                     *[str(row["frames"])] * peers,
                     *(f"{row[key]:.4f}" for key in ("ms_median", "ms_mean", "ms_min", "ms_p99")),
                     or_dash(row["aabb_checks_mean"], "{:.0f}".format), or_dash(row["bytes"])])
    return table(header, rows)


def notes_text(document):
    text = ""
    for row in document["rows"]:
        simd = f" with {row['simd']}" if row["simd"] and has_several_simd(document) else ""
        where = f"{row['arm']}{simd} in {row['scene']} ({row['objects']} objects): "
        if "note" in row:
            text += where + row["note"] + "\n"
        if "difference" in row:
            text += "FAILED " + where + row["difference"] + "\n"
    return text


def goal_text(ratio):
    lower = f"{ratio['goal_at_least']:.1f}-" if "goal_at_least" in ratio else ""
    return or_dash(ratio["goal"], lambda goal: f"{lower}{goal:.1f}")


def ratios_text(document, ratios):
    several = has_several_simd(document)
    rows, before = [], None
    for ratio in ratios:
        if cell_of(ratio) != before:
            before = cell_of(ratio)
            rows.append([title_of(before)])
        result = "-" if ratio["goal"] is None else "met" if ratio["met"] else "NOT MET"
        rows.append([ratio["kind"], ratio["ours"], *[ratio["simd"]] * several, str(ratio["threads"]), ratio["other"],
                     f"{ratio['value']:.2f}", or_dash(ratio["value_mean"], "{:.2f}".format), goal_text(ratio), result,
                     ratio.get("derived_through", "-")])
    return table(["compared", "ours", *["simd"] * several, "thr", "with", "ratio", "mean", "goal", "result", "through"], rows)


def machine_text(document):
    machine, cold = document["machine"], "cold caches, " if document["cold"] else ""
    text = f"{machine['cpu']}, {machine['cores']} cores, {machine['compiler']}, {machine['simd']}, {cold}{machine['date']}\n"
    text += ", ".join(f"{name} {version}" for name, version in machine["libraries"].items()) + "\n"
    return text + "".join(f"Left out: {absent}\n" for absent in machine["absent_peers"])


def bench_text(document, ratios):
    text = bench_rows_text(document) + notes_text(document)
    if ratios:
        text += "\n" + ratios_text(document, ratios)
    if any(row["kind"] == "peer" for row in document["rows"]):
        text += "\n" + machine_text(document)
    return text


def judge(document, goals, published):
    """Returns the comparisons of a document of `sweepstake-lab bench`, in its order."""
    return BenchJudge(document, goals, published).ratios()
