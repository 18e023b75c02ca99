"""Times the node's answers under load. Usage: bench_queries BUILD_FOLDER [SECONDS]

A simulated drive arrives at 100 Hz, 200 questions a second of the three kinds come in, and
identifications run one after the other. Printed are the node's own times as it reports them in
/diagnostics (work of a question from its callback's beginning to its end; delay of a sample from
its arrival to the end of its callback) and what a client waits. Once with the base model, once with
a model of four effects. Before that, the questions alone on the same models (query_bench).
"""

import os
import subprocess
import sys
import tempfile

from .files import ROOT
from .sof import run
from .stress.load import Load, under_load
from .stress.ros import Processes, end, node_of_this_process

LEARNT = 300.0  # [s] of the drive before the load begins
EFFECTS = "charge_acceptance,gassing,ocv_soc,current_dependent_resistance"


def shown(title, duration, seen):
    """Lines on what was seen under load."""
    codes = ", ".join(f"{count} of code {code}" for code, count in sorted(seen.codes.items()))
    (kind, runs, accepted), = seen.runs
    identified = f"in the node, {accepted} accepted" if kind == "identify" else "beside the node"
    median, late = seen.waits[len(seen.waits) // 2], seen.waits[int(0.99 * (len(seen.waits) - 1))]
    p99, longest, delay_p99 = (seen.values[key + " [ms]"] for key in (
        "query work p99", "query work longest", "sample delay p99"))
    return (f"{title}: {len(seen.waits)} questions in {duration:.0f} s ({codes}), "
            f"{runs} identifications {identified}\n"
            f"    work of a question: 99 % within {p99:.2f} ms, longest {longest:.2f} ms; "
            f"a client in Python waits {median:.2f} ms (median), {late:.2f} ms (99 %)\n"
            f"    delay of a sample: 99 % within {delay_p99:.2f} ms, longest {seen.longest:.2f} ms")


def load(tools, folder, drive, model, duration):
    """One node with each model, one after the other. model: of four effects."""
    beside = ["nice", "-n", "10", os.path.join(tools, "sof"), "identify", drive,
              "--to", str(LEARNT), "--effects", EFFECTS,
              "--out", os.path.join(folder, "other.yaml")]
    lives = (("base model", 0.0, [], "identify"),
             ("base + " + EFFECTS.replace(",", ", "), LEARNT, ["_state_file:=" + model], beside))
    with Processes(folder) as processes:
        rospy = node_of_this_process("bench_queries")
        for title, first, parameters, work in lives:
            node = processes.start(os.path.join(tools, "battery_sof_node"), *parameters)
            try:
                load_of = Load(drive, first, LEARNT, 100.0, 1, 4, 200.0, duration)
                seen = under_load(rospy, load_of, [work])
            finally:
                end(node)
            print(shown(title, duration, seen), flush=True)


def main():
    if len(sys.argv) not in (2, 3):
        print(__doc__, file=sys.stderr)
        return 2
    tools = os.path.join(os.path.abspath(sys.argv[1]), "devel", "lib", "battery_sof")
    duration = float(sys.argv[2]) if len(sys.argv) == 3 else 20.0
    scenario = os.path.join(ROOT, "config", "scenarios", "city_drive.yaml")
    sof = os.path.join(tools, "sof")
    with tempfile.TemporaryDirectory() as folder:
        drive, base, model = (os.path.join(folder, name)
                              for name in ("drive.csv", "base.yaml", "effects.yaml"))
        run([sof, "simulate", scenario, drive, "--duration", str(2.0 * LEARNT + duration + 60.0)])
        run([sof, "identify", drive, "--to", str(LEARNT), "--out", base])
        run([sof, "identify", drive, "--to", str(LEARNT), "--out", model, "--effects", EFFECTS])
        subprocess.run([os.path.join(tools, "query_bench"), base, model], check=True)
        load(tools, folder, drive, model, duration)
    return 0
