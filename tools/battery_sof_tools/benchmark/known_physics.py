"""What is said of batteries whose physics is known, but written by equations that the product does not have.

    scripts/known_physics BUILD --kind deep_cycle|behind_charger|alternator --out DIR [--seed 1] [--count 40] [--given EFFECT ...] [--jobs 2] [--json FILE]

deep_cycle: porous blocks that are run down and charged on a bench; the commands get the capacity that a block had when it was new, 1 / 0.75 to 1 / 1.05
of what it has. behind_charger: an hour of a start-stop car at one sample a second, whose charge
acceptance follows from the surface of dissolving crystals; its charge is planned, and the voltage is rarely held. alternator: the same physics behind an alternator
that holds the voltage at set points that follow the driving (simulated_pairs.py); the mechanism is charge acceptance. Draws cases (`draw_scenario`), diagnoses each and identifies it with its nominal capacity
given: whether the first mechanism is true of it, what is left on the last quarter beside the circuit, a line fit and a ridge, and of deep cycles whether
the capacity's 90 % interval holds the charge that the block gives from full to 10.5 V at its discharge current. --given: what each effect explains where it
is given (`sof diagnose --given`), a true one or a placebo, on the same cases.
"""

import argparse
import functools
import json
import os
import random
import statistics
import tempfile

from .. import recordings, simulated_pairs
from ..files import read_json, write_json
from ..rates import rate
from ..sof import RECORDING, call, catalogue, diagnose, program, run
from ..tables import table
from .generator import seed_of
from .runner import ANSWERS, complete, kept_for

PATIENCE_S = 600.0
COLUMNS = ("case", "verdict", "effects", "first mechanism", "circuit [mV]", "extended [mV]", "line [mV]", "ridge [mV]", "shares [%]", "charge it holds [Ah]", "stated [Ah]")
MODELS = ("circuit", "extended", "line", "ridge")

DEEP = "deep_cycle"
LEFT_OF_NEW = (0.75, 1.05)  # shares of the capacity that batteries in use have
DRAWN = {DEEP: ("--kind", DEEP), "behind_charger": ("--kind", "effect", "--id", "fresh_sulphate", "--rate", "1", "--duration", "3600")}  # options of draw_scenario
ALTERNATOR = "alternator"
KINDS = (*DRAWN, ALTERNATOR)


def drawn(build, kind, seed, folder):
    """(recording, what is true of it) of a case."""
    recording, label = (os.path.join(folder, name) for name in (RECORDING, "label.json"))
    if kind == ALTERNATOR:
        trip, _ = simulated_pairs.drawn_pair(f"{ALTERNATOR}/{seed}")
        recordings.write(recording, *simulated_pairs.recorded(program(build, "sof"), trip, folder))
        return recording, {"mechanisms": ["acceptance"], "nominal_ah": trip["battery"]["capacity_ah"]}
    run([program(build, "draw_scenario"), *DRAWN[kind], "--seed", str(seed), "--out", recording, "--label", label])
    return recording, read_json(label)


def nominal_of(kind, seed, truth):
    """The capacity that the commands are given [Ah]."""
    capacity = truth.get("nominal_ah") or truth["truth"]["battery"]["capacity_ah"]
    return capacity / random.Random(seed).uniform(*LEFT_OF_NEW) if kind == DEEP else capacity


def mechanisms_of(label, known):
    """Those that are true of a case."""
    return label.get("mechanisms") or sorted({known.mechanism(one) for one in label["expected"]["effects"]})


def holdouts(said):
    """What the circuit and the extended model come to on the last quarter; empty without a fit."""
    return [said["fit"][model]["holdout"] if said["fit"] else {} for model in ("base", "extended")]


def shares_of(said):
    """Explained variation of the last quarter, circuit and extended model [%]; None where no charger holds the voltage."""
    return [holdout.get("share_percent") for holdout in holdouts(said)]


def answered(build, kind, given, case):
    """What the two commands say of a case, and what is true."""
    sof = program(build, "sof")
    with tempfile.TemporaryDirectory(prefix="known_") as folder:
        model = os.path.join(folder, "model.yaml")
        recording, truth = drawn(build, kind, case["seed"], folder)
        nominal = nominal_of(kind, case["seed"], truth)
        capacity = ("--capacity-ah", f"{nominal:.6g}")
        said = diagnose(sof, recording, *capacity, patience_s=PATIENCE_S)
        with_given = {one: shares_of(diagnose(sof, recording, *capacity, "--given", one, patience_s=PATIENCE_S))[1] for one in given}
        fitted = json.loads(call([sof, "identify", recording, "--out", model, "--json", "-", *capacity], patience_s=PATIENCE_S))
    compared = (*holdouts(said), said["baseline_line"] or {}, said["baseline"] or {})
    stated = [fitted.get(key) for key in ("capacity_ah", "capacity_lower_ah", "capacity_upper_ah")]
    return {"mechanisms": mechanisms_of(truth, catalogue(sof)), "plan": truth.get("plan"), "usable_ah": truth.get("usable_ah"), "verdict": said["verdict"],
            "effects": [one["id"] for one in said["effects"]], "mechanism": said["mechanism"], "likely": [one["id"] for one in said["mechanisms"]], "held_v": {name: one.get("rmse_v") for name, one in zip(MODELS, compared)},
            "shares": shares_of(said), "given": with_given, "capacity_ah": None if None in stated else stated}


