#!/usr/bin/python3
"""can_to_csv.py BAG CSV: a battery sensor's current and voltage from a bag of can_msgs/Frame."""
import csv
import struct
import sys

import rosbag

FRAME, AMPERES, VOLTS = 0x2C0, 0.1, 0.001  # identifier and scales: from your sensor's DBC file
with rosbag.Bag(sys.argv[1]) as bag, open(sys.argv[2], "w", newline="") as out:
    rows = csv.writer(out)
    rows.writerow(["time_s", "current_a", "voltage_v"])
    for _, frame, _ in bag.read_messages("/received_messages"):
        if frame.id == FRAME:  # two bytes each, low byte first: signed current, unsigned voltage
            current, voltage = struct.unpack_from("<hH", bytes(frame.data))
            rows.writerow([f"{frame.header.stamp.to_sec():.3f}", f"{AMPERES * current:.1f}", f"{VOLTS * voltage:.3f}"])
