"""More than a car asks: many clients, a topic fifty times as fast, identifications and diagnoses beside."""

import gc
import multiprocessing
import os
import time

from ..tables import table
from .ros import NODE, Processes, ResponseTimes, Samples, node_of_this_process, perform, rows_of

LEARNT = 400.0  # [s] of the drive before the load begins
LIMITS = (6.0, 16.0)  # [V] in which a crank's answer lies
KEYS = ("query work p99 [ms]", "query work longest [ms]", "sample delay p99 [ms]")


def publish(rows, rate, duration, ready):
    """The drive up to Estimated as fast as it goes, then what comes at `rate` [Hz], linear between the rows, at its own pace."""
    samples = Samples(node_of_this_process("publisher"))
    samples.until_connected()
    learnt = [row for row in rows if row[0] <= LEARNT]
    for row in learnt:
        samples.send(*row)
        time.sleep(0.0001)
    ready.set()
    begun, sent, at = time.monotonic(), 0, len(learnt) - 1
    while time.monotonic() < begun + duration:
        due = int((time.monotonic() - begun) * rate)
        for sent in range(sent, due):
            stamp = LEARNT + sent / rate
            while rows[at + 1][0] < stamp:
                at += 1
            share = (stamp - rows[at][0]) / (rows[at + 1][0] - rows[at][0])
            samples.send(stamp, *(a + share * (b - a) for a, b in zip(rows[at][1:], rows[at + 1][1:])))
        sent = max(sent, due)
        time.sleep(0.001)


def ask(clients, questions, duration, told):
    """`questions` a second from `clients` connections. Puts (answers by code, answers outside LIMITS, waits [ms] in order)."""
    import threading
    rospy = node_of_this_process("askers")
    from battery_sof.srv import PredictCranking
    codes, outside, waits, lock = {}, [0], [], threading.Lock()

    def one():
        crank = rospy.ServiceProxy(NODE + "/predict_cranking", PredictCranking, persistent=True)
        begun, asked = time.monotonic(), 0
        while time.monotonic() < begun + duration:
            time.sleep(max(0.0, begun + asked * clients / questions - time.monotonic()))
            before = time.monotonic()
            answer = crank(i_load=-25.0, t_stop=30.0, i_cranking=-200.0, t_cranking=1.0, u_required=7.2)
            asked += 1
            with lock:
                waits.append(1e3 * (time.monotonic() - before))
                codes[answer.code] = codes.get(answer.code, 0) + 1
                outside[0] += answer.code == 0 and not LIMITS[0] < answer.u_min < LIMITS[1]
    threads = [threading.Thread(target=one) for _ in range(clients)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    told.put((codes, outside[0], sorted(waits)))


def work_beside(kind, duration, told):
    """Identifications or diagnoses, one after the other."""
    node_of_this_process(kind)
    begun, runs = time.monotonic(), 0
    while time.monotonic() < begun + duration:
        perform(kind)
        runs += 1
    told.put((kind, runs))


def wake(duration, told):
    """Does nothing but wake every millisecond; puts how late at most [ms]: what the machine makes of any program of usual priority."""
    gc.disable()
    latest, begun, turn = 0.0, time.monotonic(), 0
    while time.monotonic() < begun + duration:
        turn += 1
        time.sleep(max(0.0, begun + 1e-3 * turn - time.monotonic()))
        late = time.monotonic() - (begun + 1e-3 * turn)
        latest = max(latest, late)
        turn += max(0, int(1e3 * late))
    told.put(1e3 * latest)


def overload(programs, folder, clients, questions, rate, duration):
    """(codes, outside, waits, response times, longest delay [ms], runs beside, longest delay of a program that only wakes [ms])."""
    recording = os.path.join(folder, "drive.csv")
    programs.drive(recording, LEARNT + duration + 60.0, 100.0, 1)
    rows = rows_of(recording)
    spawn = multiprocessing.get_context("spawn")
    ready, told, beside, woken = spawn.Event(), spawn.Queue(), spawn.Queue(), spawn.Queue()
    with Processes(folder) as processes:
        processes.start(programs.node)
        times = ResponseTimes(node_of_this_process("overload"))
        workers = [spawn.Process(target=publish, args=(rows, rate, duration + 20.0, ready), daemon=True)]
        workers[0].start()
        if not ready.wait(180.0):
            raise SystemExit("the drive did not get through within 180 s")
        times.begin()
        workers += [spawn.Process(target=ask, args=(clients, questions, duration, told), daemon=True)]
        workers += [spawn.Process(target=work_beside, args=(kind, duration, beside), daemon=True) for kind in ("identify", "diagnose")]
        workers += [spawn.Process(target=wake, args=(duration, woken), daemon=True)]
        for worker in workers[1:]:
            worker.start()
        answered = told.get(timeout=duration + 120.0)
        time.sleep(1.2)
        runs = [beside.get(timeout=120.0) for _ in range(2)]
        for worker in workers:
            worker.terminate()
    return (*answered, times.values, times.longest, runs, woken.get(timeout=120.0))


def report(result):
    codes, outside, waits, values, longest, runs, late = result
    rows = [("questions answered", sum(codes.values())), *((f"of code {code}", count) for code, count in sorted(codes.items())),
            ("answers of code 0 outside 6 to 16 V", outside), *((f"{kind} beside", count) for kind, count in runs),
            ("a client in Python waits, median; 99 % [ms]", f"{waits[len(waits) // 2]:.1f}; {waits[int(0.99 * (len(waits) - 1))]:.1f}"),
            *((key, f"{values[key]:.2f}") for key in KEYS), ("sample delay longest [ms]", f"{longest:.2f}"),
            ("a program that only wakes every millisecond, latest [ms]", f"{late:.2f}")]
    return table(("what", "figure"), rows)