def error_of(row, name):
    """What is left on the last quarter: of the variation where a charger holds the voltage, else RMS."""
    share = row["shares"][MODELS.index(name)] if name in MODELS[:2] else None
    return 100.0 - share if share is not None else row["held_v"][name]


def figures(rows):
    """Counts over rows of answered()."""
    judged = [row for row in rows if "failed" not in row]
    right = [row for row in judged if row["mechanism"] in row["mechanisms"]]
    stated = [row for row in judged if row["capacity_ah"] and row["usable_ah"]]
    holds = [row for row in stated if row["capacity_ah"][1] <= row["usable_ah"] <= row["capacity_ah"][2]]
    ahead = {}
    for name in ("circuit", "ridge"):
        compared = [row for row in judged if row["held_v"]["extended"] is not None and row["held_v"][name] is not None and (name != "ridge" or row["shares"][1] is None)]
        ahead |= {f"beside_{name}": len(compared), f"not_behind_{name}": sum(error_of(row, "extended") <= 1.001 * error_of(row, name) for row in compared)}
    explained = [row for row in judged if None not in (*row["shares"], *row["given"].values())]
    return {"cases": len(rows), "answered": len(judged), "right": len(right), "wrong": sum(row["mechanism"] is not None for row in judged) - len(right),
            "in_set": sum(bool(set(row["likely"]) & set(row["mechanisms"])) for row in judged),
            "stated": len(stated), "held": len(holds),
            "explained": [statistics.mean(column) for column in zip(*(row["shares"] for row in explained))],
            "given": {one: statistics.mean(row["given"][one] for row in explained) for one in (explained[0]["given"] if explained else ())},
            "width": statistics.median((row["capacity_ah"][2] - row["capacity_ah"][1]) / row["usable_ah"] for row in stated) if stated else None, **ahead}


def told(row):
    if "failed" in row:
        return (row["name"], row["failed"], *[""] * (len(COLUMNS) - 2))
    held = ["-" if row["held_v"][name] is None else f"{1e3 * row['held_v'][name]:.0f}" for name in MODELS]
    shares = " -> ".join(f"{one:.0f}" for one in row["shares"] if one is not None)
    stated = "{:.1f} ({:.1f} to {:.1f})".format(*row["capacity_ah"]) if row["capacity_ah"] else "-"
    return (", ".join(filter(None, (row["name"], row["plan"]))), row["verdict"], ", ".join(row["effects"]), row["mechanism"] or "-", *held, shares or "-",
            f"{row['usable_ah']:.1f}" if row["usable_ah"] else "-", stated)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build")
    parser.add_argument("--kind", choices=KINDS, required=True)
    parser.add_argument("--out", required=True, help="folder of answers: a run that was cut off goes on")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--given", nargs="*", default=[], metavar="EFFECT", help="effects that are given in turn")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--json", help="file of figures")
    a = parser.parse_args()
    kept_for(a.out, program(a.build, "sof"))
    cases = [{"name": f"{a.kind}_{k:03d}", "seed": seed_of(a.seed, a.kind, k)} for k in range(1, a.count + 1)]
    rows = complete(os.path.join(a.out, "_".join((a.kind, *a.given, ANSWERS))), functools.partial(answered, a.build, a.kind, a.given), cases, a.jobs, "diagnosed")
    found = figures([rows[case["name"]] for case in cases])
    print("\n".join(table(COLUMNS, [told(rows[case["name"]]) for case in cases])))
    print(f"\nmechanism right {rate(found['right'], found['answered'])}, wrong {found['wrong']}, in the set of likely ones {rate(found['in_set'], found['answered'])}; not behind the circuit "
          f"{rate(found['not_behind_circuit'], found['beside_circuit'])}, the ridge {rate(found['not_behind_ridge'], found['beside_ridge'])}; "
          + ("explained {:.1f} -> {:.1f} %; ".format(*found["explained"]) if found["explained"] else "")
          + "".join(f"given {one} {share:.1f} %; " for one, share in found["given"].items()) +
          f"capacity stated for {found['stated']}, its interval holds {rate(found['held'], found['stated'])}")
    if a.json:
        write_json(a.json, found)
    return 0
