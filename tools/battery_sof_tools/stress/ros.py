"""A roscore, nodes and players of their own for one run, on loopback, each ended by its process id; samples, and what the node reports."""

import contextlib
import functools
import logging
import math
import os
import signal
import socket
import subprocess
import time

NODE = "/battery_sof_node"


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def is_listening(port):
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


class Processes(contextlib.ExitStack):
    """Everything started here ends here, the last first."""

    def __init__(self, folder):
        super().__init__()
        self.folder = folder

    def __enter__(self):
        logging.getLogger("rosout").setLevel(logging.ERROR)  # rospy reports of every service it waits for
        port = free_port()
        os.environ.update(ROS_MASTER_URI=f"http://127.0.0.1:{port}", ROS_IP="127.0.0.1", ROS_HOME=self.folder, ROS_LOG_DIR=self.folder)
        self.start("roscore", "-p", str(port))
        wait_until(lambda: is_listening(port), 10.0, "roscore")
        return self

    def start(self, *command, **more):
        log = os.path.join(self.folder, os.path.basename(command[0]) + ".log")
        with open(log, "a") as file:
            process = subprocess.Popen(command, stdout=file, stderr=file, stdin=subprocess.DEVNULL, **more)
        self.callback(end, process)
        return process


def end(process):
    """Interrupted, killed when that is not enough."""
    if process.poll() is None:
        process.send_signal(signal.SIGINT)
        try:
            process.wait(timeout=20.0)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def wait_until(condition, patience_s, what):
    end_at = time.monotonic() + patience_s
    while not condition():
        if time.monotonic() > end_at:
            raise SystemExit(f"not within {patience_s:g} s: {what}")
        time.sleep(0.01)


def node_of_this_process(name):
    """rospy, as a node of its own that leaves signals to others."""
    import rospy
    rospy.init_node(name, anonymous=True, disable_signals=True)
    return rospy


class Samples:
    """The node's topic, with somebody who listens. @param rospy of a node."""

    def __init__(self, rospy):
        from sensor_msgs.msg import BatteryState
        self.message, self.stamp = BatteryState, rospy.Time.from_sec
        self.topic = rospy.Publisher("battery_state", BatteryState, queue_size=100000, tcp_nodelay=True)

    def until_connected(self):
        while self.topic.get_num_connections() == 0:
            time.sleep(0.005)

    def send(self, stamp, current, voltage):
        message = self.message(current=current, voltage=voltage, temperature=math.nan)
        message.header.stamp = self.stamp(stamp)
        self.topic.publish(message)


class ResponseTimes:
    """What the node reports of its own times, by key; the longest delay of a sample [ms] over all reports since begin()."""

    LONGEST = "sample delay longest since the last report [ms]"

    def __init__(self, rospy):
        from diagnostic_msgs.msg import DiagnosticArray
        self.values, self.longest, self.reports = {}, 0.0, 0
        self.subscriber = rospy.Subscriber("/diagnostics", DiagnosticArray, self.add)

    def add(self, array):
        for status in array.status:
            if status.name.endswith("response times"):
                self.values = {value.key: float(value.value) for value in status.values}
                self.longest = max(self.longest, self.values[self.LONGEST])
                self.reports += 1

    def begin(self):
        """Waits for a report: what came before it is not counted."""
        reports = self.reports
        wait_until(lambda: self.reports > reports, 30.0, "the node's response times")
        self.longest = 0.0


@functools.lru_cache
def action_client(name):
    import actionlib
    from battery_sof.msg import DiagnoseAction, IdentifyAction
    return actionlib.SimpleActionClient(f"{NODE}/{name}", {"identify": IdentifyAction, "diagnose": DiagnoseAction}[name])


def perform(name):
    """The result of an action of the node, `identify` or `diagnose`; None when there is none within a minute (the node is gone)."""
    import rospy
    client = action_client(name)
    if not client.wait_for_server(rospy.Duration(20.0)):
        return None
    client.send_goal_and_wait(client.action_client.ActionGoal().goal, rospy.Duration(60.0))
    return client.get_result()


class Newest:
    """The newest message of a topic."""

    def __init__(self, topic, kind):
        import rospy
        self.message = None
        self.subscriber = rospy.Subscriber(topic, kind, lambda message: setattr(self, "message", message))


def use_of(process):
    """Resident memory [MB], open files and threads of a process."""
    with open(f"/proc/{process.pid}/status") as file:
        fields = dict(line.split(":", 1) for line in file if ":" in line)
    return int(fields["VmRSS"].split()[0]) / 1024.0, len(os.listdir(f"/proc/{process.pid}/fd")), int(fields["Threads"])
