#!/usr/bin/python3
"""Writes what the fuzz targets begin from into corpus/, but for the models, which `sof identify` made of simulate_city_drive
(seed 1, 300 s), one with --effects gassing. Bags are made by hand: rosbag pads them to 10 kB."""

import bz2
import os
import random
import struct

CORPUS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "corpus")
MD5 = "4ddae7f048e32fda22cac764685e3974"  # of sensor_msgs/BatteryState
NAN = float("nan")

CSV = {
    "plain": b"time_s,current_a,voltage_v\n0,0,12.5\n0.01,-1.5,12.49\n0.02,-1.5,12.48\n0.03,20,12.7\n",
    "temperature": b"time_s,current_a,voltage_v,temperature_c\n0,0,12.5,25\n1,,,25.5\n2,-100,11.5,\n3,nan,12,26\n2.5,-1,12,\n",
    "quoted": b'\xef\xbb\xbf"time_s" , "current_a",voltage_v,\r\n\r\n0, "-1e1" ,12.5,\r\n1,-200,9.5,\r\n2,30,14.',
    "dates": b"time_s,current_a,voltage_v\n2017-03-25 07:00:06.900,-1,12.5\n2017-03-25 07:00:07.000,-1,12.5\n",
    "drive": b"time_s,current_a,voltage_v\n" + b"".join(
        b"%.1f,%d,%.2f\n" % (0.1 * n, current, 12.5 + 0.006 * current) for n in range(100) for current in [(-20, 30, 0, -200)[n // 20 % 4]]),
}


def message(time, current, voltage, cells=(), warmth=(), texts=("", "", "")):
    """A serialized sensor_msgs/BatteryState."""
    text = lambda value: struct.pack("<I", len(value)) + value.encode()
    floats = lambda values: struct.pack("<I%df" % len(values), len(values), *values)
    return (struct.pack("<III", 1, int(time), int(time % 1 * 1e9)) + text(texts[0]) +
            struct.pack("<7fBBBB", voltage, NAN, current, NAN, NAN, NAN, NAN, 0, 0, 0, 1) + floats(cells) + floats(warmth) +
            text(texts[1]) + text(texts[2]))


def record(data, **fields):
    header = b"".join(struct.pack("<I", len(name) + 1 + len(value)) + name.encode() + b"=" + value for name, value in fields.items())
    return struct.pack("<I", len(header)) + header + struct.pack("<I", len(data)) + data


def connection():
    number, fields = struct.pack("<I", 0), dict(topic=b"/battery_state", type=b"sensor_msgs/BatteryState", md5sum=MD5.encode(), message_definition=b"")
    data = b"".join(struct.pack("<I", len(name) + 1 + len(value)) + name.encode() + b"=" + value for name, value in fields.items())
    return record(data, op=b"\x07", conn=number, topic=fields["topic"])


def lz4_frame(content):
    """A frame of LZ4 with one block that is stored as it is; 0x82 is the checksum of the two bytes before it."""
    return struct.pack("<IBBBI", 0x184D2204, 0x60, 0x40, 0x82, len(content) | 1 << 31) + content + struct.pack("<I", 0)


def bag(messages, compression):
    chunk, entries = connection(), b""
    for time, data in messages:
        stamp = struct.pack("<II", int(time), int(time % 1 * 1e9))
        entries += stamp + struct.pack("<I", len(chunk))
        chunk += record(data, op=b"\x02", conn=struct.pack("<I", 0), time=stamp)
    count = struct.pack("<I", len(messages))
    packed = {b"none": bytes, b"bz2": bz2.compress, b"lz4": lz4_frame}[compression](chunk)
    begin = lambda index: b"#ROSBAG V2.0\n" + record(
        b"  ", op=b"\x03", index_pos=struct.pack("<Q", index), conn_count=struct.pack("<I", 1), chunk_count=struct.pack("<I", 1))
    chunk_at = len(begin(0))
    body = (record(packed, op=b"\x05", compression=compression, size=struct.pack("<I", len(chunk))) +
            record(entries, op=b"\x04", ver=struct.pack("<I", 1), conn=struct.pack("<I", 0), count=count))
    info = record(struct.pack("<II", 0, len(messages)), op=b"\x06", ver=struct.pack("<I", 1), chunk_pos=struct.pack("<Q", chunk_at),
                  start_time=entries[:8], end_time=entries[-12:-4], count=struct.pack("<I", 1))
    return begin(chunk_at + len(body)) + body + connection() + info


def write(target, name, content):
    os.makedirs(os.path.join(CORPUS, target), exist_ok=True)
    with open(os.path.join(CORPUS, target, name), "wb") as file:
        file.write(content)


def main():
    for name, content in CSV.items():
        write("csv", name, content)
    plain = message(1.5, -5.0, 12.5)
    full = message(2.5, -200.0, 10.5, (2.1, 2.1), (25.0,), ("battery", "boot", "7"))
    write("message", "plain", plain)
    write("message", "full", full)
    for compression in (b"none", b"bz2", b"lz4"):
        write("bag", compression.decode(), bag([(1.5, plain), (2.5, full)], compression))
    dice = random.Random(1)
    for target, size in (("query", 120), ("session", 200)):
        for n in range(4):
            write(target, str(n), bytes(dice.randrange(256) for _ in range(size)))


if __name__ == "__main__":
    main()
