"""Recordings of the data sets, and what `sof` and the experiment say of them."""

import concurrent.futures
import csv
import json
import os
import subprocess
import sys

from ..files import ROOT
from ..sof import program

SETS = ("data_set_1", "data_set_2", "data_set_2_fig4", "data_set_3")


class Tools:
    """The programs under test, and a folder for what they write."""

    def __init__(self, build, folder):
        self.sof = program(build, "sof")
        self.experiment = os.path.join(build, "window_experiment")
        if not os.path.exists(self.experiment):
            self.experiment = os.path.join(build, "devel", "lib", "battery_sof", "window_experiment")
        self.folder = folder

    def path(self, name):
        return os.path.join(self.folder, name)

    def run(self, *command):
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit("{}: exit {}\n{}".format(" ".join(command), done.returncode, done.stderr))
        return done.stdout


def progress(text):
    print("reproduce: " + text, file=sys.stderr, flush=True)


def scenario(tools, name):
    """Path of a scenario; data_set_2_fig4 is data set 2 without what Fig. 4 lacks."""
    shipped = os.path.join(ROOT, "config", "scenarios", name.replace("_fig4", "") + ".yaml")
    if not name.endswith("_fig4"):
        return shipped
    with open(shipped) as file:
        text = file.read()
    assert "charge_acceptance: true" in text
    changed = tools.path(name + ".yaml")
    with open(changed, "w") as file:
        file.write(text.replace("charge_acceptance: true", "charge_acceptance: false"))
    return changed


def simulate(tools, name, seed):
    out = tools.path("{}_{}.csv".format(name, seed))
    tools.run(tools.sof, "simulate", scenario(tools, name), out, "--seed", str(seed))
    progress("{} seed {} simulated".format(name, seed))
    return out


def fit_and_predict(tools, recording, window, ahead):
    """identify on a window, predict a stretch: the model's JSON, the prediction's JSON and its samples."""
    model, samples = recording + ".yaml", recording + ".prediction"
    fit = tools.run(tools.sof, "identify", recording, "--from", str(window[0]), "--to", str(window[1]), "--out", model,
                    "--json", "-")
    scores = tools.run(tools.sof, "predict", model, recording, "--from", str(ahead[0]), "--to", str(ahead[1]), "--csv",
                       samples, "--json", "-")
    return json.loads(fit), json.loads(scores), read_columns(samples)


WORDS = ("driven_by",)  # columns that hold no numbers


def read_columns(path):
    with open(path, newline="") as file:
        reader = csv.reader(file)
        columns = dict(zip(next(reader), zip(*reader)))
    return {name: [float(value) for value in values] for name, values in columns.items() if name not in WORDS}


def experiment(tools, recordings):
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        texts = list(pool.map(lambda r: tools.run(tools.experiment, r), recordings))
    rows = []
    for recording, text in zip(recordings, texts):
        rows += list(csv.DictReader(text.splitlines()))
    progress("{} fits of data set 1's windows scored".format(len(rows)))
    return rows
