"""Recordings as CSV files: reading any columns, writing time_s,current_a,voltage_v, and the measured ones by name.

Current is positive into the battery in everything that is read here; a file of the other sign is turned round when it is read.
"""

import collections
import csv
import datetime
import math
import os

import numpy as np

QUANTITIES = ("time", "current", "voltage")
COLUMNS = ("time_s", "current_a", "voltage_v")  # what `sof` reads without being told

# path below the data folder, columns of time, current and voltage, sign, the stretch that is taken [s], and the nominal capacity where it is known [Ah]
Measured = collections.namedtuple("Measured", "path columns discharge_positive start end capacity_ah")
CAR = ("t_s", "current_A", "voltage_V")
ALL = (-math.inf, math.inf)
MEASURED = {
    "frc_robot": Measured("frc_robot/match.csv", ("t_s", "current_A_minus_sum_of_channels", "voltage_V_roborio"), False, *ALL, 18),
    "second_match": Measured("frc_robot/second_match.csv", COLUMNS, False, *ALL, 18),
    "leaf_cell": Measured("leaf_cell/hppc_25c.csv", ("Time(s)", "Current(A)", "Voltage(V)"), False, *ALL, 33),
    "agm_bench": Measured("agm_bench/full_cycle.csv", CAR, False, *ALL, 100),
    "solar_vrla": Measured("solar_vrla/ten_days.csv", ("time", "current", "voltage"), True, *ALL, 17),
    "ev_12v": Measured("ev_12v/load.csv", COLUMNS, False, *ALL, None),
    "small_car": Measured("small_car/trip.csv", COLUMNS, False, *ALL, 60),
    "ageing_bench": Measured("ageing_bench/cycles.csv", COLUMNS, False, *ALL, None),
    "drive_1a": Measured("startstop_car/drive_1.csv", CAR, False, 5481.0, 10000.0, 72),
    "drive_1b": Measured("startstop_car/drive_1.csv", CAR, False, 10000.0, 15692.0, 72),
    "drive_2a": Measured("startstop_car/drive_2.csv", CAR, False, 4070.0, 8500.0, 72),
    "drive_2b": Measured("startstop_car/drive_2.csv", CAR, False, 10906.0, 15500.0, 72),
    "other_car_1": Measured("startstop_car/other_car_1.csv", CAR, False, 9194.0, 13599.0, None),
}


def seconds(text):
    """[s] of a number, or of a date and time in UTC."""
    try:
        return float(text)
    except ValueError:
        return datetime.datetime.fromisoformat(text).replace(tzinfo=datetime.timezone.utc).timestamp()


def read(path, columns=COLUMNS, discharge_positive=False, start=-math.inf, end=math.inf):
    """Time [s], current [A, positive into the battery] and voltage [V] of the rows that hold all three, from start to end.

    Raises SystemExit where the file or a column is missing: the sentence names it.
    """
    if not os.path.exists(path):
        raise SystemExit(f"{path}: no such recording")
    time, current, voltage = columns
    rows = []
    with open(path, newline="") as file:
        reader = csv.DictReader(file)
        missing = [one for one in columns if one not in (reader.fieldnames or ())]
        if missing:
            raise SystemExit(f"{path}: no column {', '.join(missing)}; there are {', '.join(reader.fieldnames or ())}")
        for row in reader:
            if row[time] and row[current] and row[voltage]:
                rows.append((seconds(row[time]), float(row[current]), float(row[voltage])))
    t, i, u = np.array(rows).reshape(-1, 3).T
    kept = (t >= start) & (t <= end)
    return t[kept], -i[kept] if discharge_positive else i[kept], u[kept]


def read_plain(path):
    """Time [s], current [A] and voltage [V] of a file of `sof` or `draw_scenario`, none missing."""
    return np.loadtxt(path, delimiter=",", skiprows=1, usecols=(0, 1, 2)).T


def measured(data, name):
    """One of MEASURED below a data folder, as read() gives it."""
    one = MEASURED[name]
    return read(os.path.join(data, one.path), one.columns, one.discharge_positive, one.start, one.end)


def runs(mask):
    """(begin, end) of every stretch of samples in which a mask holds."""
    changes = np.flatnonzero(np.diff(np.concatenate(([False], mask, [False])).astype(int)))
    return list(zip(changes[::2], changes[1::2]))


def write(path, t, i, u):
    """A recording under COLUMNS: 1 us, 1 uA, 1 uV."""
    np.savetxt(path, np.column_stack((t, i, u)), "%.6f", ",", header=",".join(COLUMNS), comments="")


def add_column_arguments(parser):
    """Options of a script that reads recordings; columns_of() gives what was chosen."""
    for name, column in zip(QUANTITIES, COLUMNS):
        parser.add_argument(f"--{name}-column", default=column)
    parser.add_argument("--discharge-positive", action="store_true")


def columns_of(args):
    """(columns, whether discharge is positive), as read() and column_options() take them."""
    return (args.time_column, args.current_column, args.voltage_column), args.discharge_positive


def capacity_options(capacity_ah):
    """The nominal capacity of a battery, as `sof` is given it; nothing where it is not known."""
    return ["--capacity-ah", f"{capacity_ah:g}"] if capacity_ah else []


def column_options(columns, discharge_positive=False):
    """What reports `sof` the columns of a file."""
    options = [word for name, column in zip(QUANTITIES, columns) for word in (f"--{name}-column", column)]
    return options + ["--discharge-positive"] * discharge_positive
