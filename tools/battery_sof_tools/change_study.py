"""Changes put into measured recordings, and what `sof diagnose --reference` says of them.

    change_study BUILD --data FOLDER [--pairs few|all|quarters] [--responses-only] [--reference-models] [--json FILE] [--spread]
    change_study BUILD --data FOLDER --drives
    change_study BUILD --simulated COUNT [--seed 1] [--json FILE]

Pairs of sound recordings of one battery: the halves of each recording of a vehicle, either one as the reference, and two trips of one car; with `--pairs quarters` every two quarters of a recording. A change is put exactly
into the measured signals of the later one: a contact's resistance (v + R i), a gain and an offset of the current, a delay and a lag of one channel. Where the
voltage is recorded some rows after the current, a contact is put in as late as the voltage, too, as that logger would show it. Controls are the
same pairs with nothing put in; pairs of different vehicles must be called another battery. A change counts as named where it is the first one or among those that
look alike. `--reference-models` gives the reference as the model file that `sof identify` makes of it, in place of the recording. `--spread` prints what the pairs differ by in each quantity that is compared, beside what is assumed: the table of src/diagnosis/change.cpp.
With --drives the stretches of 15 minutes of each recording are the drives of a node, each of the first six in turn the beginning of the reference: how many of the
messages on ~change say that something has changed while nothing has, and how soon a change is named that comes after three sound drives.
With --simulated the pairs are trips of simulated cars. Each sensor's change is put in at the very limit that the answer to the sound pair states
(`detection_limits`), and the battery itself is changed, too (simulated_pairs.py).
"""

import argparse
import collections
import csv
import functools
import itertools
import math
import os
import tempfile
import time

import numpy as np

from . import recordings, simulated_pairs, sof
from .files import write_json
from .progress import followed
from .rates import rate
from .tables import table

# vehicle, recordings with their columns
VEHICLES = {
    "startstop_car": {"drive_1": recordings.CAR, "drive_2": recordings.CAR},
    "other_car": {"other_car_1": recordings.CAR},
    "small_car": {"trip": recordings.COLUMNS},
    "ageing_bench": {"cycles": recordings.COLUMNS},
    "ev_12v": {"load": recordings.COLUMNS},
}
FOLDER = {"other_car": "startstop_car"}
Injected = collections.namedtuple("Injected", "kind strength unit effect few")
LATE_CONTACT = "contact, as late as the voltage,"
EDGE_A = 8.0  # a change of current that counts
CHANGES = [
    *(Injected("contact", r, "mOhm", "contact_resistance", r in (1, 3)) for r in (1, 2, 3, 4, 8)),
    *(Injected(LATE_CONTACT, r, "mOhm", "contact_resistance", r in (3, 8)) for r in (3, 4, 8)),
    *(Injected("gain", g, "%", "current_gain", g == 6) for g in (2, 4, 6, 8)),
    *(Injected("offset", o, "A", "current_offset", o in (0.5, 0.8)) for o in (0.2, 0.5, 0.8, 1.0)),
    Injected("offset", -0.8, "A", "current_offset", False),
    Injected("unseen load", 0.8, "A", "parasitic_load", False),
    *(Injected("current late", n, "rows", "time_skew", n == 2) for n in (1, 2)),
    *(Injected("voltage late", n, "rows", "time_skew", n == 2) for n in (1, 2)),
    Injected("current lags", 2, "s", "sensor_lag", True),
    Injected("contact 4 mOhm, offset", 1.0, "A", "contact_resistance+current_offset", True),
    Injected("voltage lags", 2, "s", "sensor_lag", True),
]
Pair = collections.namedtuple("Pair", "name vehicle then now few")
MODELS = ("reference", "changed", "own")  # as of `explained`


def late(values, rows):
    return np.concatenate((np.repeat(values[:1], rows), values[:len(values) - rows]))


