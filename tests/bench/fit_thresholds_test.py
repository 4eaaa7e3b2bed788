#!/usr/bin/env python3
"""Tests fit_thresholds.py with traces whose best rule is known."""

import math
import pathlib
import struct
import tempfile
import unittest

import fit_thresholds


def encoded(value):
    """Encodes the kinds of CBOR items that a trace has."""
    if isinstance(value, bool):
        return bytes([0xF5 if value else 0xF4])
    if isinstance(value, float):
        return b"\xfb" + struct.pack(">d", value)
    if isinstance(value, int):
        return bytes([value]) if value < 24 else b"\x1b" + value.to_bytes(8, "big")
    if isinstance(value, str):
        return bytes([0x78, len(value)]) + value.encode()
    if isinstance(value, list):
        return b"\x99" + len(value).to_bytes(2, "big") + b"".join(map(encoded, value))
    return bytes([0xB8, len(value)]) + b"".join(encoded(key) + encoded(each) for key, each in value.items())


def write_trace(folder, name, speeds):
    """Writes a trace with two frames per descriptor. SAP costs 100 ns at a speed below 1, else 400 ns; KDTree always costs 200 ns."""
    described = [{"frame": 2 * (i + 1), "descriptor": {figure: 0.0 for figure in fit_thresholds.FIGURES} | {"speed_mean": speed}}
                 for i, speed in enumerate(speeds)]
    costs = [cost for speed in speeds for cost in 2 * [100 if speed < 1 else 400, 200]]
    trace = {"arms": [{"name": "SAP"}, {"name": "KDTree"}], "detection_ns": costs, "descriptors": described}
    path = folder / name
    path.write_bytes(encoded({"format": "sweepstake-costs", "version": 2, "trace": trace}))
    return path


class FitTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def samples(self, *speeds_of_traces):
        samples = []
        for number, speeds in enumerate(speeds_of_traces):
            path = write_trace(pathlib.Path(self.folder.name), f"{number}.costs", speeds)
            arms, added = fit_thresholds.samples_of(path)
            self.assertEqual(arms, ["SAP", "KDTree"])
            samples += added
        return samples

    def test_a_sample_has_the_costs_of_the_frames_that_its_descriptor_describes(self):
        (trace, weight, figures, losses), other = self.samples([0.25, 4.0])
        self.assertEqual((trace, weight, figures[fit_thresholds.FIGURES.index("speed_mean")]), ("0", 0.5, 0.25))
        self.assertEqual(losses, [0, math.log(2)])
        self.assertEqual(other[3], [math.log(2), 0])

    def test_the_tree_splits_between_the_speeds_at_which_the_fastest_arm_changes(self):
        tree = fit_thresholds.grow(self.samples([0.25, 0.5, 3.5], [0.75, 4.0], [0.5, 3.5]), 3)
        self.assertEqual(tree[0], (fit_thresholds.FIGURES.index("speed_mean"), 2.1))
        self.assertEqual([type(side) for side in tree[1:]], [list, list])
        self.assertEqual(fit_thresholds.loss_of(tree), 0)

    def test_one_trace_alone_makes_no_split(self):
        samples = self.samples([0.25, 0.5, 3.5])
        self.assertEqual(fit_thresholds.grow(samples, 1), samples)


if __name__ == "__main__":
    unittest.main()
