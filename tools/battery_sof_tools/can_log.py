"""A CAN log (BLF, ASC and what else python3-can reads) as a CSV file that sof reads.

    can_log LOG DBC OUT.csv --current SIGNAL --voltage SIGNAL [--temperature SIGNAL] [--discharge-positive]

Signals are named as in the DBC file, or MESSAGE.SIGNAL where two messages have one of that name. Each frame with the current becomes a row; voltage and
temperature are those of the same frame, or else the newest before it. Needs python3-can. The DBC file is read here: python3-cantools is not in Debian 12.
Multiplexed signals and floating-point numbers are refused.
"""

import argparse
import csv
import os
import re
import sys
from typing import NamedTuple

MESSAGE = re.compile(r"BO_\s+(\d+)\s+(\w+)\s*:")
SIGNAL = re.compile(r"SG_\s+(\w+)\s*(\w*)\s*:\s*(\d+)\|(\d+)@([01])([+-])\s*\(\s*([^,\s]+)\s*,\s*([^)\s]+)\s*\)")
FLOAT = re.compile(r"SIG_VALTYPE_\s+(\d+)\s+(\w+)\s*:\s*[12]\s*;")
EXTENDED = 1 << 31  # of an identifier in a DBC file


class Signal(NamedTuple):
    """Where a number stands in the frames of one identifier, and what it counts."""
    message: str
    name: str
    identifier: int
    is_extended: bool
    start: int
    length: int
    is_intel: bool
    is_signed: bool
    scale: float
    offset: float
    fault: str = ""

    def value(self, data):
        """The number in a frame; None where the frame is too short."""
        first = self.start if self.is_intel else 8 * (self.start // 8) + 7 - self.start % 8  # of Motorola counted from the highest bit of each byte
        behind = 8 * len(data) - first - self.length
        if behind < 0:
            return None
        raw = int.from_bytes(data, "little" if self.is_intel else "big") >> (first if self.is_intel else behind) & (1 << self.length) - 1
        if self.is_signed and raw >> (self.length - 1):
            raw -= 1 << self.length
        return self.offset + self.scale * raw


def signals_of(dbc):
    """All signals of a DBC file's text."""
    found, message, floats = [], None, set(FLOAT.findall(dbc))
    for line in dbc.splitlines():
        if (start := MESSAGE.match(line.strip())):
            message = start.groups()
        elif message and (one := SIGNAL.match(line.strip())):
            name, multiplexed, first, length, order, sign, scale, offset = one.groups()
            fault = "is multiplexed" if multiplexed.startswith("m") else "is a floating-point number" if (message[0], name) in floats else ""
            number = int(message[0])
            found.append(Signal(message[1], name, number & (EXTENDED - 1), bool(number & EXTENDED), int(first), int(length), order == "1", sign == "-",
                                float(scale), float(offset), fault))
    return found


def chosen(signals, name):
    """The signal of a name. Raises ValueError that says what there is."""
    found = [one for one in signals if name in (one.name, f"{one.message}.{one.name}")]
    if len(found) != 1:
        what = "is not in the DBC file, which has" if not found else "is in several messages, expected one of"
        raise ValueError(f"signal {name} {what} {', '.join(sorted(f'{one.message}.{one.name}' for one in found or signals)[:20])}")
    if found[0].fault:
        raise ValueError(f"signal {name} {found[0].fault}, which is not read")
    return found[0]


def rows_of(frames, current, others):
    """Time, current and the others' newest values, a row for each frame with the current."""
    newest = [None] * len(others)
    for frame in frames:
        if frame.is_error_frame or frame.is_remote_frame:
            continue
        key = (frame.arbitration_id, frame.is_extended_id)
        for k, one in enumerate(others):
            if key == (one.identifier, one.is_extended):
                newest[k] = one.value(frame.data)
        if key == (current.identifier, current.is_extended) and (amperes := current.value(frame.data)) is not None:
            yield frame.timestamp, amperes, newest


def cell(value):
    return "" if value is None else f"{value:.10g}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("log", "dbc", "out"):
        parser.add_argument(name)
    parser.add_argument("--current", required=True, metavar="SIGNAL", help="signal of the current [A]")
    parser.add_argument("--voltage", required=True, metavar="SIGNAL", help="signal of the voltage [V]")
    parser.add_argument("--temperature", metavar="SIGNAL", help="signal of the temperature [degC]")
    parser.add_argument("--discharge-positive", action="store_true", help="the signal counts current out of the battery as positive")
    args = parser.parse_args()
    try:
        import can
    except ImportError:
        return "can_log: needs python3-can: apt install python3-can"
    try:
        with open(args.dbc, encoding="cp1252", errors="replace") as file:
            signals = signals_of(file.read())
        current = chosen(signals, args.current)
        others = [chosen(signals, name) for name in (args.voltage, args.temperature) if name]
        sign = -1.0 if args.discharge_positive else 1.0
        rows = [[f"{time:.6f}", cell(sign * amperes), *map(cell, values)] for time, amperes, values in rows_of(can.LogReader(args.log), current, others)]
        if not rows:
            return f"can_log: no frame of {args.log} has the signal {args.current}"
        with open(args.out + ".part", "w", newline="", encoding="utf-8") as file:
            csv.writer(file, lineterminator="\n").writerows([["time_s", "current_a", "voltage_v", "temperature_c"][:2 + len(others)], *rows])
        os.replace(args.out + ".part", args.out)
    except (OSError, ValueError) as error:
        return f"can_log: {error}"
    print(f"{len(rows)} rows written to {args.out}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