def rows_late(recording, most=3):
    """By how many rows changes of the voltage follow those of the current."""
    _, i, u = recording
    answers = []
    for rows in range(most + 1):
        steps, moved = np.diff(i)[:len(i) - 1 - rows], np.diff(u)[rows:]
        counted = np.abs(steps) > EDGE_A
        answers.append(np.sum(steps[counted] * moved[counted]))
    return int(np.argmax(answers))


def lagging(t, values, constant_s):
    shown = values.copy()
    for n in range(1, len(shown)):
        kept = math.exp(-max(t[n] - t[n - 1], 0.0) / constant_s)
        shown[n] = kept * shown[n - 1] + (1.0 - kept) * values[n]
    return shown


def injected(recording, change):
    """The recording as it would read had the change come before it."""
    t, i, u = recording
    s = change.strength
    return {"contact": lambda: (t, i, u + 1e-3 * s * i), LATE_CONTACT: lambda: (t, i, u + 1e-3 * s * late(i, rows_late(recording))), "contact 4 mOhm, offset": lambda: (t, i + s, u + 4e-3 * i), "gain": lambda: (t, i * (1.0 + 0.01 * s), u), "offset": lambda: (t, i + s, u),
            "unseen load": lambda: (t, i + s, u), "current late": lambda: (t, late(i, s), u), "voltage late": lambda: (t, i, late(u, s)),
            "current lags": lambda: (t, lagging(t, i, s), u), "voltage lags": lambda: (t, i, lagging(t, u, s))}[change.kind]()


def part(recording, first, last):
    t, i, u = recording
    n = len(t)
    cut = slice(int(first * n), int(last * n))
    return t[cut], i[cut], u[cut]


def sound_pairs(data):
    """Pairs of one vehicle, and every whole recording."""
    pairs, whole = [], {}
    for vehicle, files in VEHICLES.items():
        for name, columns in files.items():
            path = os.path.join(data, FOLDER.get(vehicle, vehicle), name + ".csv")
            whole[vehicle, name] = one = recordings.read(path, columns)
            first, second = part(one, 0.0, 0.5), part(one, 0.5, 1.0)
            pairs += [Pair(f"{name}: first half, second half", vehicle, first, second, True), Pair(f"{name}: second half, first half", vehicle, second, first, False)]
        for one, other in itertools.permutations(files, 2):
            then, now = whole[vehicle, one], whole[vehicle, other]
            pairs.append(Pair(f"{one}, {other}", vehicle, then, now, one < other))
            pairs += [Pair(f"{one} half {a + 1}, {other} half {b + 1}", vehicle, part(then, a / 2, (a + 1) / 2), part(now, b / 2, (b + 1) / 2), False)
                      for a in (0, 1) for b in (0, 1) if one < other]
    return pairs, whole


def quarter_pairs(whole):
    """Every two quarters of a recording."""
    return [Pair(f"{name}: quarter {a + 1}, quarter {b + 1}", vehicle, part(one, a / 4, (a + 1) / 4), part(one, b / 4, (b + 1) / 4), True)
            for (vehicle, name), one in whole.items() for a, b in itertools.permutations(range(4), 2)]


def ask(binary, then, now, options=(), model=False):
    """(answer, seconds) of sof diagnose NOW --reference THEN, or the model file of THEN."""
    with tempfile.TemporaryDirectory(prefix="change_") as folder:
        paths = [os.path.join(folder, name) for name in ("now.csv", "then.csv", "answer.json")]
        recordings.write(paths[0], *now)
        recordings.write(paths[1], *then)
        if model:
            recording, paths[1] = paths[1], os.path.join(folder, "then.yaml")
            sof.call([binary, "identify", recording, "--out", paths[1], "--anyway"])
        began = time.monotonic()
        sof.call([binary, "diagnose", paths[0], "--reference", paths[1], "--json", paths[2], *options])
        return sof.read_json(paths[2]), time.monotonic() - began


