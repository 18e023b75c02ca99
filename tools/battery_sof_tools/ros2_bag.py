"""A recording of ROS 2 (rosbag2 in SQLite) as a CSV file that sof reads.

    ros2_bag BAG OUT.csv [--topic TOPIC] [--discharge-positive]

BAG is a .db3 file, or the folder of `ros2 bag record` with its metadata.yaml. Each sensor_msgs/msg/BatteryState becomes a row. The time is the
header's stamp, or the recording's where no message has a stamp; the temperature is a column if one was measured. Needs no ROS. MCAP files and
compressed recordings are refused.
"""

import argparse
import contextlib
import csv
import io
import math
import os
import re
import sqlite3
import struct
import sys
import urllib.parse

from .files import printable, read_text, write_text

METADATA = "metadata.yaml"
TYPE = "sensor_msgs/msg/BatteryState"
SQLITE = b"SQLite format 3\0"
ZSTD = b"\x28\xb5\x2f\xfd"
CONVERT = "`ros2 bag convert` with `storage_id: sqlite3` makes a .db3 file of it"
OTHERS = {
    b"\x89MCAP0\r\n": f"is an MCAP file, for which Debian 12 has no library; {CONVERT}",
    ZSTD: f"is compressed; {CONVERT}",
    b"#ROSBAG V": "is a bag of ROS 1, which sof reads itself",
}
MAX_PADDING = 3  # bytes behind the last field: some writers fill up to a multiple of four


