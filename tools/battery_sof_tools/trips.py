"""Answers of the first minutes: pairs of trips of one battery, the state file of the first given to the second.

    trips BUILD --data FOLDER [--parked S] [--json FILE]
    trips BUILD --simulated [--seed N] [--json FILE]

Plays every pair through a session (`experiment trips`) and prints, for minutes 0-1, 1-5, 5-15 and later of the second trip: how many standing answers were
valid, errors of cranks and charges, coverage and width of their 90 % intervals. The same second trip without a state file stands below. With --simulated
the trips are the reference simulator's, at 100 Hz: parked an hour to 30 days, warmer and colder, and with another battery put in.
"""

import argparse
import json
import os
import tempfile

import numpy as np

from . import recordings
from .files import write_json
from .rates import pooled
from .sof import program, rows_of, run
from .tables import table

AGES = ((0.0, 60.0, "0-1"), (60.0, 300.0, "1-5"), (300.0, 900.0, "5-15"), (900.0, np.inf, "later"))
LONGEST_S = 3600.0  # of a trip
# recording and range of the first and of the second trip; a name alone is cut in the middle
# of cars that crank; other_car_1 and ev_12v have no crank in these stretches
PAIRS = (("drive_1a", "drive_1b"), ("drive_1b", "drive_2a"), ("drive_2a", "drive_2b"), ("drive_1a", "drive_2b"), "small_car")


# Batteries of the simulated cars: what differs from the simulator's own (benchmark/simulator/battery_elements.hpp, additions.hpp).
CARS = {
    "agm_50": {"effects": {"gassing": "tafel", "charge_acceptance": True}},
    "flooded_70": {"effects": {"charge_acceptance": True}, "battery": {"capacity_ah": 70.0, "r_ohmic_ohm": 0.0026, "r1_charge_ohm": 0.0038, "r1_discharge_ohm": 0.0026, "cpe2_capacitance_f": 1400.0, "u0_v": 12.6}},
    "two_electrodes": {"additions": {"second_electrode": True, "acid_transport": True}, "battery": {"r1_discharge_ohm": 0.005, "i0_a": 0.7}},
}
OTHERS = {  # put in instead
    "weaker": {"battery": {"r_ohmic_ohm": 0.0064, "r1_charge_ohm": 0.009, "r1_discharge_ohm": 0.0075, "cpe2_capacitance_f": 600.0, "u0_v": 12.45}},
    "stronger": {"battery": {"capacity_ah": 95.0, "r_ohmic_ohm": 0.0018, "r1_charge_ohm": 0.0026, "r1_discharge_ohm": 0.0018, "cpe2_capacitance_f": 1900.0, "u0_v": 12.85}},
}
# name -> parked [h], warmer [K], battery put in
SIMULATED = {"1 h": (1, 0, None), "12 h": (12, 0, None), "7 days": (168, 0, None), "30 days": (720, 0, None), "12 h, 15 K warmer": (12, 15, None), "12 h, 15 K colder": (12, -15, None),
             "7 days, 15 K colder": (168, -15, None), "12 h, weaker battery": (12, 0, "weaker"), "12 h, stronger battery": (12, 0, "stronger")}
TRIP_S, CHARGED, LOST_PER_HOUR, WARM_C = 1200.0, 0.8, 4e-5, 20.0  # [s], state of charge, its loss while parked, first trip's temperature


def simulated_trip(sof, path, battery, seed, soc, temperature):
    """A trip through town with a thermometer, written as a recording. @return the state of charge at its end."""
    scenario = {"name": "trip", "seed": seed, "duration_s": TRIP_S, "voltage_limit_v": 14.2, "soc": soc, "temperature_degc": temperature,
                "acquisition": {"voltage_white_v": 0.002, "current_white_a": 0.05}, "profile": {"kind": "city_drive", "net_charge_ah": 0.5}, **battery}
    write_json(path + ".yaml", scenario)
    answer = json.loads(run([sof, "simulate", path + ".yaml", path, "--json", "-"]))
    time, current, voltage = recordings.read(path)
    with open(path, "w") as file:
        file.write("time_s,current_a,voltage_v,temperature_c\n")
        for n, row in enumerate(zip(time, current, voltage)):
            file.write("{:.3f},{:.6g},{:.8g},{}\n".format(*row, f"{temperature:.1f}" if n % 100 == 0 else ""))
    return answer["soc_at_end"]


def simulated_pairs(build, seed, folder):
    """(case, paths, parked [s]) of every car and case."""
    sof = program(build, "sof")
    for number, (car, battery) in enumerate(CARS.items()):
        first = os.path.join(folder, f"{car}_first.csv")
        soc = simulated_trip(sof, first, battery, 1000 * seed + number, CHARGED, WARM_C)
        for k, (case, (hours, warmer, other)) in enumerate(SIMULATED.items()):
            second = os.path.join(folder, f"{car}_{k}.csv")
            simulated_trip(sof, second, OTHERS[other] if other else battery, 1000 * seed + 10 * (number + 1) + k, soc - LOST_PER_HOUR * hours, WARM_C + warmer)
            yield case, [first, second], 3600.0 * hours


def measured_pairs(data, parked, folder):
    """The same of the real ones."""
    for number, pair in enumerate(PAIRS):
        paths = [os.path.join(folder, f"pair_{number}_{n}.csv") for n in range(2)]
        for path, trip in zip(paths, trips_of(pair, data)):
            recordings.write(path, *trip)
        yield pair, paths, parked