def diagnosed_s(binary, now):
    """[s] of a diagnosis of the recording alone."""
    with tempfile.TemporaryDirectory(prefix="change_") as folder:
        path = os.path.join(folder, "now.csv")
        recordings.write(path, *now)
        began = time.monotonic()
        sof.call([binary, "diagnose", path])
        return time.monotonic() - began


def is_named(answer, effect):
    """Whether an effect is the first change or looks like it; of two effects, whether they are those that are stated."""
    if "+" in effect:
        return set(effect.split("+")) == {one["id"] for one in answer["changes"]}
    first = answer["changes"][0] if answer["changes"] else {"id": None, "indistinguishable": []}
    return effect == first["id"] or effect in first["indistinguishable"]


def row_of(binary, pair, change, options=(), model=False):
    return told(pair, change, *ask(binary, pair.then, injected(pair.now, change) if change else pair.now, options, model))


def told(pair, change, answer, seconds):
    """The row of an answer of ask(): what it says of a change that was put in, or of None."""
    first = (answer["changes"] or [None])[0]
    scale = {"mOhm": 1e3, "%": 1e2}.get(change.unit, 1.0) if change else 1.0
    holds = None
    if change and first and first["id"] == change.effect:
        low, high = (scale * bound for bound in first["interval"])
        wanted = abs(change.strength) if change.unit in ("rows", "s") else change.strength
        low, high = (sorted((abs(low), abs(high))) if change.unit in ("rows", "s") else (low, high))
        holds = low - 1e-9 <= wanted <= high + 1e-9
    return {"pair": pair.name, "vehicle": pair.vehicle, "kind": change and change.kind, "strength": change and change.strength, "unit": change and change.unit,
            "verdict": answer["verdict"], "stated": len(answer["changes"]), "first": first and first["id"], "named": bool(change) and is_named(answer, change.effect), "interval_holds": holds,
            "gain": answer["explained"]["gain"], "model_distance": answer["explained"]["model_distance"],
            "largest_model_distance": answer["explained"]["largest_model_distance"], "compared": answer["compared"], "seconds": seconds,
            "last_quarter": {model: answer["explained"][model + "_model"]["share_percent"] for model in MODELS}}


def power_table(rows):
    judged = [row for row in rows if row["verdict"] != "insufficient_data"]
    groups, cells = {}, []
    for row in judged:
        if row["kind"]:
            groups.setdefault((row["kind"], row["strength"], row["unit"]), []).append(row)
    for (kind, strength, unit), some in groups.items():
        held = [row["interval_holds"] for row in some if row["interval_holds"] is not None]
        cells.append([f"{kind} {strength:g} {unit}", rate(sum(row["named"] for row in some), len(some)),
                      sum(row["verdict"] == "changed" and not row["named"] for row in some), sum(row["stated"] == 2 for row in some), sum(row["verdict"] == "another_battery" for row in some),
                      f"{sum(held)} of {len(held)}"])
    return table(("put in", "named first or among its look-alikes", "another change named", "a second one stated", "another battery", "90 % interval holds"), cells)


def spread_table(rows):
    """Standard deviation of the difference less what the recordings' own errors make of it, vehicle by vehicle."""
    controls = [row for row in rows if row["kind"] is None]
    names = list(dict.fromkeys(one["id"] for row in controls for one in row["compared"]))
    cells = []
    for name in names:
        by_vehicle = collections.defaultdict(list)
        for row in controls:
            for one in row["compared"]:
                if one["id"] == name:
                    by_vehicle[row["vehicle"]].append(((one["now"] - one["then"]) ** 2 - one["std_error"] ** 2, one["spread"] ** 2))
        pooled = np.mean([np.mean([seen for seen, _ in some]) for some in by_vehicle.values()])
        assumed = np.mean([np.mean([used for _, used in some]) for some in by_vehicle.values()])
        without = [np.mean([np.mean([seen for seen, _ in some]) for vehicle, some in by_vehicle.items() if vehicle != left]) for left in by_vehicle if len(by_vehicle) > 1]
        root = lambda value: f"{math.sqrt(max(value, 0.0)):.4g}"
        cells.append([name, root(pooled), " to ".join(map(root, (min(without), max(without)))) if without else "-", root(assumed)])
    return table(("quantity", "seen between trips", "with a vehicle left out", "assumed"), cells)


