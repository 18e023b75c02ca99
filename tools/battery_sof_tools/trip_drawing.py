"""What battery_sof_node answers over two simulated trips, for docs/node.md: the first without a state file, the second with that of the first.

A drive is played to the node at 20 times real time, its status is recorded, and the two are drawn over the time of the trip. The sensor of
the first trip is silent for a minute; the node notices it up to 20 s late, because it looks for silence once in a second of real time.
"""

import os
import subprocess

import matplotlib.pyplot as plt
import numpy as np

from .files import ROOT, read_text, write_text
from .sof import call
from .stress.ros import Processes, wait_until

INK, GREY, BLUE, BAND, RED, GREEN = "#1b1f24", "#57606a", "#0969a8", "#9ec5e8", "#b3261e", "#1a7f37"
SCENARIO = os.path.join(ROOT, "config", "scenarios", "city_drive.yaml")
LENGTH, RATE = 1200.0, 20  # of a trip [s]; times real time
SILENT = (780.0, 840.0)  # [s], of the first trip
PARKED = 12 * 3600.0  # [s] from the beginning of the first trip to that of the second
NO_DATA = "NO_DATA"
COLORS = {NO_DATA: "#d0d7de", "population": "#f5d9a8", "previous_trip": "#c9b8e8", "this_trip": "#a8d8b4"}
ANSWERS = {"crank": "crank", "stop_time": "stop time", "charge": "charge"}
STEP = 10.0  # [s] between two points of the drawn interval


def drive(sof, folder, name, seed, begin, silent):
    """A bag of a simulated trip. Returns its time from the beginning [s] and its current [A]."""
    path = os.path.join(folder, name)
    call([sof, "simulate", SCENARIO, path + ".csv", "--duration", str(LENGTH), "--seed", str(seed)], folder)
    head, *lines = read_text(path + ".csv").splitlines()
    cells = [line.split(",") for line in lines]
    kept = [(float(time) + begin, *rest) for time, *rest in cells if not silent[0] <= float(time) < silent[1]]
    write_text(path + ".csv", head + "\n" + "".join(f"{time:.2f},{','.join(rest)}\n" for time, *rest in kept))
    call([sof, "convert", path + ".csv", path + ".bag"], folder)
    return np.array([row[0] - begin for row in kept]), np.array([float(row[1]) for row in kept])


def bands(times, values):
    """[begin, end, value] of each stretch with one value."""
    changes = [k for k in range(len(values)) if k == 0 or values[k] != values[k - 1]]
    return [[times[k], times[end] if end < len(times) else times[-1], values[k]] for k, end in zip(changes, [*changes[1:], len(values)])]


