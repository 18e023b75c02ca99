#!/usr/bin/env python3
"""Numbers of CAN frames by the lines of a DBC file."""

import importlib.machinery
import importlib.util
import os
import struct
import subprocess
import sys
import tempfile
import types
import unittest
import zlib

from battery_sof_tools.files import ROOT

PROGRAM = os.path.join(ROOT, "scripts", "can_log")
loader = importlib.machinery.SourceFileLoader("can_log", PROGRAM)
can_log = importlib.util.module_from_spec(importlib.util.spec_from_loader("can_log", loader))
loader.exec_module(can_log)

DBC = """VERSION ""
BO_ 704 Battery: 8 Sensor
 SG_ Current : 0|16@1- (0.1,0) [-3276.8|3276.7] "A" Vector__XXX
 SG_ Voltage : 23|16@0+ (0.001,0) [0|65.535] "V" Vector__XXX
 SG_ Page M : 56|8@1+ (1,0) [0|255] "" Vector__XXX
 SG_ Hidden m1 : 40|8@1+ (1,0) [0|255] "K" Vector__XXX
 SG_ Other m2 : 40|8@1+ (2,0) [0|255] "" Vector__XXX
BO_ 2566834176 Thermal: 8 Sensor
 SG_ Temperature : 0|8@1+ (1,-40) [-40|215] "degC" Vector__XXX
 SG_ Voltage : 8|12@1+ (0.01,0) [0|40] "V" Vector__XXX
 SG_ Ratio : 32|32@1- (1,0) [0|1] "" Vector__XXX
BO_ 705 Nested: 8 Sensor
 SG_ Outer M : 0|8@1+ (1,0) [0|255] "" Vector__XXX
 SG_ Inner m0M : 8|8@1+ (1,0) [0|255] "" Vector__XXX
 SG_ Deep m1 : 16|8@1+ (1,0) [0|255] "" Vector__XXX
SIG_VALTYPE_ 2566834176 Ratio : 1;
"""


def frame(time, identifier, data, is_extended=False, **more):
    fields = dict(timestamp=time, arbitration_id=identifier, is_extended_id=is_extended, data=bytes(data), is_error_frame=False, is_remote_frame=False)
    return types.SimpleNamespace(**dict(fields, **more))


class CanLog(unittest.TestCase):
    def setUp(self):
        self.signals = can_log.signals_of(DBC)

    def signal(self, name):
        return can_log.chosen(self.signals, name)

    def test_both_byte_orders_and_signs_are_read(self):
        data = bytes([0x38, 0xFF, 0x30, 0xD4, 0, 0, 0, 0])
        self.assertAlmostEqual(self.signal("Current").value(data), -20.0)
        self.assertAlmostEqual(self.signal("Battery.Voltage").value(data), 12.5)
        self.assertIsNone(self.signal("Battery.Voltage").value(data[:3]))

    def test_a_signal_that_is_not_clear_is_refused_with_what_there_is(self):
        for name, message in (("Voltage", "several messages"), ("None", "not in the DBC file"), ("Deep", "several levels")):
            with self.assertRaisesRegex(ValueError, message):
                self.signal(name)

    def test_a_multiplexed_signal_is_read_in_the_frames_of_its_page(self):
        page = [bytes([0, 0, 0, 0, 0, 42, 0, page]) for page in range(3)]
        self.assertEqual([None, 42.0, None], [self.signal("Hidden").value(data) for data in page])
        self.assertEqual([None, None, 84.0], [self.signal("Other").value(data) for data in page])
        rows = list(can_log.rows_of([frame(k, 704, data) for k, data in enumerate(page)], self.signal("Current"), [self.signal("Hidden")]))
        self.assertEqual([[None], [42.0], [42.0]], [values for _, _, values in rows])

    def test_a_floating_point_signal_is_read(self):
        self.assertEqual(0.25, self.signal("Ratio").value(bytes(4) + struct.pack("<f", 0.25)))

    def test_columns_have_the_units_of_the_dbc_file(self):
        self.assertEqual(["time_s", "current_a", "voltage_v"], can_log.header_of([self.signal("Current"), self.signal("Battery.Voltage")]))
        self.assertEqual(["time_s", "current_a", "voltage_mv", "temperature_k"], can_log.header_of(
            [self.signal("Current"), self.signal("Battery.Voltage")._replace(unit="mV"), self.signal("Hidden")]))

    def test_each_frame_with_the_current_is_a_row_with_the_newest_of_the_others(self):
        warm = frame(0.5, 2566834176 - 2 ** 31, [65] + 7 * [0], True)
        battery = [frame(time, 704, [0x38, 0xFF, 0x30, 0xD4, 0, 0, 0, 0]) for time in (0.0, 1.0)]
        others = [self.signal("Battery.Voltage"), self.signal("Temperature")]
        rows = [(time, current, *values) for time, current, values in map(
            lambda row: (row[0], row[1], list(row[2])), can_log.rows_of([battery[0], warm, battery[1], frame(2.0, 704, b"", is_error_frame=True)],
                                                                        self.signal("Current"), others))]
        self.assertEqual([(0.0, -20.0, 12.5, None), (1.0, -20.0, 12.5, 25.0)], [tuple(value if value is None else round(value, 6) for value in row) for row in rows])


STUB = """import struct, types, zlib
io = types.SimpleNamespace()
def LogReader(log):
    with open(log, "rb") as file:
        content = zlib.decompress(file.read())
    for k in range(0, len(content), 8):
        yield types.SimpleNamespace(timestamp=k / 8, arbitration_id=704, is_extended_id=False, data=content[k:k + 8], is_error_frame=False, is_remote_frame=False)
"""


class Program(unittest.TestCase):
    """The program with a stand-in for python-can."""

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        for name, text in (("can.py", STUB), ("v.dbc", DBC)):
            with open(self.path(name), "w", encoding="utf-8") as file:
                file.write(text)

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def run_on(self, name, content, *more):
        with open(self.path(name), "wb") as file:
            file.write(content)
        return subprocess.run([sys.executable, PROGRAM, self.path(name), self.path("v.dbc"), self.path("out.csv"), "--current", "Current", *more],
                              env=dict(os.environ, PYTHONPATH=self.folder.name), capture_output=True, text=True, check=False)

    def test_writes_a_row_for_each_frame(self):
        done = self.run_on("a.blf", zlib.compress(2 * bytes([0x38, 0xFF, 0x30, 0xD4, 0, 0, 0, 0])), "--voltage", "Battery.Voltage")
        self.assertEqual((0, ""), (done.returncode, done.stderr))
        with open(self.path("out.csv"), encoding="utf-8") as file:
            self.assertEqual("time_s,current_a,voltage_v\n0.000000,-20,12.5\n1.000000,-20,12.5\n", file.read())

    def test_refuses_what_cannot_be_worked_with_in_a_sentence_and_with_code_2(self):
        for name, content, voltage, message in (("a.blf", b"damaged", "Battery.Voltage", "cannot be read, expected a whole CAN log"), ("a.blf", zlib.compress(b""), "Battery.Voltage", "no frame of"),
                                                ("a.mf4", b"", "Battery.Voltage", "install both with pip, or export the log as BLF or ASC"), ("a.blf", b"", "None", "not in the DBC file")):
            refused = self.run_on(name, content, "--voltage", voltage)
            self.assertEqual(2, refused.returncode)
            self.assertIn(message, refused.stderr)
            self.assertNotIn("Traceback", refused.stderr)
            self.assertFalse(os.path.exists(self.path("out.csv")))
        self.assertEqual(2, self.run_on("a.blf", b"").returncode)


if __name__ == "__main__":
    unittest.main()
