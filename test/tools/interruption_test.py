"""Ctrl-C in `sof diagnose`: it ends within a second, by the signal, says what it was at, and leaves no file. What long commands say of
how far they are, on a terminal alone. Usage: interruption_test.py BUILD"""

import os
import pty
import signal
import subprocess
import sys
import tempfile
import threading
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


def on_a_terminal(command, seconds):
    """What a command says on standard error where that is a terminal; after `seconds` it is interrupted."""
    ours, theirs = pty.openpty()
    work = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=theirs)
    os.close(theirs)
    pieces = []
    said = threading.Thread(target=read_all, args=(ours, pieces), daemon=True)
    said.start()
    try:
        work.wait(timeout=seconds)
    except subprocess.TimeoutExpired:
        work.send_signal(signal.SIGINT)
        work.wait(timeout=10)
    said.join(timeout=10)
    os.close(ours)
    return "".join(pieces)


def read_all(stream, pieces):
    while True:
        try:
            piece = os.read(stream, 65536)
        except OSError:  # the last one at the other end is gone
            return
        if not piece:
            return
        pieces.append(piece.decode())


class ProgressOnATerminal(unittest.TestCase):
    def test_a_diagnosis_says_what_it_is_at_and_how_long_it_took(self):
        with tempfile.TemporaryDirectory() as folder:
            drive = os.path.join(folder, "drive.csv")
            subprocess.check_call([SOF, "demo", drive, "--duration", "600"], stdout=subprocess.DEVNULL)
            said = on_a_terminal([SOF, "diagnose", drive], 3.5)
        self.assertRegex(said, r"\w.* \.\.\.\r\n  [2-4] s")
        self.assertRegex(said, r"\r\x1b\[Ksof: stopped after \d+ s while \w")

    def test_a_map_says_how_long_it_will_take(self):
        with tempfile.TemporaryDirectory() as folder:
            drive, model = os.path.join(folder, "drive.csv"), os.path.join(folder, "model.yaml")
            subprocess.check_call([SOF, "demo", drive, "--duration", "300"], stdout=subprocess.DEVNULL)
            subprocess.check_call([SOF, "identify", drive, "--out", model, "--effects", "cpe2"], stdout=subprocess.DEVNULL)
            command = [SOF, "map", model, "--i-cranking", "-200", "--i-load", listed(-1, 200), "--t-stop", listed(1, 200)]
            said = on_a_terminal(command, 4.5)
        self.assertRegex(said, r"mapping cranks \.\.\.\r\n  \d s, about \d+ s left")


def listed(step, count):
    return ",".join(str(step * k) for k in range(1, count + 1))


if __name__ == "__main__":
    SOF = os.path.join(os.path.abspath(sys.argv.pop(1)), "devel", "lib", "battery_sof", "sof")
    unittest.main(verbosity=2)