def trips_of(pair, data):
    """The end of the first and the beginning of the second."""
    if isinstance(pair, str):
        whole = recordings.measured(data, pair)
        first, second = ([column[part] for column in whole] for part in (slice(0, len(whole[0]) // 2), slice(len(whole[0]) // 2, None)))
    else:
        first, second = (recordings.measured(data, one) for one in pair)
    keep = lambda columns, mask: [column[mask] for column in columns]
    return (keep(first, first[0] > first[0][-1] - LONGEST_S), keep(second, second[0] < second[0][0] + LONGEST_S))


def played(binary, paths, parked):
    """Rows of `experiment trips`, a list a trip."""
    rows = rows_of([binary, "trips", *paths, "--parked", str(parked)])
    return [[row for row in rows if row["trip"] == os.path.basename(path)] for path in paths]


def of_kind(rows, kind):
    return [row for row in rows if row["kind"] == kind]


def of_age(rows, low, high):
    return [row for row in rows if low <= row["time_s"] < high]


def figures(plays, low, high):
    """Figures of one age over all plays: of shares, errors and widths."""
    plays = [of_age(rows, low, high) for rows in plays]
    every = [row for rows in plays for row in rows]
    valid = of_kind(every, "valid")
    out = {f"valid_{key}_percent": 100.0 * sum(row[column] for row in valid) / len(valid)
           for key, column in (("crank", "measured"), ("stop", "expected"), ("charge", "lower"))}
    for kind in ("crank", "charge"):
        one = pooled(of_kind(every, kind)) or {"count": 0}
        out[kind + "s"] = {key: one.get(key) for key in ("count", "error", "inside_percent", "width")}
    by_past = pooled([row for row in of_kind(every, "charge") if row["by_past"]]) or {"count": 0}
    out["charges_by_past"] = {key: by_past.get(key) for key in ("count", "error", "inside_percent", "width")}
    known = [[row["upper"] for row in of_kind(rows, "valid") if row["upper"] >= 0.0] for rows in plays]
    medians = [np.median(some) for some in known if some]
    out["standing_width_v"] = float(np.median(medians)) if medians else None
    return out


EVENTS = "{count}: {error:.2f}, {inside_percent:.0f} %, {width:.1f}"
HEAD = ("minutes", "valid crank, stop, charge [%]", "cranks: mean error, inside, width [V]", "charges: mean error, inside, width [A]",
        "of these valid by past charges alone")


def cells(age, one):
    events = [EVENTS.format(**one[kind]) if one[kind]["count"] else "0" for kind in ("cranks", "charges", "charges_by_past")]
    return [age, "{valid_crank_percent:.0f}, {valid_stop_percent:.0f}, {valid_charge_percent:.0f}".format(**one), *events]


def stated(second):
    """Sentence on the first valid answers about cranks of second trips."""
    firsts = [min((row["time_s"] for row in of_kind(rows, "valid") if row["measured"]), default=None) for rows in second]
    some = [one for one in firsts if one is not None]
    return f"first valid crank answer: median {np.median(some):.0f} s, latest {max(some):.0f} s; none in {len(firsts) - len(some)} of {len(firsts)}" if some else "no valid crank answer"


def swapped(rows):
    return bool(of_kind(rows, "swap"))


def main(given=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("build")
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument("--data")
    where.add_argument("--simulated", action="store_true")
    parser.add_argument("--parked", type=float, default=43200.0, help="[s] between the real trips")
    parser.add_argument("--seed", type=int, default=1, help="of the simulated trips")
    parser.add_argument("--json")
    a = parser.parse_args(given)
    binary = program(a.build, "experiment")
    pairs, alone = [], []
    with tempfile.TemporaryDirectory() as folder:
        for case, paths, parked in simulated_pairs(a.build, a.seed, folder) if a.simulated else measured_pairs(a.data, a.parked, folder):
            pairs.append((case, played(binary, paths, parked)))
            alone.append((case, played(binary, paths[1:], parked)))
    results = {}
    for which, plays in (("state_file", pairs), ("no_state_file", alone)):
        of_plays = lambda some: {age: figures(some, low, high) for low, high, age in AGES}
        second = {}
        for case, trips in plays:
            second.setdefault("other battery" if a.simulated and SIMULATED[case][2] else "same battery", []).append(trips[-1])
        results[which] = of_plays(second["same battery"])
        for name, some in second.items():
            shown = of_plays(some)
            print(f"second trip, {'state file of the first' if which == 'state_file' else 'no state file'}, {name}: {stated(some)}; taken for another battery in {sum(map(swapped, some))}\n")
            print("\n".join(table(HEAD, [cells(age, one) for age, one in shown.items()])) + "\n")
        if a.simulated and which == "state_file":
            print_cases(pairs)
    write_json(a.json, results)


def print_cases(pairs):
    """Cranks of minutes 0-5 of every case, all cars, and how often another battery was noticed."""
    rows = []
    for case in SIMULATED:
        plays = [trips[-1] for name, trips in pairs if name == case]
        cranks = pooled(of_kind([row for trip in plays for row in of_age(trip, 0.0, 300.0)], "crank"))
        rows.append([case, EVENTS.format(**cranks), f"{sum(map(swapped, plays))} of {len(plays)}"])
    print("\n".join(table(("parked", "cranks of minutes 0-5: mean error, inside, width [V]", "taken for another battery"), rows)) + "\n")
