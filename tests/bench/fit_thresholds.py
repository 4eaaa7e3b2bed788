#!/usr/bin/env python3
"""Fits the rule of the policy `thresholds-fitted` (tests/laboratory/policies) to cost traces.

The rule is a small tree: it compares figures of the scene's descriptor with thresholds and names the arm to run. Each descriptor of
a trace is a sample, with the mean cost of every arm on the frames that it describes; each trace has the same weight. The
tree minimizes the mean of ln(cost of the named arm ÷ cost of the fastest arm). A split must have samples of two traces or more on each
side, and gain at least LEAST_GAIN. Make the traces with `tests/bench/traces.sh data/tuning_scenes.txt FOLDER`.
"""

import argparse
import math
import pathlib
import struct

FIGURES = ("object_count", "density_ratio", "size_spread", "speed_mean", "clustering_ratio", "static_ratio")
MOST_LEAVES = 6
LEAST_GAIN = 0.005  # of the mean ln(cost), over all traces


def decode(data, at=0):
    """Decodes one CBOR item (RFC 8949) of the kinds in a trace; returns it and the offset of the next one."""
    major, low = data[at] >> 5, data[at] & 31
    at += 1
    if major == 7:
        if low in (26, 27):
            size = 4 if low == 26 else 8
            return struct.unpack(">f" if size == 4 else ">d", data[at:at + size])[0], at + size
        return {20: False, 21: True}.get(low), at
    size = {24: 1, 25: 2, 26: 4, 27: 8}.get(low, 0)
    count = int.from_bytes(data[at:at + size], "big") if size else low
    at += size
    if major == 0:
        return count, at
    if major == 1:
        return -1 - count, at
    if major == 3:
        return data[at:at + count].decode(), at + count
    items = []
    for _ in range(count * (major - 3)):
        item, at = decode(data, at)
        items.append(item)
    return (items, at) if major == 4 else (dict(zip(items[::2], items[1::2])), at)


def samples_of(path):
    """Returns the arms, and a sample per descriptor: the trace, its weight, the figures and ln(cost ÷ least cost) of each arm."""
    trace = decode(path.read_bytes())[0]["trace"]
    arms, costs, described = [arm["name"] for arm in trace["arms"]], trace["detection_ns"], trace["descriptors"]
    begins = [0] + [each["frame"] for each in described]
    samples = []
    for each, begin in zip(described, begins):
        frames = range(begin, each["frame"])
        mean = [sum(costs[frame * len(arms) + arm] for frame in frames) / len(frames) for arm in range(len(arms))]
        losses = [math.log(cost / min(mean)) for cost in mean]
        samples.append((path.stem, 1 / len(described), [each["descriptor"][figure] for figure in FIGURES], losses))
    return arms, samples


def totals(samples):
    return [sum(weight * losses[arm] for _, weight, _, losses in samples) for arm in range(len(samples[0][3]))]


def candidates(samples):
    """Returns the possible splits: a figure and a threshold of two digits between two neighbouring values."""
    for figure in range(len(FIGURES)):
        values = sorted({sample[2][figure] for sample in samples})
        yield from {(figure, float(f"{(a + b) / 2:.2g}")) for a, b in zip(values, values[1:])}


def divided(samples, split):
    figure, threshold = split
    sides = [[each for each in samples if (each[2][figure] < threshold) == below] for below in (True, False)]
    return sides if all(len({each[0] for each in side}) >= 2 for side in sides) else None


def best_split(samples, depth):
    """Returns the least loss with at most `depth` nested splits, and the first of them, or None."""
    best = (min(totals(samples)), None)
    if depth == 0:
        return best
    for split in sorted(set(candidates(samples))):
        sides = divided(samples, split)
        if not sides:
            continue
        loss = sum(best_split(side, depth - 1)[0] for side in sides)
        if loss < best[0] - 1e-12:
            best = (loss, split)
    return best


def grow(samples, trace_count):
    """Returns the tree: a leaf is a list of samples, a split a triple of the split and both sides."""
    leaves, tree = 1, [samples]

    def visit(node, depth):
        nonlocal leaves
        loss = min(totals(node))
        found, split = best_split(node, 2 if depth == 0 else 1)
        if split is None or loss - found < LEAST_GAIN * trace_count or leaves >= MOST_LEAVES:
            return node
        leaves += 1
        return (split, *[visit(side, depth + 1) for side in divided(node, split)])

    return visit(tree[0], 0)


def show(node, arms, indent=""):
    if isinstance(node, tuple):
        (figure, threshold), below, above = node
        print(f"{indent}{FIGURES[figure]} < {threshold:g}:")
        show(below, arms, indent + "  ")
        print(f"{indent}else:")
        show(above, arms, indent + "  ")
        return
    ranked = sorted(zip(totals(node), arms))
    weight = sum(each[1] for each in node)
    print(f"{indent}{ranked[0][1]}, else {ranked[1][1]}  ({100 * math.expm1(ranked[0][0] / weight):.1f} % and "
          f"{100 * math.expm1(ranked[1][0] / weight):.1f} % above the fastest; {len({each[0] for each in node})} traces)")


def loss_of(node):
    return sum(loss_of(side) for side in node[1:]) if isinstance(node, tuple) else min(totals(node))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("traces", nargs="+", type=pathlib.Path)
    paths = parser.parse_args().traces
    samples, arms = [], []
    for path in paths:
        arms, added = samples_of(path)
        samples += added
    tree = grow(samples, len(paths))
    show(tree, arms)
    print(f"Mean loss {100 * math.expm1(loss_of(tree) / len(paths)):.2f} %, always the best single arm "
          f"{100 * math.expm1(min(totals(samples)) / len(paths)):.2f} %, {len(paths)} traces, {len(samples)} samples")


if __name__ == "__main__":
    main()
