"""The node's answers under load.

A simulated drive arrives at 100 Hz, 200 questions a second of the three kinds come in, and
identifications run one after the other. Printed are the node's own times as it reports them in
/diagnostics (work of a question from its callback's beginning to its end; delay of a sample from
its arrival to the end of its callback) and what a client waits. Once with the base model, once with
a model of four effects. Before that, the questions alone on the same models (query_bench).
"""

import os

from ..files import ROOT
from ..sof import run
from .load import Load, under_load, waited
from .ros import Processes, end, node_of_this_process

LEARNT = 300.0  # [s] of the drive before the load begins
EFFECTS = "charge_acceptance,gassing,ocv_soc,current_dependent_resistance"


def shown(title, duration, seen):
    """Lines on what was seen under load."""
    codes = ", ".join(f"{count} of code {code}" for code, count in sorted(seen.codes.items()))
    (kind, runs, accepted), = seen.runs
    identified = f"in the node, {accepted} accepted" if kind == "identify" else "beside the node"
    p99, longest, delay_p99 = (seen.values[key + " [ms]"] for key in (
        "query work p99", "query work longest", "sample delay p99"))
    return (f"{title}: {len(seen.waits)} questions in {duration:.0f} s ({codes}), "
            f"{runs} identifications {identified}\n"
            f"    work of a question: 99 % within {p99:.2f} ms, longest {longest:.2f} ms; "
            "a client in Python waits {:.2f} ms (median), {:.2f} ms (99 %)\n"
            f"    delay of a sample: 99 % within {delay_p99:.2f} ms, longest {seen.longest:.2f} ms"
            ).format(*waited(seen))


def measured(programs, folder, seconds):
    """What query_bench prints, and of one node with each model, one after the other."""
    drive, base, model, other = (os.path.join(folder, name) for name in (
        "drive.csv", "base.yaml", "effects.yaml", "other.yaml"))
    scenario = os.path.join(ROOT, "config", "scenarios", "city_drive.yaml")
    programs.call("sof", "simulate", scenario, drive, "--duration",
                  str(2.0 * LEARNT + seconds + 60.0))
    identify = ["identify", drive, "--to", str(LEARNT), "--out"]
    programs.call("sof", *identify, base)
    programs.call("sof", *identify, model, "--effects", EFFECTS)
    lines = run([programs.path("query_bench"), base, model]).splitlines()
    beside = ["nice", "-n", "10", programs.sof, *identify, other, "--effects", EFFECTS]
    lives = (("base model", 0.0, [], "identify"),
             ("base + " + EFFECTS.replace(",", ", "), LEARNT, ["_state_file:=" + model], beside))
    with Processes(folder) as processes:
        rospy = node_of_this_process("bench_queries")
        for title, first, parameters, work in lives:
            node = processes.start(programs.node, *parameters)
            try:
                load = Load(drive, first, LEARNT, 100.0, 1, 4, 200.0, seconds)
                lines.append(shown(title, seconds, under_load(rospy, load, [work])))
            finally:
                end(node)
    return lines


def report(lines):
    return lines