def played(node, folder, name, begin):
    """The node's answers while a bag is played to it."""
    import rosbag
    recorded = os.path.join(folder, name + "_status.bag")
    with Processes(folder) as processes:
        wait_until(lambda: subprocess.run(["rosparam", "set", "/use_sim_time", "true"], capture_output=True, check=False).returncode == 0, 30.0, "roscore")
        processes.start(node, "_state_file:=" + os.path.join(folder, "state.yaml"))
        processes.start("rosbag", "record", "-O", recorded, "/battery_sof_node/status", "/battery_sof_node/model")
        wait_until(lambda: "/record" in subprocess.run(["rostopic", "info", "/battery_sof_node/status"], capture_output=True, text=True, check=False).stdout, 30.0, "rosbag record")
        subprocess.run(["rosbag", "play", "--clock", "--hz", "100", "--quiet", "--wait-for-subscribers", "--queue", "100000", "--rate", str(RATE),
                        os.path.join(folder, name + ".bag")], check=True, capture_output=True)
    with rosbag.Bag(recorded) as bag:
        rows = [(topic, time.to_sec() - begin, message) for topic, message, time in bag.read_messages() if time.to_sec() >= begin]
    fits = [time for topic, time, _ in rows if topic.endswith("/model")]
    statuses = [(time, message) for topic, time, message in rows if topic.endswith("/status")]
    times = [time for time, _ in statuses]
    known = [(time, message.crank) for time, message in statuses if message.answer_basis]
    some = [known[k] for k in range(len(known)) if k == 0 or known[k][0] // STEP != known[k - 1][0] // STEP]
    return {"basis": bands(times, [message.answer_basis or NO_DATA for _, message in statuses]), "fits": fits,
            "valid": {name: bands(times, [bool(message.answer_basis and getattr(message, name).valid) for _, message in statuses]) for name in ANSWERS},
            "interval": [[time, crank.u_min, crank.lower, crank.upper] for time, crank in some]}


def trips(sof, node, folder):
    """The current of each trip, and what the node answered."""
    found = []
    for name, seed, begin, silent in (("first", 1, 0.0, SILENT), ("second", 2, PARKED, (LENGTH, LENGTH))):
        time, current = drive(sof, folder, name, seed, begin, silent)
        cranks = np.flatnonzero((current < -150.0) & (np.diff(time, prepend=-9.0) < 1.0))
        begins = [time[k] for j, k in enumerate(cranks) if j == 0 or time[k] - time[cranks[j - 1]] > 2.0]
        found.append({"cranks": begins, **played(node, folder, name, begin)})
    return found


def row(axes, y, stretches, colors, label):
    for begin, end, value in stretches:
        if colors.get(value):
            axes.broken_barh([(begin / 60, (end - begin) / 60)], (y - 0.4, 0.8), color=colors[value], linewidth=0)
    axes.text(-0.01, y, label, transform=axes.get_yaxis_transform(), ha="right", va="center", fontsize=9)


def draw_trip(states, answers, trip, title, size):
    states.set_title(title, loc="left", fontsize=10)
    row(states, 4, trip["basis"], COLORS, "answer_basis")
    for begin, end, value in trip["basis"]:
        if end - begin > 150:
            states.text((begin + end) / 120, 4, value, ha="center", va="center", fontsize=size)
    for y, (name, words) in zip((3, 2, 1), ANSWERS.items()):
        row(states, y, trip["valid"][name], {True: GREEN, False: "#eaeef2"}, words)
    states.plot(np.array(trip["fits"]) / 60, [4.75] * len(trip["fits"]), marker="v", linestyle="", color=INK, markersize=6, clip_on=False)
    states.set_ylim(0.5, 5.1)
    states.set_yticks([])
    states.spines["left"].set_visible(False)
    time, value, lower, upper = np.transpose(trip["interval"])
    gaps = np.flatnonzero(np.diff(time) > 3 * STEP) + 1
    for part in np.split(np.arange(len(time)), gaps):
        answers.fill_between(time[part] / 60, lower[part], upper[part], color=BAND, alpha=0.7, linewidth=0)
        answers.plot(time[part] / 60, value[part], color=BLUE, linewidth=1.5)
    answers.axhline(7.2, color=RED, linestyle="--", linewidth=1.2)
    answers.plot(np.array(trip["cranks"]) / 60, [6.7] * len(trip["cranks"]), marker="^", linestyle="", color=INK, markersize=5)
    answers.set_ylim(6.4, 12.6)
    answers.set_ylabel("crank [V]", fontsize=9)


def draw(found, width, size):
    figure, axes = plt.subplots(4, 1, figsize=(width, 6.4), sharex=True, height_ratios=(5, 4, 5, 4), layout="constrained")
    for k, title in enumerate(("First trip, without a state file", "Second trip, with the state file of the first")):
        draw_trip(axes[2 * k], axes[2 * k + 1], found[k], title, size)
    axes[-1].set_xlim(0, LENGTH / 60)
    axes[-1].set_xticks(range(0, int(LENGTH / 60) + 1, 5))
    axes[-1].set_xlabel("time of the trip [min]", fontsize=9)
    return figure
