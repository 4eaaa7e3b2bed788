"""Tests neon_instructions.py: which instructions count as executed, and when a goal is met."""

import contextlib
import io
import pathlib
import sys
import unittest
from unittest import mock

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import neon_instructions  # noqa: E402

# Two blocks: one with three instructions, the second of which takes two lines, and one with one instruction.
FIRST = b"""----------------
IN: main
0x4000001000:  48 89 e7                 movq     %rsp, %rdi
0x4000001003:  48 c7 84 24 80 00 00 00  movq     $0, 0x80(%rsp)
0x400000100b:  00 00 ff 00
0x400000100f:  e8 f8 0b 00 00           callq    0x4000002000

Trace 0: 0x7f0001 [0000000000000000/0000004000001000/00000001/00000201] main
"""
SECOND = b"""----------------
IN: work
0x5500002000:  d503201f  nop

Trace 0: 0x7f0002 [0000000000000000/0000005500002000/00000001/00000201] work
"""
AGAIN = b"Trace 0: 0x7f0001 [0000000000000000/0000004000001000/00000001/00000201] main\n"
WRITE = b"4711 write(1,0x5000,6) = 6\n"


def count(log):
    return list(neon_instructions.instructions_between_writes(log.splitlines(keepends=True)))


def run_main(instructions, words=()):
    """Returns exit code and stdout for frames with these numbers of instructions; `instructions` has a list per instruction set."""
    out, err = io.StringIO(), io.StringIO()
    with (mock.patch.object(neon_instructions, "run", lambda simd, program, cell: (instructions[simd], ["end 1 2"])),
          mock.patch.object(neon_instructions, "require_programs"),
          contextlib.redirect_stdout(out), contextlib.redirect_stderr(err)):
        return neon_instructions.main(["--only", "Grid", *words]), out.getvalue()


class Counting(unittest.TestCase):
    def test_counts_each_execution_of_a_block(self):
        self.assertEqual(count(FIRST + SECOND + AGAIN + WRITE), [7])

    def test_starts_again_at_zero_after_each_write(self):
        self.assertEqual(count(FIRST + WRITE + SECOND + WRITE + AGAIN), [3, 1])

    def test_counts_the_latest_translation_of_a_block(self):
        other = SECOND.replace(b"0x7f0002", b"0x7f0001")
        self.assertEqual(count(FIRST + WRITE + other + AGAIN + WRITE), [3, 2])


class Goal(unittest.TestCase):
    def test_is_met_up_to_its_limit(self):
        code, out = run_main({"neon": [13, 13], "sse4": [10, 10]})
        self.assertEqual(code, 0)
        self.assertIn("met", out)
        self.assertNotIn("NOT MET", out)

    def test_is_missed_beyond_it(self):
        code, out = run_main({"neon": [14, 13], "sse4": [10, 10]})
        self.assertEqual(code, 1)
        self.assertIn("NOT MET", out)

    def test_is_not_judged_if_the_pairs_differ(self):
        with self.assertRaises(neon_instructions.RunError):
            neon_instructions.compare("Grid", ([1], ["end 1 2"]), ([1], ["end 2 2"]))


if __name__ == "__main__":
    unittest.main()