class Cdr:
    """Takes values off the front of a message. Each begins at a multiple of its size (CORBA 3.0, 15.3), counted from behind the four bytes that name the
    byte order (OMG, DDS Interoperability Wire Protocol, section 10). All that is taken here begins with four bytes."""

    def __init__(self, data):
        if data[:2] not in (b"\0\0", b"\0\1"):
            raise ValueError(f"begins with the bytes {data[:4].hex(' ') or 'of nothing'}, expected 00 00 (CDR, big endian) or 00 01 (little endian)")
        self.order = "<" if data[1] else ">"
        self.data, self.at = data[4:], 0

    def numbers(self, kinds, name):
        """Numbers without a gap between them. @param kinds as struct has them. @param name of the first, for errors."""
        begin = -(-self.at // 4) * 4
        self.at = begin + struct.calcsize(self.order + kinds)
        if self.at > len(self.data):
            raise ValueError(f"has {len(self.data) + 4} bytes and ends within {name}, expected the CDR of a {TYPE}")
        return struct.unpack_from(self.order + kinds, self.data, begin)

    def skip_list(self, element, name):
        """A text (element of 1 byte, its final zero counted in), or a list of floating-point numbers."""
        count, = self.numbers("I", name)
        self.at += element * count
        if self.at > len(self.data):
            raise ValueError(f"has {len(self.data) + 4} bytes, too few for {count} elements of {name}")

    def require_end(self):
        if len(self.data) - self.at > MAX_PADDING:
            raise ValueError(f"has {len(self.data) - self.at} bytes behind the last field of a {TYPE}")


def message_of(data):
    """Stamp [s, ns], current [A], voltage [V] and temperature [degC] of a BatteryState. Raises ValueError where the bytes are no such message."""
    cdr = Cdr(data)
    stamp = cdr.numbers("iI", "header.stamp")
    cdr.skip_list(1, "header.frame_id")
    voltage, temperature, current, *_ = cdr.numbers("7f4B", "voltage")
    for name, element in (("cell_voltage", 4), ("cell_temperature", 4), ("location", 1), ("serial_number", 1)):
        cdr.skip_list(element, name)
    cdr.require_end()
    return stamp, current, voltage, temperature


def files_of(bag):
    """The SQLite files of a recording, in their order. Raises ValueError for what is no such recording."""
    paths = [bag]
    if os.path.isdir(bag):
        metadata = os.path.join(bag, METADATA)
        if not os.path.exists(metadata):
            raise ValueError(f"{metadata} is missing; name the .db3 file itself, or make it with `ros2 bag reindex`")
        listed = re.search(r"^( *)relative_file_paths:\s*\n((?:\1 *- .*\n?)+)", read_text(metadata), re.MULTILINE)
        names = re.findall(r"- +(.*\S)", listed[2]) if listed else []
        if not names:
            raise ValueError(f"{metadata} has no relative_file_paths, expected the names of .db3 files")
        paths = [os.path.join(bag, os.path.basename(name.strip("'\""))) for name in names]  # some versions put the folder's name before them
    for path in paths:
        with open(path, "rb") as file:
            begin = file.read(len(SQLITE))
        if begin != SQLITE:
            raise ValueError(f"{path} {next((what for mark, what in OTHERS.items() if begin.startswith(mark)), 'is not an SQLite file, expected a .db3 file of rosbag2')}")
    return paths


@contextlib.contextmanager
def opened(path):
    """A database that is read only; what it cannot do is a ValueError with its name."""
    try:
        with contextlib.closing(sqlite3.connect(f"file:{urllib.parse.quote(os.path.abspath(path))}?mode=ro", uri=True)) as database:
            yield database
    except sqlite3.Error as error:
        raise ValueError(f"{path}: {error}, expected the tables topics and messages of rosbag2") from error


def topics_of(paths):
    """Type and serialization of every topic, by its name."""
    found = {}
    for path in paths:
        with opened(path) as database:
            found.update({name: (kind, form) for name, kind, form in database.execute("SELECT name, type, serialization_format FROM topics") if isinstance(name, str)})
    return found


def chosen(topics, name, bag):
    """The topic of a name, or without one the only topic of the type. Raises ValueError that says what there is."""
    there = ", ".join(f"{topic} ({kind})" for topic, (kind, _) in sorted(topics.items())) or "none"
    fitting = sorted(topic for topic, (kind, _) in topics.items() if kind == TYPE)
    if name is None:
        if not fitting:
            raise ValueError(f"{bag} has no topic of {TYPE}; its topics: {there}")
        if len(fitting) > 1:
            raise ValueError(f"{bag} has several topics of {TYPE}, expected --topic with one of {', '.join(fitting)}")
        name = fitting[0]
    found = next((topic for topic in topics if topic.lstrip("/") == name.lstrip("/")), None)
    if found is None:
        raise ValueError(f"{bag} has no topic {name}; its topics: {there}")
    kind, form = topics[found]
    if kind != TYPE:
        raise ValueError(f"topic {found} of {bag} is of type {kind}, expected {TYPE}")
    if form != "cdr":
        raise ValueError(f"topic {found} of {bag} is serialized as {form}, expected cdr")
    return found


def messages_of(paths, topic):
    """Stamp, time of recording [s, ns], current, voltage, temperature of each message. Raises ValueError that names a message that cannot be read."""
    for path in paths:
        with opened(path) as database:
            rows = database.execute("SELECT messages.id, timestamp, data FROM messages JOIN topics ON topics.id = topic_id WHERE name = ? ORDER BY timestamp, messages.id", (topic,))
            for number, recorded, data in rows:
                if not isinstance(data, bytes) or not isinstance(recorded, int):
                    raise ValueError(f"message {number} of {path} has no bytes or no time, expected the CDR of a {TYPE} and nanoseconds")
                if data.startswith(ZSTD):
                    raise ValueError(f"message {number} of {path} is compressed; {CONVERT}")
                try:
                    stamp, *values = message_of(data)
                except ValueError as error:
                    raise ValueError(f"message {number} of {path} {error}") from error
                yield stamp, divmod(recorded, 10 ** 9), *values


def is_time(stamp):
    """Whether a header was given a stamp that can be a time."""
    return stamp[0] >= 0 and stamp[1] < 10 ** 9 and stamp != (0, 0)


def rows_of(messages):
    """Cells of time and values, a row for each message, and a sentence on times, or an empty one."""
    stamped = [message for message in messages if is_time(message[0])]
    if stamped:
        without = len(messages) - len(stamped)
        note = f"{without} of {len(messages)} messages left out, because they have no valid stamp" if without else ""
        return [(time, *values) for time, _, *values in stamped], note
    return [(time, *values) for _, time, *values in messages], "no message has a valid stamp: the time is that of the recording, with the delays of the network"


def cell(value):
    """The shortest decimal that reads back to a 32-bit number; empty where it is not finite."""
    if not math.isfinite(value):
        return ""
    texts = (f"{value + 0.0:.{digits}g}" for digits in range(6, 10))  # 0 for -0
    return next(text for text in texts if struct.pack("f", float(text)) == struct.pack("f", value + 0.0))


def csv_of(rows, sign):
    """Text of a CSV file, with a temperature where one was measured."""
    width = 4 if any(math.isfinite(row[3]) for row in rows) else 3
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["time_s", "current_a", "voltage_v", "temperature_c"][:width])
    for (seconds, nanoseconds), current, *others in rows:
        writer.writerow([f"{seconds}.{nanoseconds:09d}", cell(sign * current), *map(cell, others)][:width])
    return text.getvalue()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("bag", "out"):
        parser.add_argument(name)
    parser.add_argument("--topic", help="topic to read; needed if several topics have the type")
    parser.add_argument("--discharge-positive", action="store_true", help="the messages count current out of the battery as positive")
    args = parser.parse_args()
    try:
        paths = files_of(args.bag)
        if os.path.isdir(args.out):
            raise ValueError(f"{args.out} is a folder, expected the name of a CSV file")
        if os.path.exists(args.out) and any(os.path.samefile(args.out, path) for path in (*paths, os.path.join(args.bag, METADATA)) if os.path.exists(path)):
            raise ValueError(f"{args.out} is the recording itself, expected the name of a CSV file")
        topic = chosen(topics_of(paths), args.topic, args.bag)
        rows, note = rows_of(list(messages_of(paths, topic)))
        if not rows:
            raise ValueError(f"{args.bag} has no message on {topic}")
        write_text(args.out, csv_of(rows, -1.0 if args.discharge_positive else 1.0))
    except (OSError, ValueError) as error:
        return f"ros2_bag: {printable(str(error))}"
    if note:
        print(f"ros2_bag: {note}", file=sys.stderr)
    print(f"{len(rows)} rows of {printable(topic)} written to {args.out}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