def models_table(rows):
    """What the three models explain of the later recording's last quarter, of the changes that were named for what they are."""
    cells = []
    for name in [*dict.fromkeys(row["kind"] for row in rows if row["kind"]), "all"]:
        some = [row["last_quarter"] for row in rows if row["kind"] and name in ("all", row["kind"]) and row["verdict"] == "changed" and row["named"]]
        some = [one for one in some if None not in one.values()]
        if some:
            cells.append([name, len(some), *(f"{np.mean([one[model] for one in some]):.1f} %" for model in MODELS),
                          *(rate(sum(one["changed"] >= one[model] for one in some), len(some)) for model in ("reference", "own"))])
    return table(("change that was named", "cases", "reference explains", "reference with the change", "a fresh fit", "not worse than the reference", "not worse than the fresh fit"), cells)


def times_table(rows):
    cells = [[row["pair"], f"{row['seconds']:.1f} s", f"{row['diagnosed_s']:.1f} s", f"{row['seconds'] / row['diagnosed_s']:.2f}"] for row in rows if "diagnosed_s" in row]
    return table(("pair, nothing put in", "against the reference", "diagnosis of the later recording alone", "ratio"), cells)


def report(rows, others, with_spread):
    controls = [row for row in rows if row["kind"] is None]
    judged = [row for row in controls if row["verdict"] != "insufficient_data"]
    lines = power_table(rows)
    lines += ["", "Nothing put in, said to have changed: " + rate(sum(row["verdict"] == "changed" for row in judged), len(judged)),
              "Nothing put in, called another battery: " + rate(sum(row["verdict"] == "another_battery" for row in judged), len(judged)),
              f"Not judged: {len(controls) - len(judged)} of {len(controls)} pairs",
              "Another vehicle as the reference, called another battery: " + rate(sum(row["verdict"] == "another_battery" for row in others), len(others)),
              f"Time of an answer: median {np.median([row['seconds'] for row in rows + others]):.1f} s, longest {max(row['seconds'] for row in rows + others):.1f} s"]
    text = lambda value, digits: "-" if value is None else f"{value:.{digits}f}"
    lines += ["", *table(("control", "verdict", "first", "gain", "model distance", "largest of one battery"),
                         [[row["pair"], row["verdict"], row["first"], text(row["gain"], 1), text(row["model_distance"], 2), text(row["largest_model_distance"], 2)] for row in controls + others])]
    if any("diagnosed_s" in row for row in rows):
        lines += ["", *models_table(rows), "", *times_table(rows)]
    return lines + (["", *spread_table(rows)] if with_spread else [])


# What is put in at the stated limit of an effect, and how many of its units are one of the answer's.
AT_LIMIT = {"contact_resistance": ("contact", "mOhm", 1e3), "current_gain": ("gain", "%", 1e2), "current_offset": ("offset", "A", 1.0),
            "time_skew": ("voltage late", "rows", None), "sensor_lag": ("voltage lags", "s", 1.0)}


def at_limits(answer, interval_s):
    """The changes of a sensor that the answer says it would have named in nine cases of ten."""
    for limit in answer["detection_limits"]:
        kind, unit, scale = AT_LIMIT[limit["id"]]
        rows = max(1, round(limit["strength"] / interval_s)) if scale is None else None
        yield Injected(kind, rows or scale * limit["strength"], unit, limit["id"], False)


