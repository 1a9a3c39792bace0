#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Checks quoted.py: it finds seeded errors, and takes no block without a command."""
import pathlib
import sys
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).parent))
import quoted

PRINTS = "printf 'gap 1.02 mm\\ncount 7\\ntook 31 ms\\n'"


def faults(page, nightly=False):
    return quoted.check(page, pathlib.Path("/nonexistent"), nightly)[1]


def console(lines, options=""):
    return f"{options}\n```console\n$ {PRINTS}\n{lines}\n```\n"


def hidden(line, command=PRINTS):
    return f"The gap is 1 mm\nof 7.\n\n<!-- quoted\n$ {command}\n{line}\n-->\n"


class Quoted(unittest.TestCase):
    def test_equal_output_passes(self):
        self.assertEqual(faults(console("gap 1.02 mm\ncount 7\ntook 31 ms")), [])

    def test_wrong_numbers_are_found(self):
        for wrong in ("gap 1.06 mm\ncount 7\ntook 31 ms", "gap 1.02 mm\ncount 8\ntook 31 ms"):
            self.assertEqual(len(faults(console(wrong))), 1, wrong)

    def test_wrong_words_and_missing_lines_are_found(self):
        for wrong in ("gap 1.02 cm\ncount 7\ntook 31 ms", "gap 1.02 mm\ncount 7", "", "count 7"):
            self.assertEqual(len(faults(console(wrong))), 1, wrong)

    def test_rounding_and_tolerance(self):
        self.assertEqual(faults(console("gap 1 mm\n[..]")), [])
        self.assertEqual(faults(console("gap 1.01 mm\n[..]")), [])
        self.assertEqual(len(faults(console("gap 1.00 mm\n[..]", "<!-- quoted: tolerance 0.1 % -->"))), 1)
        self.assertEqual(faults(console("gap 1.10 mm\n[..]", "<!-- quoted: tolerance 10 % -->")), [])

    def test_times_are_not_compared_where_the_page_says_so(self):
        lines = "[..]\ntook 99 ms"
        self.assertEqual(len(faults(console(lines))), 1)
        self.assertEqual(faults(console(lines, "<!-- quoted: not compared: ms -->")), [])

    def test_blocks_without_a_command_are_not_taken(self):
        page = "```\ngap 9 mm\n```\n```sh\nfalse\n```\n<!-- about $ false -->\n"
        self.assertEqual(quoted.quotations(page), [])

    def test_failing_commands_are_found(self):
        self.assertEqual(len(faults("```console\n$ false\n```\n")), 1)
        self.assertEqual(faults("<!-- quoted: fails -->\n```console\n$ false\n```\n"), [])

    def test_nightly_commands_run_at_night_alone(self):
        page = "<!-- quoted: nightly -->\n```console\n$ false\n```\n"
        self.assertEqual(faults(page), [])
        self.assertEqual(len(faults(page, nightly=True)), 1)

    def test_options_end_with_their_block(self):
        page = "<!-- quoted: fails -->\n```console\n$ false\n```\n\n```console\n$ true\n```\n"
        self.assertEqual(faults(page), [])

    def test_phrases(self):
        self.assertEqual(faults(hidden("gap is 1 mm of => gap 1 mm")), [])
        self.assertEqual(faults(hidden("of 7 => count 7")), [])
        for wrong in ("gap is 2 mm => gap 2 mm", "gap is 1 mm => count 7", "of 7 => count 8", "gap is 1 mm => gap"):
            self.assertEqual(len(faults(hidden(wrong))), 1, wrong)

    def test_anything_passes_over_other_numbers(self):
        self.assertEqual(faults(hidden("of 7 => p50 [..] 7 [..]", "echo p50 1 2 7 9")), [])
        self.assertEqual(len(faults(hidden("of 7 => p50 [..] 7 [..]", "echo p50 1 2 8 9"))), 1)

    def test_rows(self):
        page = "| a | 1 |\n|---|---|\n<!-- quoted\n$ echo '| a | {} |'\n-->\n"
        self.assertEqual(faults(page.replace("{}", "1")), [])
        self.assertEqual(len(faults(page.replace("{}", "2"))), 1)

    def test_what_cannot_be_read_is_an_error(self):
        for page in ("```console\n$ true\n", "<!-- quoted: often -->\n```console\n$ true\n```\n",
                     "```console\nno command\n```\n"):
            with self.assertRaises(ValueError):
                quoted.quotations(page)

    def test_the_demo_that_run_sh_starts(self):
        self.assertEqual(quoted.started("bash demos/run.sh"), "piano --profile 4")
        self.assertEqual(quoted.started("bash demos/run.sh tennis --seed 2"), "tennis --seed 2")
        self.assertEqual(quoted.started("demos/run.sh --listen 7777"), "piano --listen 7777")


if __name__ == "__main__":
    unittest.main()
