"""Ctrl-C in `sof diagnose`: it ends within a second, by the signal, says what it was at, and leaves no file. Usage: interruption_test.py BUILD"""

import os
import signal
import subprocess
import sys
import tempfile
import time
import unittest

SOF = ""


class Interruption(unittest.TestCase):
    def interrupted(self, wanted, folder):
        drive, page = os.path.join(folder, "drive.csv"), os.path.join(folder, "page.html")
        subprocess.check_call([SOF, "demo", drive, "--duration", "600"], stdout=subprocess.DEVNULL)
        work = subprocess.Popen([SOF, "diagnose", drive, "--report", page], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        time.sleep(2.0)  # into the middle of its work, which takes ten times as long
        sent = time.monotonic()
        work.send_signal(wanted)
        _, said = work.communicate(timeout=30)
        return time.monotonic() - sent, work.returncode, said, os.listdir(folder)

    def test_it_ends_at_once_and_says_what_it_was_at(self):
        for wanted in (signal.SIGINT, signal.SIGTERM):
            with tempfile.TemporaryDirectory() as folder:
                took, code, said, left = self.interrupted(wanted, folder)
                self.assertEqual(code, -wanted, said)
                self.assertLess(took, 1.0)
                self.assertRegex(said, r"sof: stopped after \d+ s while \w.*; no file was written")
                self.assertEqual(left, ["drive.csv"])


if __name__ == "__main__":
    SOF = os.path.join(os.path.abspath(sys.argv.pop(1)), "devel", "lib", "battery_sof", "sof")
    unittest.main(verbosity=2)
