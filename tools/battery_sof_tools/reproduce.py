"""Repeats the paper's section V on simulated recordings and prints it beside the paper's figures.

    reproduce BUILD [--seeds N] [--json FILE]

Data sets 1 and 3 are simulated by the reference (the paper's Fig. 4, at 1 kHz, filtered to 100 Hz,
with noise), identified and predicted with `sof`: batteries of the paper were never published.
`window_experiment` fits data set 1's eleven windows of four minutes under every setting and scores
each on the whole hour. Start values and bounds are the paper's Table I.
"""

import argparse
import json
import os
import statistics
import tempfile

import numpy as np

from .files import ROOT, write_json
from .sof import program, rows_of, run, side_by_side, simulate
from .tables import table

SETS = ("data_set_1", "data_set_3")
WITH_EFFECTS = "with S1 and S3"  # cpe2 and current_dependent_resistance, for window_experiment
LOW_Q, HIGH_CRANK = 85.0, 0.03   # aims of a window: Q_dyn over the hour [%], mean crank error [V]


class Recordings:
    """Data sets by name and seed, simulated into a folder."""

    def __init__(self, build, folder, seeds):
        self.sof, self.folder, self.seeds = program(build, "sof"), folder, range(1, seeds + 1)

    def path(self, name, seed):
        return os.path.join(self.folder, f"{name}_{seed}.csv")

    def simulate(self):
        simulate(self.sof, [(os.path.join(ROOT, "config", "scenarios", name + ".yaml"), self.path(name, seed), seed)
                            for name in SETS for seed in self.seeds])

    def predicted(self, name, seed, window, ahead):
        """Scores of a window's model [s] on a later stretch; time [s], current [A], error [V]."""
        recording = self.path(name, seed)
        model, samples = recording + ".yaml", recording + ".ahead"
        window, ahead = (["--from", str(begin), "--to", str(end)] for begin, end in (window, ahead))
        run([self.sof, "identify", recording, *window, "--out", model])
        ahead += ["--csv", samples, "--json", "-"]
        scores = run([self.sof, "predict", model, recording, *ahead])
        t, i, u, expected = np.loadtxt(samples, delimiter=",", skiprows=1, usecols=range(4)).T
        return json.loads(scores), t, i, u - expected


def experiment(build, recordings):
    """Rows of window_experiment, of all seeds of data set 1."""
    binary = program(build, "window_experiment")
    paths = [recordings.path("data_set_1", seed) for seed in recordings.seeds]
    return sum(side_by_side(lambda path: rows_of([binary, path]), paths, "hour of windows"), [])


def column(rows, setting, name):
    return [row[name] for row in rows if row["setting"] == setting]


def third_set(recordings):
    found = {"q": [], "low": [], "high": [], "cranks": []}
    for seed in recordings.seeds:
        scores, _, _, error = recordings.predicted("data_set_3", seed, (0, 360), (360, 720))
        found["q"].append(scores["q_dyn_percent"])
        found["low"].append(float(np.min(error)))
        found["high"].append(float(np.max(error)))
        found["cranks"] += [abs(one["measured_min_v"] - one["predicted_min_v"])
                            for one in scores["cranks"]]
    return found


def figures(rows, third):
    q, crank = (column(rows, "default", name) for name in ("q_hour_percent", "crank_mae_v"))
    on_edge = column(rows, "paper, start on an edge", "q_hour_percent")
    return {"n": len(q), "qmin": min(q), "qmax": max(q), "qmed": statistics.median(q),
            "qlow": sum(one < LOW_Q for one in q), "cmed": statistics.median(crank),
            "cmax": max(crank), "chigh": sum(one > HIGH_CRANK for one in crank),
            "edge60": sum(one < 60.0 for one in on_edge),
            "qmin_s": min(column(rows, WITH_EFFECTS, "q_hour_percent")),
            "low": min(third["low"]), "high": max(third["high"]),
            "crank3": statistics.mean(third["cranks"]),
            "crank3sd": statistics.pstdev(third["cranks"]),
            "q3min": min(third["q"]), "q3max": max(third["q"])}


def comparison(of, first_error):
    """Rows of the table beside the paper."""
    return [
        ("Q_dyn over the hour (Fig. 7) [%]", "windows 1, 2, 3, 6, 7: above 80; 5, 9: below 60",
         "{qmin:.1f} to {qmax:.1f}, median {qmed:.1f}; {qlow} of {n} below 85".format(**of)),
        ("the same, the paper's start on an edge", "", "{edge60} of {n} below 60".format(**of)),
        ("the same, with cpe2 and current_dependent_resistance", "",
         "{qmin_s:.1f} and more".format(**of)),
        ("crank error (Fig. 8) [V]", "window 3: below 0.05",
         "median {cmed:.3f}, worst {cmax:.3f}; {chigh} of {n} above 0.03".format(**of)),
        ("error 40 to 50 min, window 3 (Fig. 6) [V]", "within +-0.2", f"{min(first_error):+.2f} to {max(first_error):+.2f}"),
        ("data set 3: error bounds (Fig. 11) [V]", "-0.3 to +0.5",
         "{low:+.2f} to {high:+.2f}".format(**of)),
        ("crank error [V]", "0.10 (deviation 0.05)",
         "{crank3:.3f} (deviation {crank3sd:.3f})".format(**of)),
        ("Q_dyn [%]", "", "{q3min:.1f} to {q3max:.1f}".format(**of))]


def factor_rows(rows):
    """One row a setting: worst, median and best Q_dyn over the hour, crank errors."""
    for name in dict.fromkeys(row["setting"] for row in rows):
        q, crank = column(rows, name, "q_hour_percent"), column(rows, name, "crank_mae_v")
        yield (name, len(q), f"{min(q):.1f}, {statistics.median(q):.1f}, {max(q):.1f}",
               sum(one < 60.0 for one in q), sum(one < LOW_Q for one in q),
               f"{statistics.median(crank):.3f}, {max(crank):.3f}",
               sum(one > HIGH_CRANK for one in crank))


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--json", help="file to write the figures to")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        recordings = Recordings(args.build, folder, args.seeds)
        recordings.simulate()
        rows = experiment(args.build, recordings)
        _, t, _, error = recordings.predicted("data_set_1", 1, (720, 960), (0, 3600))
        found = figures(rows, third_set(recordings))
        beside = comparison(found, error[(t >= 2400) & (t <= 3000)])
    print("\n".join(table(("figure", "paper", f"here, {args.seeds} seeds"), beside)) + "\n")
    head = ("setting", "windows", "Q_dyn, hour: worst, median, best [%]", "below 60 %",
            "below 85 %", "crank error: median, worst [V]", "above 0.03 V")
    print("\n".join(table(head, factor_rows(rows))))
    write_json(args.json, found)