def simulated_rows(binary, seed, number):
    """Rows of one simulated car: nothing put in, each limit, each change of the battery."""
    then, now = simulated_pairs.drawn_pair(f"{seed}/{number}")
    name, options = f"car {number}", ["--responses-only"]
    with tempfile.TemporaryDirectory(prefix="pair_") as folder:
        reference, sound = (simulated_pairs.recorded(binary, trip, folder) for trip in (then, now))
        pair = Pair(name, name, reference, sound, True)
        answer, seconds = ask(binary, reference, sound, options)
        rows = [told(pair, None, answer, seconds)]
        rows += [row_of(binary, pair, change, options) for change in at_limits(answer, float(np.median(np.diff(sound[0]))))]
        for change in simulated_pairs.BATTERY_CHANGES:
            changed = pair._replace(now=simulated_pairs.recorded(binary, simulated_pairs.with_change(now, change.name), folder))
            said, seconds = ask(binary, reference, changed.now, options)
            rows.append(dict(told(changed, None, said, seconds), battery=change.name, named=bool(change.effect) and is_named(said, change.effect)))
    return rows


def simulated_report(rows):
    sensor = [row for row in rows if "battery" not in row]
    controls = [row for row in sensor if row["kind"] is None]
    effects = {kind: effect for effect, (kind, *_) in AT_LIMIT.items()}
    cells = []
    for kind, effect in effects.items():
        some = [row for row in sensor if row["kind"] == kind]
        held = [row["interval_holds"] for row in some if row["interval_holds"] is not None]
        strengths = [row["strength"] for row in some]
        cells.append([effect, f"{np.median(strengths):.3g} ({min(strengths):.3g} to {max(strengths):.3g}) {some[0]['unit']}" if some else "never stated", rate(sum(row["named"] for row in some), len(some)),
                      sum(row["verdict"] == "changed" and not row["named"] for row in some), rate(sum(held), len(held))])
    lines = table(("put in at its stated limit", "limit: median (range)", "named first or among its look-alikes", "another change named", "90 % interval holds"), cells)
    cells = []
    for change in simulated_pairs.BATTERY_CHANGES:
        some = [row for row in rows if row.get("battery") == change.name]
        names = collections.Counter(row["first"] or row["verdict"] for row in some)
        cells.append([change.name, rate(sum(row["named"] for row in some), len(some)) if change.effect else "no candidate", ", ".join(f"{name} {count}" for name, count in names.most_common())])
    lines += ["", *table(("change of the battery", "named first or among its look-alikes", "first change or verdict"), cells)]
    judged = [row for row in controls if row["verdict"] != "insufficient_data"]
    return lines + ["", "Nothing changed, said to have changed: " + rate(sum(row["verdict"] == "changed" for row in judged), len(judged)), f"Not judged: {len(controls) - len(judged)} of {len(controls)} pairs"]


def measure_simulated(binary, args):
    work = functools.partial(simulated_rows, binary, args.seed)
    rows = list(itertools.chain.from_iterable(sof.side_by_side(work, range(1, args.simulated + 1), "cars")))
    return {"rows": rows}, simulated_report(rows)


DRIVES_UNTIL = (2, 5, 8)  # drives with the change, after which it is looked for


def drives_of(program, data, options):
    """Messages of a node, recording by recording."""
    rows = []
    for vehicle, files in VEHICLES.items():
        for name, columns in files.items():
            path = os.path.join(data, FOLDER.get(vehicle, vehicle), name + ".csv")
            named = [part for option, column in zip(("time", "current", "voltage"), columns) for part in (f"--{option}-column", column)]
            rows += csv.DictReader(sof.call([program, "changes", path, *named, *options]).splitlines())
    return rows


