#!/usr/bin/env python3
"""Numbers of CAN frames by the lines of a DBC file."""

import types
import unittest

from battery_sof_tools import can_log

DBC = """VERSION ""
BO_ 704 Battery: 8 Sensor
 SG_ Current : 0|16@1- (0.1,0) [-3276.8|3276.7] "A" Vector__XXX
 SG_ Voltage : 23|16@0+ (0.001,0) [0|65.535] "V" Vector__XXX
 SG_ Page M : 56|8@1+ (1,0) [0|255] "" Vector__XXX
 SG_ Hidden m1 : 40|8@1+ (1,0) [0|255] "" Vector__XXX
BO_ 2566834176 Thermal: 8 Sensor
 SG_ Temperature : 0|8@1+ (1,-40) [-40|215] "degC" Vector__XXX
 SG_ Voltage : 8|12@1+ (0.01,0) [0|40] "V" Vector__XXX
 SG_ Ratio : 32|32@1- (1,0) [0|1] "" Vector__XXX
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
        for name, message in (("Voltage", "several messages"), ("None", "not in the DBC file"), ("Hidden", "multiplexed"), ("Ratio", "floating-point")):
            with self.assertRaisesRegex(ValueError, message):
                self.signal(name)

    def test_each_frame_with_the_current_is_a_row_with_the_newest_of_the_others(self):
        warm = frame(0.5, 2566834176 - 2 ** 31, [65] + 7 * [0], True)
        battery = [frame(time, 704, [0x38, 0xFF, 0x30, 0xD4, 0, 0, 0, 0]) for time in (0.0, 1.0)]
        others = [self.signal("Battery.Voltage"), self.signal("Temperature")]
        rows = [(time, current, *values) for time, current, values in map(
            lambda row: (row[0], row[1], list(row[2])), can_log.rows_of([battery[0], warm, battery[1], frame(2.0, 704, b"", is_error_frame=True)],
                                                                        self.signal("Current"), others))]
        self.assertEqual([(0.0, -20.0, 12.5, None), (1.0, -20.0, 12.5, 25.0)], [tuple(value if value is None else round(value, 6) for value in row) for row in rows])


if __name__ == "__main__":
    unittest.main()
