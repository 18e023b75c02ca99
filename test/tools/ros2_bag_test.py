#!/usr/bin/env python3
"""Recordings of ROS 2 as CSV files. What Fast-CDR writes was made by ros2_bag_cdr.cpp beside this file; all other messages are laid out by hand."""

import contextlib
import io
import math
import os
import sqlite3
import struct
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

from battery_sof_tools import ros2_bag
from battery_sof_tools.sof import program

SOF = program(os.environ["BATTERY_SOF_BUILD"], "sof")
NAN = math.nan
TYPE = "sensor_msgs/msg/BatteryState"
# -20.1 A, 12.275 V and 21.5 degC at 1700000000.25 s, in the frame "battery", with two cells and a serial number.
FAST_CDR = {
    "<": "0001000000f1536580b2e60e080000006261747465727900666644410000ac41cdcca0c10000c07f0000c07f00004842cdcc4c3f0201000102000000333303405c8f0240"
         "00000000050000006c65667400eeeeee03000000413100",
    ">": "000000006553f1000ee6b2800000000862617474657279004144666641ac0000c1a0cccd7fc000007fc00000424800003f4ccccd02010001000000024003333340028f5c"
         "00000000000000056c65667400eeeeee00000003413100",
}
GAP = b"\xee"  # of bytes between two fields, as Fast-CDR left them: nobody may read them


def text(order, value):
    return struct.pack(order + "I", len(value) + 1) + value.encode() + b"\0"


def message(time=(1700000000, 250000000), current=-20.1, voltage=12.275, temperature=NAN, frame="", order="<", cells=()):
    """The CDR of a BatteryState: behind the mark of the byte order, numbers of four bytes at multiples of four."""
    data = struct.pack(order + "iI", *time) + text(order, frame)
    data += GAP * (-len(data) % 4) + struct.pack(order + "7f4B", voltage, temperature, current, NAN, NAN, 50.0, 0.8, 2, 1, 0, 1)
    data += struct.pack(f"{order}I{len(cells)}f", len(cells), *cells) + struct.pack(order + "I", 0) + text(order, "left")
    data += GAP * (-len(data) % 4) + text(order, "A1")
    return (b"\0\1\0\0" if order == "<" else b"\0\0\0\0") + data


