"""Times the node's answers under load. Usage: bench_queries BUILD_FOLDER [SECONDS]

A simulated drive arrives at 100 Hz, 200 questions a second of the three kinds come in, and identifications run one after
the other. Printed are the node's own times as it reports them in /diagnostics (work of a question from its callback's
beginning to its end; delay of a sample from its arrival to the end of its callback) and what a client waits. Once with
the base model, once with a model of four effects. Before that, the questions alone on the same models (query_bench).
"""

import multiprocessing
import os
import signal
import subprocess
import sys
import tempfile
import time

from .files import ROOT
from .stress.ros import NODE, Processes, ResponseTimes, Samples, node_of_this_process, perform, rows_of

RATE, QUESTIONS = 100.0, 200.0  # [Hz]
LEARNT = 300.0  # [s] of the drive before the load begins
EFFECTS = "charge_acceptance,gassing,ocv_soc,current_dependent_resistance"


def publish(path, first, duration, ready):
    """The drive from `first` on: Estimated as fast as it goes, then at its own pace."""
    samples = Samples(node_of_this_process("publisher"))
    samples.until_connected()
    started, begin = None, first + LEARNT
    for stamp, current, voltage in rows_of(path):
        if stamp < first:
            continue
        if stamp >= begin:
            started = started or (time.monotonic() - stamp)
            ready.set()
            time.sleep(max(0.0, started + stamp - time.monotonic()))
        else:
            time.sleep(0.0001)
        samples.send(stamp, current, voltage)
        if stamp > begin + duration:
            return


def ask(duration, waits):
    rospy = node_of_this_process("asker")
    from battery_sof.srv import PredictChargeAcceptance, PredictCranking, PredictStopTime
    cranking = rospy.ServiceProxy(NODE + "/predict_cranking", PredictCranking, persistent=True)
    stop_time = rospy.ServiceProxy(NODE + "/predict_stop_time", PredictStopTime, persistent=True)
    charge = rospy.ServiceProxy(NODE + "/predict_charge_acceptance", PredictChargeAcceptance, persistent=True)
    kinds = [lambda: cranking(i_load=-25.0, t_stop=30.0, i_cranking=-200.0, t_cranking=1.0, u_required=7.2),
             lambda: stop_time(i_load=-25.0, i_cranking=-200.0, t_cranking=1.0, u_required=9.5),
             lambda: charge(u_boost=14.2, t_sof2=10.0, i_limit=200.0),
             lambda: charge(u_boost=14.2)]
    begun, took, codes = time.monotonic(), [], {}
    while time.monotonic() < begun + duration:
        time.sleep(max(0.0, begun + len(took) / QUESTIONS - time.monotonic()))
        asked = time.monotonic()
        code = kinds[len(took) % len(kinds)]().code
        took.append(1e3 * (time.monotonic() - asked))
        codes[code] = codes.get(code, 0) + 1
    waits.put((sorted(took), codes))


def identify_in_node(duration, counts):
    node_of_this_process("identifier")
    begun, runs, accepted = time.monotonic(), 0, 0
    while time.monotonic() < begun + duration:
        accepted += perform("identify").accepted
        runs += 1
    counts.put("{} identifications in the node, {} accepted".format(runs, accepted))


def identify_beside(command, duration, counts):
    begun, runs = time.monotonic(), 0
    while time.monotonic() < begun + duration:
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        runs += 1
    counts.put("{} identifications beside the node".format(runs))


def run(rospy, tools, folder, drive, first, parameters, title, duration, identification=None):
    """One node under load; its lines."""
    with open(os.path.join(folder, "node.log"), "w") as log:
        node = subprocess.Popen([os.path.join(tools, "battery_sof_node")] + parameters, stdout=log, stderr=log)
    spawn = multiprocessing.get_context("spawn")
    ready, waits, counts = spawn.Event(), spawn.Queue(), spawn.Queue()
    publisher = spawn.Process(target=publish, args=(drive, first, duration + 20.0, ready))
    workers = [spawn.Process(target=ask, args=(duration, waits)),
               spawn.Process(target=identify_beside, args=(identification, duration, counts)) if identification
               else spawn.Process(target=identify_in_node, args=(duration, counts))]
    try:
        publisher.start()
        if not ready.wait(120.0):
            raise RuntimeError("the drive did not get through")
        diagnosed = ResponseTimes(rospy)
        time.sleep(3.0)
        diagnosed.begin()
        for worker in workers:
            worker.start()
        took, codes = waits.get(timeout=duration + 60.0)
        identified = counts.get(timeout=60.0)
        time.sleep(1.2)
        values = diagnosed.values
        print("{}: {} questions in {:.0f} s ({}), {}".format(
            title, len(took), duration, ", ".join("{} of code {}".format(n, c) for c, n in sorted(codes.items())),
            identified))
        print("    work of a question: 99 % within {:.2f} ms, longest {:.2f} ms; a client in Python waits {:.2f} ms "
              "(median), {:.2f} ms (99 %)".format(values["query work p99 [ms]"], values["query work longest [ms]"],
                                                  took[len(took) // 2], took[int(0.99 * (len(took) - 1))]))
        print("    delay of a sample: 99 % within {:.2f} ms, longest {:.2f} ms".format(
            values["sample delay p99 [ms]"], diagnosed.longest), flush=True)
    finally:
        for process in [publisher] + workers:
            if process.pid:
                process.terminate()
                process.join()
        node.send_signal(signal.SIGINT)
        node.wait(timeout=20.0)


def load(tools, folder, drive, model, duration):
    other = os.path.join(folder, "other.yaml")
    with Processes(folder):
        rospy = node_of_this_process("bench_queries")
        run(rospy, tools, folder, drive, 0.0, [], "base model", duration)
        run(rospy, tools, folder, drive, LEARNT, ["_state_file:=" + model],
            "base + " + EFFECTS.replace(",", ", "), duration,
            ["nice", "-n", "10", os.path.join(tools, "sof"), "identify", drive, "--to", str(LEARNT),
             "--effects", EFFECTS, "--out", other])


def main():
    if len(sys.argv) not in (2, 3):
        print(__doc__, file=sys.stderr)
        return 2
    tools = os.path.join(os.path.abspath(sys.argv[1]), "devel", "lib", "battery_sof")
    duration = float(sys.argv[2]) if len(sys.argv) == 3 else 20.0
    scenario = os.path.join(ROOT, "config", "scenarios", "city_drive.yaml")
    with tempfile.TemporaryDirectory() as folder:
        drive, base, model = (os.path.join(folder, name) for name in ("drive.csv", "base.yaml", "effects.yaml"))
        quiet = {"check": True, "stdout": subprocess.DEVNULL}
        sof = os.path.join(tools, "sof")
        subprocess.run([sof, "simulate", scenario, drive, "--duration", str(2.0 * LEARNT + duration + 60.0)], **quiet)
        subprocess.run([sof, "identify", drive, "--to", str(LEARNT), "--out", base], **quiet)
        subprocess.run([sof, "identify", drive, "--to", str(LEARNT), "--out", model, "--effects", EFFECTS], **quiet)
        subprocess.run([os.path.join(tools, "query_bench"), base, model], check=True)
        load(tools, folder, drive, model, duration)
    return 0