def measure_drives(program, args):
    lines, sound = [], {}
    for reference, options in (("five drives", []), ("one drive, for comparison", ["--one-drive"])):
        rows = sound[reference] = drives_of(program, args.data, options)
        changed = [row for row in rows if row["verdict"] == "changed"]
        runs = lambda some: len({(row["recording"], row["reference"]) for row in some})
        lines += [f"Reference of {reference}. Nothing put in: {rate(len(changed), len(rows))} of the messages say that something has changed, "
                  f"those of {rate(runs(changed), runs(rows))} of the references.", ""]
        cells = []
        for option, strengths, unit, effect in (("contact", (0.003, 0.005), "Ohm", "contact_resistance"), ("offset", (0.8, 1.6), "A", "current_offset")):
            for strength in strengths:
                by_run = collections.defaultdict(list)
                for row in drives_of(program, args.data, [f"--{option}", str(strength), "--after", "3", *options]):
                    if row["is_changed"] == "1":
                        by_run[row["recording"], row["reference"]].append(row)
                for drives in DRIVES_UNTIL:
                    some = [run[drives - 1] for run in by_run.values() if len(run) >= drives]
                    said = [row for row in some if row["verdict"] == "changed"]
                    right = sum(row["first"] == effect for row in said)
                    cells.append([f"{option} {strength:g} {unit}", drives, rate(right, len(some)), len(said) - right])
        lines += [*table(("put in after three sound drives", "drives with it", "named first", "another change named"), cells), ""]
    return {"sound": sound}, lines


def measure_real(binary, args):
    pairs, whole = sound_pairs(args.data)
    is_few = args.pairs != "all"
    pairs = quarter_pairs(whole) if args.pairs == "quarters" else [pair for pair in pairs if pair.few or not is_few]
    changes = [None] + [change for change in CHANGES if not args.controls and (change.few or not is_few)]
    firsts = {vehicle: next(one for (of, _), one in whole.items() if of == vehicle) for vehicle in VEHICLES}
    is_every = args.controls or not is_few
    share = 0.25 if args.pairs == "quarters" else 0.5
    other = [Pair(f"{now} against {then}", now, part(firsts[then], 0.0, share), part(firsts[now], 0.0, share), True)
             for then, now in itertools.permutations(VEHICLES, 2) if is_every or list(VEHICLES).index(now) == (list(VEHICLES).index(then) + 1) % len(VEHICLES)]
    cases = [(pair, change) for pair in pairs for change in changes if not (change and change.kind == LATE_CONTACT) or rows_late(pair.now)]
    options = ["--responses-only"] * args.responses_only
    rows = [row_of(binary, *case, options, args.reference_models) for case in followed(cases, "compared")]
    if not args.responses_only and not args.controls:
        for row, (pair, change) in followed(list(zip(rows, cases)), "diagnosed"):
            if change is None:
                row["diagnosed_s"] = diagnosed_s(binary, pair.now)
    others = [] if args.responses_only else [row_of(binary, pair, None, model=args.reference_models) for pair in followed(other, "other vehicles")]
    return {"rows": rows, "other_vehicles": others}, report(rows, others, args.spread)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build")
    of = parser.add_mutually_exclusive_group(required=True)
    of.add_argument("--data", help="folder of the measured recordings")
    of.add_argument("--simulated", type=int, metavar="COUNT", help="pairs of simulated cars in place of measured ones")
    parser.add_argument("--seed", type=int, default=1, help="of the simulated cars")
    parser.add_argument("--pairs", choices=("few", "all", "quarters"), default="few", help="few: one pair a recording and half of the strengths, ten minutes; all: an hour; quarters: every two quarters of a recording, half of the strengths")
    parser.add_argument("--drives", action="store_true", help="messages of a node over the recordings' stretches; needs --data")
    parser.add_argument("--responses-only", action="store_true", help="as of sof: no models, so other vehicles are left out")
    parser.add_argument("--reference-models", action="store_true", help="the references are model files")
    parser.add_argument("--controls", action="store_true", help="nothing put in and other vehicles alone, without the times of a diagnosis")
    parser.add_argument("--spread", action="store_true", help="what the quantities differ by between trips, beside what is assumed")
    parser.add_argument("--json", help="file to write every case to")
    args = parser.parse_args()
    if args.drives:
        cases, lines = measure_drives(sof.program(args.build, "experiment"), args)
    else:
        cases, lines = (measure_simulated if args.simulated else measure_real)(sof.program(args.build, "sof"), args)
    if args.json:
        write_json(args.json, cases)
    print("\n".join(lines))
