#!/usr/bin/env python3
"""Tests how soak.py judges its samples."""

import unittest

import soak


def samples(rss_kib):
    return [{"time_s": float(number), "rss_kib": kib, "descriptors": 20, "threads": 5} for number, kib in enumerate(rss_kib)]


class JudgeTest(unittest.TestCase):
    def test_a_measure_that_grows_in_the_first_half_and_varies_in_the_second_is_flat(self):
        rows = soak.judge(samples([100 * step for step in range(10)] + [1000, 1010] * 5), 0.05)
        self.assertTrue(rows["rss_kib"]["flat"])
        self.assertTrue(rows["threads"]["flat"])
        self.assertEqual(rows["rss_kib"]["peak"], 1010)

    def test_a_measure_that_rises_in_the_second_half_is_not_flat(self):
        rows = soak.judge(samples([1000] * 10 + [1000 + 10 * step for step in range(10)]), 0.05)
        self.assertFalse(rows["rss_kib"]["flat"])
        self.assertAlmostEqual(rows["rss_kib"]["growth_ratio"], 90 / 1045)
        self.assertTrue(rows["descriptors"]["flat"])

    def test_a_measure_that_falls_is_flat(self):
        self.assertTrue(soak.judge(samples(range(1000, 900, -5)), 0.05)["rss_kib"]["flat"])

    def test_a_run_that_is_too_short_is_not_judged(self):
        with self.assertRaisesRegex(soak.Failure, "too few samples"):
            soak.judge(samples([1] * 4), 0.05)


if __name__ == "__main__":
    unittest.main()
