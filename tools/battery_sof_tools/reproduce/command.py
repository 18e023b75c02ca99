"""Repeats the paper's section V on simulated recordings and writes archive/reproduction.md with its pictures into a folder (BUILD/reproduction).

Usage: reproduce BUILD_FOLDER [--seeds N] [--docs FOLDER] [--json FILE]. Data sets 1 to 3 are simulated with the reference (Fig. 4), identified and
predicted with `sof`; `window_experiment` fits data set 1's eleven windows under every setting of the factor experiment.
"""

import argparse
import concurrent.futures
import os
import tempfile

from ..files import write_json, write_text
from . import pictures
from .data import SETS, Tools, experiment, fit_and_predict, progress, scenario, simulate
from .page import PAGE, figures, second_set, third_set
from .pictures import picture_excitation, picture_impedance, picture_prediction, picture_windows
from .tables import stretch


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("build")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--docs", help="folder that archive/ and pictures/ are written into; BUILD/reproduction unless given")
    parser.add_argument("--json", help="file to write the page's numbers to")
    args = parser.parse_args()
    args.docs = args.docs or os.path.join(args.build, "reproduction")
    pictures.PICTURES = os.path.join(args.docs, "pictures")
    for folder in (pictures.PICTURES, os.path.join(args.docs, "archive")):
        os.makedirs(folder, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        tools = Tools(os.path.abspath(args.build), folder)
        jobs = [(name, seed) for name in SETS for seed in range(1, args.seeds + 1)]
        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            files = dict(zip(jobs, pool.map(lambda job: simulate(tools, *job), jobs)))
        of = {name: [files[(name, seed)] for seed in range(1, args.seeds + 1)] for name in SETS}
        rows = experiment(tools, of["data_set_1"])
        _, _, hour = fit_and_predict(tools, of["data_set_1"][0], (720, 960), (0, 3600))
        first = stretch(hour, 2400, 3000)
        second, second_fig4 = second_set(tools, of["data_set_2"]), second_set(tools, of["data_set_2_fig4"])
        third = third_set(tools, of["data_set_3"])
        tools.run(tools.sof, "simulate", scenario(tools, "data_set_1"), tools.path("unused.csv"), "--duration", "1",
                  "--impedance", tools.path("impedance.csv"))
        impedance_error = picture_impedance(tools.path("impedance.csv"))
        picture_excitation(stretch(hour, 0, 1700))
        picture_prediction(first, "Data set 1, window 3: 40 to 50 min", "reproduction_fig6.png")
        picture_windows(rows, "data_set_1_1.csv")
        picture_prediction(stretch(second[0]["data"], 2250, 2400), "Data set 2: 37.5 to 40 min", "reproduction_fig9.png")
        picture_prediction(stretch(second[0]["data"], 3535, 3600), "Data set 2: the last minute", "reproduction_fig10.png")
        picture_prediction(third[0]["data"], "Data set 3: 6 to 12 min", "reproduction_fig11.png")
        found = figures(rows, first, second, second_fig4, third, impedance_error, args.seeds)
        write_text(os.path.join(args.docs, "archive", "reproduction.md"), PAGE.format(**found))
        if args.json:
            write_json(args.json, {key: value for key, value in found.items() if not isinstance(value, str)})
    progress(os.path.join(args.docs, "archive", "reproduction.md") + " written")
    return 0