class Bags(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="a bag ")
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def bag(self, name, messages, topics=(("/battery", TYPE),), form="cdr"):
        """A file as rosbag2_storage_sqlite3 lays it out. Messages: bytes on the first topic, 1.5 s apart from 100 s on."""
        path = self.path(name)
        with contextlib.closing(sqlite3.connect(path)) as database, database:
            database.execute("CREATE TABLE topics(id INTEGER PRIMARY KEY,name TEXT NOT NULL,type TEXT NOT NULL,serialization_format TEXT NOT NULL,offered_qos_profiles TEXT NOT NULL)")
            database.execute("CREATE TABLE messages(id INTEGER PRIMARY KEY,topic_id INTEGER NOT NULL,timestamp INTEGER NOT NULL, data BLOB NOT NULL)")
            database.executemany("INSERT INTO topics VALUES (?, ?, ?, ?, '')", [(7 + k, *topic, form) for k, topic in enumerate(topics)])
            database.executemany("INSERT INTO messages (topic_id, timestamp, data) VALUES (7, ?, ?)",
                                 [(100 * 10 ** 9 + k * 1500 * 10 ** 6, data) for k, data in enumerate(messages)])
        return path

    def convert(self, bag, *options, out=None):
        """Exit message or 0, what the CSV file has, standard output and standard error."""
        out = out or self.path("out.csv")
        said, warned = io.StringIO(), io.StringIO()
        with mock.patch.object(sys, "argv", ["ros2_bag", bag, out, *options]), contextlib.redirect_stdout(said), contextlib.redirect_stderr(warned):
            code = ros2_bag.main()
        written = ""
        if code == 0:
            with open(out, encoding="utf-8") as file:
                written = file.read()
        return code, written, said.getvalue(), warned.getvalue()

    def refuse(self, words, bag, *options, **more):
        code, *_ = self.convert(bag, *options, **more)
        self.assertRegex(str(code), "^ros2_bag: .*" + words)
        self.assertFalse(os.path.exists(self.path("out.csv")))
        self.assertFalse([name for name in os.listdir(self.folder) if name.endswith(".part")])

    def test_what_fast_cdr_writes_in_either_byte_order_is_read(self):
        for order, digits in FAST_CDR.items():
            self.assertEqual(bytes.fromhex(digits), message(temperature=21.5, frame="battery", cells=(2.05, 2.04), order=order))
            _, written, said, warned = self.convert(self.bag(f"{ord(order)}.db3", [bytes.fromhex(digits)]))
            self.assertEqual("time_s,current_a,voltage_v,temperature_c\n1700000000.250000000,-20.1,12.275,21.5\n", written)
            self.assertEqual((f"1 rows of /battery written to {self.path('out.csv')}\n", ""), (said, warned))

    def test_texts_and_lists_of_every_length_are_skipped(self):
        for length in range(9):
            for order in "<>":
                data = message(frame="x" * length, cells=(2.0,) * (length % 3), order=order)
                for padding in range(4):
                    self.assertEqual((1700000000, 250000000), ros2_bag.message_of(data + b"\0" * padding)[0])
                self.assertRaisesRegex(ValueError, "behind the last field", ros2_bag.message_of, data + b"\0" * 4)

    def test_a_message_that_is_cut_off_anywhere_is_refused(self):
        whole = bytes.fromhex(FAST_CDR["<"])
        for size in range(len(whole)):
            with self.assertRaisesRegex(ValueError, "expected|too few"):
                ros2_bag.message_of(whole[:size])
        self.refuse("message 2 of .*cut.db3 has 40 bytes and ends within voltage, expected the CDR of a sensor_msgs/msg/BatteryState",
                    self.bag("cut.db3", [whole, whole[:40]]))
        self.refuse("message 1 of .*lists.db3 has 91 bytes, too few for 4294967295 elements of header.frame_id",
                    self.bag("lists.db3", [whole[:12] + b"\xff" * 4 + whole[16:]]))
        self.refuse("begins with the bytes 00 03 00 00, expected 00 00", self.bag("parameters.db3", [b"\0\3" + whole[2:]]))

    def test_a_temperature_that_is_never_finite_is_no_column(self):
        _, written, *_ = self.convert(self.bag("cold.db3", [message(), message((1700000001, 0), current=0.0, voltage=NAN)]), "--discharge-positive")
        self.assertEqual("time_s,current_a,voltage_v\n1700000000.250000000,20.1,12.275\n1700000001.000000000,0,\n", written)

    def test_without_stamps_the_time_is_that_of_the_recording(self):
        _, written, _, warned = self.convert(self.bag("bare.db3", [message((0, 0)), message((0, 0), current=-3.0)]))
        self.assertEqual("time_s,current_a,voltage_v\n100.000000000,-20.1,12.275\n101.500000000,-3,12.275\n", written)
        self.assertIn("no message has a valid stamp: the time is that of the recording", warned)

    def test_two_clocks_are_not_mixed(self):
        _, written, _, warned = self.convert(self.bag("both.db3", [message((0, 0)), message(), message((5, 10 ** 9)), message((-1, 0))]))
        self.assertEqual("time_s,current_a,voltage_v\n1700000000.250000000,-20.1,12.275\n", written)
        self.assertIn("3 of 4 messages left out, because they have no valid stamp", warned)

    def test_a_folder_is_read_in_the_order_of_its_metadata(self):
        os.mkdir(self.path("trip"))
        for number in (9, 10):
            self.bag(f"trip/trip_{number}.db3", [message((number, 0))])
        listed = "rosbag2_bagfile_information:\n  version: 3\n  storage_identifier: sqlite3\n  relative_file_paths:\n    - trip/trip_9.db3\n    - \"trip_10.db3\"\n  duration:\n    nanoseconds: 0\n"
        with open(self.path("trip", "metadata.yaml"), "w", encoding="utf-8") as file:
            file.write(listed)
        self.refuse("is the recording itself", self.path("trip"), out=self.path("trip", "metadata.yaml"))
        with open(self.path("trip", "metadata.yaml"), encoding="utf-8") as file:
            self.assertEqual(listed, file.read())
        _, written, *_ = self.convert(self.path("trip"))
        self.assertEqual("time_s,current_a,voltage_v\n9.000000000,-20.1,12.275\n10.000000000,-20.1,12.275\n", written)
        os.remove(self.path("out.csv"))
        os.remove(self.path("trip", "trip_10.db3"))
        self.refuse("No such file.*trip_10.db3", self.path("trip"))
        with open(self.path("trip", "metadata.yaml"), "w", encoding="utf-8") as file:
            file.write("rosbag2_bagfile_information:\n  relative_file_paths:\n    []\n")
        self.refuse("has no relative_file_paths, expected the names", self.path("trip"))
        os.remove(self.path("trip", "metadata.yaml"))
        self.refuse("metadata.yaml is missing; name the .db3 file itself", self.path("trip"))

    def test_a_topic_that_is_not_clear_is_refused_with_what_there_is(self):
        two = self.bag("two.db3", [message()], (("/first", TYPE), ("/second", TYPE), ("/said", "std_msgs/msg/String")))
        self.refuse("has several topics of sensor_msgs/msg/BatteryState, expected --topic with one of /first, /second", two)
        self.refuse(r"has no topic /third; its topics: /first \(sensor_msgs/msg/BatteryState\), /said", two, "--topic", "/third")
        self.refuse("topic /said of .*two.db3 is of type std_msgs/msg/String, expected sensor_msgs/msg/BatteryState", two, "--topic", "said")
        self.refuse("has no message on /second", two, "--topic", "/second")
        self.refuse(r"has no topic of sensor_msgs/msg/BatteryState; its topics: /said", self.bag("other.db3", [], (("/said", "std_msgs/msg/String"),)))
        self.refuse("is serialized as cdr2, expected cdr", self.bag("form.db3", [message()], form="cdr2"))
        self.assertIn("-20.1,12.275", self.convert(two, "--topic", "first")[1])

    def test_other_files_are_named_as_what_they_are(self):
        for begin, words in ((b"\x89MCAP0\r\n", "is an MCAP file, for which Debian 12 has no library; `ros2 bag convert`"), (b"\x28\xb5\x2f\xfd", "is compressed; `ros2 bag convert`"),
                             (b"#ROSBAG V2.0\n", "is a bag of ROS 1, which sof reads itself"), (b"time_s\n", "is not an SQLite file"), (b"", "is not an SQLite file")):
            with open(self.path("file"), "wb") as file:
                file.write(begin + bytes(20 if begin else 0))
            self.refuse(words, self.path("file"))
        self.refuse("message 1 of .*zstd.db3 is compressed", self.bag("zstd.db3", [b"\x28\xb5\x2f\xfd" + bytes(20)]))
        with contextlib.closing(sqlite3.connect(self.path("empty.db3"))) as database:
            database.execute("CREATE TABLE other(id)")
        self.refuse("empty.db3: no such table: topics, expected the tables topics and messages of rosbag2", self.path("empty.db3"))
        whole = self.bag("whole.db3", [message()] * 500)
        os.truncate(whole, 8192)
        self.refuse("whole.db3: .*expected the tables", whole)
        self.refuse("No such file", self.path("nowhere.db3"))

    def test_the_recording_is_never_written_over(self):
        bag = self.bag("drive.db3", [message()])
        with open(bag, "rb") as file:
            before = file.read()
        os.symlink(bag, self.path("link"))
        for out in (bag, self.path("link")):
            self.refuse("is the recording itself, expected the name of a CSV file", bag, out=out)
        self.refuse("is a folder, expected the name of a CSV file", bag, out=self.folder)
        self.refuse("No such file", bag, out=self.path("nowhere", "out.csv"))
        with open(bag, "rb") as file:
            self.assertEqual(before, file.read())

    def test_numbers_are_the_shortest_that_read_back(self):
        for value in (12.275, -0.0, 9.5e-7, 8.4e-4, 1.0 / 3.0, 16777217.0, -3.4028234e38, 1e-45):
            single = struct.unpack("f", struct.pack("f", value))[0]
            self.assertEqual(single, struct.unpack("f", struct.pack("f", float(ros2_bag.cell(single))))[0])
        self.assertEqual(["12.275", "0", "", ""], [ros2_bag.cell(value) for value in (struct.unpack("f", struct.pack("f", 12.275))[0], -0.0, math.inf, NAN)])

    def test_sof_reads_what_is_written(self):
        self.convert(self.bag("drive.db3", [message((1700000000 + k, 0), -10.0 - k % 7, 12.5 - 0.01 * (k % 7), 20.0) for k in range(100)]))
        done = subprocess.run([SOF, "convert", self.path("out.csv"), self.path("again.csv")], capture_output=True, text=True, check=True)
        self.assertIn("100 samples written to", done.stdout)
        self.assertIn("0 rejected", done.stdout)


if __name__ == "__main__":
    unittest.main()
