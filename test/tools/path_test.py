"""What a shell has after `source devel/setup.bash`: sof and ask_and_compare on the PATH, and the completion of sof."""

import os
import subprocess
import sys
import unittest

from battery_sof_tools import files

DEVEL = ""


def in_shell(script):
    """What a fresh bash prints that sourced the devel space; standard error is part of a failure."""
    told = subprocess.run(["bash", "--norc", "-c", 'cd /; . "$0/setup.bash"; ' + script, DEVEL], capture_output=True, text=True,
                          env={"PATH": "/usr/bin:/bin", "HOME": os.environ.get("HOME", "/")})
    if told.returncode != 0:
        raise AssertionError(f"{script}\nended with {told.returncode}: {told.stderr}")
    return told.stdout


def completed(*words):
    """What Tab offers for the last of these words."""
    line = " ".join(f'"{word}"' for word in words)
    return in_shell(f'COMP_WORDS=({line}); COMP_CWORD={len(words) - 1}; _sof; printf "%s\\n" "${{COMPREPLY[@]}}"').split()


class Path(unittest.TestCase):
    def test_sof_and_ask_and_compare_are_found_and_run(self):
        self.assertEqual(in_shell("sof --version"), f"sof {files.version()}\n")
        self.assertIn("usage", in_shell("ask_and_compare --help"))

    def test_subcommands_are_completed(self):
        self.assertEqual(completed("sof", "id"), ["identify"])
        self.assertEqual(completed("sof", "de"), ["demo"])
        self.assertEqual(completed("sof", "st"), ["stop-time"])
        self.assertEqual(completed("sof", "--v"), ["--version"])

    def test_options_of_a_subcommand_are_completed(self):
        self.assertEqual(completed("sof", "crank", "model.yaml", "--i-c"), ["--i-cranking"])
        self.assertIn("--report", completed("sof", "diagnose", "--"))
        self.assertNotIn("--report", completed("sof", "crank", "--"))
        self.assertIn("--duration", completed("sof", "simulate", "--"))

    def test_effects_are_completed_one_after_the_other(self):
        self.assertEqual(completed("sof", "identify", "--effects", "gas"), ["gassing"])
        self.assertEqual(completed("sof", "identify", "--effects", "gassing,cpe"), ["gassing,cpe2"])
        self.assertEqual(completed("sof", "identify", "--effects", "no"), ["none"])
        self.assertEqual(completed("sof", "identify", "--effects", "gassing,no"), [])

    def test_mechanisms_are_no_effects(self):
        for option in ("--hypotheses", "--given"):
            self.assertNotIn("structure", completed("sof", "diagnose", option, ""), option)
            self.assertEqual(completed("sof", "diagnose", option, "no"), [], option)
        self.assertEqual(completed("sof", "effects", "struct"), [])

    def test_an_option_is_followed_by_what_the_parser_takes_there(self):
        for command, option in (("diagnose", "--hypotheses"), ("diagnose", "--given")):
            self.assertEqual(completed("sof", command, option, "gas"), ["gassing"], option)
        self.assertEqual(completed("sof", "effects", "gas"), ["gassing"])
        self.assertEqual(completed("sof", "identify", "--start", ""), ["robust", "paper"])
        self.assertEqual(completed("sof", "predict", "--mode", "m"), ["mixed"])
        self.assertEqual(completed("sof", "identify", "--extend", "gas"), [], "is no option")
        self.assertEqual(completed("sof", "identify", "--out", "gas"), [], "a file")

    def test_elsewhere_files_are_completed(self):
        self.assertEqual(completed("sof", "check", "dri"), [])
        self.assertIn("_sof", in_shell("complete -p sof"))


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: path_test.py DEVEL")
    DEVEL = os.path.abspath(sys.argv.pop())
    unittest.main(verbosity=2)
