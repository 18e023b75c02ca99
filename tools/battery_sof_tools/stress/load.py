"""A node under load: samples at a rate, questions of some clients, work beside."""

import collections
import concurrent.futures
import multiprocessing
import subprocess
import threading
import time

import numpy as np

from ..recordings import read_plain
from .ros import NODE, ResponseTimes, Samples, node_of_this_process, perform

LIMITS = (6.0, 16.0)  # [V] in which a crank's answer lies

# drive: path of a recording, sent from `first` [s] on; learnt: [s] of it that are sent as fast as
# it goes, before the load begins; rate: [Hz] of what is sent then; kinds: of questions that are
# asked in turns, cranks first; questions: a second, of all clients; duration: [s]
Load = collections.namedtuple("Load", "drive first learnt rate clients kinds questions duration")
# codes: answers by code; outside: cranks outside LIMITS; waits: [ms] of a client, in order; values
# and longest: as in ResponseTimes; runs: as work_beside() puts them
Seen = collections.namedtuple("Seen", "codes outside waits values longest runs")


def waited(seen):
    """[ms] of a client: median, and what 99 % stay within."""
    return seen.waits[len(seen.waits) // 2], seen.waits[int(0.99 * (len(seen.waits) - 1))]


def publish(load, ready):
    """After what is learnt the drive is linear between its rows."""
    samples = Samples(node_of_this_process("publisher"))
    samples.until_connected()
    t, i, u = drive = read_plain(load.drive)
    begin = load.first + load.learnt
    for row in drive[:, (t >= load.first) & (t <= begin)].T:
        samples.send(*row)
        time.sleep(0.0001)
    ready.set()
    begun, sent = time.monotonic(), 0
    while time.monotonic() < begun + load.duration + 20.0:
        due = int((time.monotonic() - begun) * load.rate)
        stamps = begin + np.arange(sent, due) / load.rate
        for row in zip(stamps, np.interp(stamps, t, i), np.interp(stamps, t, u)):
            samples.send(*row)
        sent = max(sent, due)
        time.sleep(0.001)


def questions_of(rospy):
    """What a client asks, in turns."""
    from battery_sof.srv import PredictChargeAcceptance, PredictCranking, PredictStopTime
    cranking, stop_time, charge = (
        rospy.ServiceProxy(f"{NODE}/{name}", kind, persistent=True)
        for name, kind in (("predict_cranking", PredictCranking),
                           ("predict_stop_time", PredictStopTime),
                           ("predict_charge_acceptance", PredictChargeAcceptance)))
    event = {"i_load": -25.0, "i_cranking": -200.0, "t_cranking": 1.0}
    return [lambda: cranking(t_stop=30.0, u_required=7.2, **event),
            lambda: stop_time(u_required=9.5, **event),
            lambda: charge(u_boost=14.2, t_sof2=10.0, i_limit=200.0),
            lambda: charge(u_boost=14.2)]


def ask(load, told):
    """Puts (answers by code, cranks outside LIMITS, waits [ms] in order)."""
    rospy = node_of_this_process("askers")
    codes, outside, waits, lock = collections.Counter(), [0], [], threading.Lock()

    def one():
        kinds = questions_of(rospy)[:load.kinds]
        begun, asked = time.monotonic(), 0
        while time.monotonic() < begun + load.duration:
            time.sleep(max(0.0, begun + asked * load.clients / load.questions - time.monotonic()))
            before = time.monotonic()
            answer = kinds[asked % load.kinds]()
            waited = 1e3 * (time.monotonic() - before)
            with lock:
                waits.append(waited)
                codes[answer.code] += 1
                if asked % load.kinds == 0 and answer.code == 0:
                    outside[0] += not LIMITS[0] < answer.u_min < LIMITS[1]
            asked += 1

    with concurrent.futures.ThreadPoolExecutor(load.clients) as pool:
        list(pool.map(lambda _: one(), range(load.clients)))
    told.put((codes, outside[0], sorted(waits)))


def work_beside(kind, duration, told):
    """An action of the node, or a command, again and again. Puts (kind, runs, accepted ones)."""
    if isinstance(kind, str):
        node_of_this_process(kind)
    begun, runs, accepted = time.monotonic(), 0, 0
    while time.monotonic() < begun + duration:
        if isinstance(kind, str):
            accepted += getattr(perform(kind), "accepted", 0)
        else:
            subprocess.run(kind, check=True, stdout=subprocess.DEVNULL)
        runs += 1
    told.put((kind, runs, accepted))


def under_load(rospy, load, beside):
    """What is seen of a node that is there. rospy: of a node of this process.

    beside: actions and commands, as work_beside() takes them.
    """
    spawn = multiprocessing.get_context("spawn")
    ready, told, runs = spawn.Event(), spawn.Queue(), spawn.Queue()
    workers = [spawn.Process(target=publish, args=(load, ready), daemon=True),
               spawn.Process(target=ask, args=(load, told), daemon=True),
               *(spawn.Process(target=work_beside, args=(kind, load.duration, runs), daemon=True)
                 for kind in beside)]
    workers[0].start()
    if not ready.wait(180.0):
        raise SystemExit("the drive did not get through within 180 s")
    times = ResponseTimes(rospy)
    time.sleep(3.0)
    times.begin()
    for worker in workers[1:]:
        worker.start()
    answered = told.get(timeout=load.duration + 120.0)
    time.sleep(1.2)
    done = [runs.get(timeout=120.0) for _ in beside]
    for worker in workers:
        worker.terminate()
        worker.join()
    return Seen(*answered, times.values, times.longest, done)
