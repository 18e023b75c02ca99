"""Programs that a test starts and ends, and conditions with deadlines."""

import os
import shutil
import signal
import subprocess
import tempfile
import threading
import time
import unittest

import actionlib
import roslib.packages
import rosparam
import rospy
from actionlib_msgs.msg import GoalStatus

PACKAGE = "battery_sof"


def program(name, package=PACKAGE):
    found = roslib.packages.find_node(package, name)
    if not found:
        raise RuntimeError("{}/{} is not built".format(package, name))
    return found[0]


def wait_until(condition, deadline, what):
    """Returns the condition's value as soon as it is true; fails after `deadline` [s] of wall time."""
    end = time.monotonic() + deadline
    while True:
        value = condition()
        if value:
            return value
        if time.monotonic() > end:
            raise AssertionError("not within {:.0f} s: {}".format(deadline, what))
        time.sleep(0.005)


def whole_arguments(arguments):
    """The command line as rostest meant it: it does not quote the path of the results file, which may hold spaces."""
    whole = []
    for argument in arguments:
        if whole and whole[-1].startswith("--gtest_output=xml:") and not whole[-1].endswith(".xml"):
            whole[-1] += " " + argument
        else:
            whole.append(argument)
    return whole


class Program:
    """One program; its output is kept and shown when an assertion fails."""

    def __init__(self, *command, environment=None):
        self.output = tempfile.TemporaryFile(mode="w+")
        whole = dict(os.environ, ROSCONSOLE_STDOUT_LINE_BUFFERED="1", **(environment or {}))
        self.process = subprocess.Popen(command, stdout=self.output, stderr=subprocess.STDOUT, env=whole,
                                        stdin=subprocess.DEVNULL)

    def is_alive(self):
        return self.process.poll() is None

    def wait(self, deadline):
        return self.process.wait(timeout=deadline)

    def stop(self, by=signal.SIGINT):
        if self.is_alive():
            self.process.send_signal(by)
        try:
            return self.process.wait(timeout=20)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
            raise AssertionError("did not end on an interrupt:\n" + self.text())

    def kill(self):
        """Ends it without a chance to tidy up."""
        self.process.kill()
        self.process.wait()

    def text(self):
        self.output.seek(0)
        return self.output.read()


def start_node(name, parameters, environment=None, remappings=()):
    """The node with just these private parameters."""
    if rospy.has_param("/" + name):
        rospy.delete_param("/" + name)
    if parameters:
        rosparam.upload_params("/" + name, parameters)
    return Program(program("battery_sof_node"), "__name:=" + name, *remappings, environment=environment)


def play(bag, rate, *arguments):
    return Program(program("play", "rosbag"), "--clock", "--hz", "200", "--quiet", "--wait-for-subscribers", "--queue",
                   "100000", "--rate", str(rate), *map(str, arguments), bag)


def service(node, name, kind):
    full = "/{}/{}".format(node, name)
    rospy.wait_for_service(full, timeout=20.0)
    return rospy.ServiceProxy(full, kind)


class Goal:
    """A goal of an action, sent at once; what is reported of it, and how it ends. All waits are of wall time."""

    ENDED = {GoalStatus.SUCCEEDED, GoalStatus.ABORTED, GoalStatus.REJECTED, GoalStatus.PREEMPTED, GoalStatus.RECALLED, GoalStatus.LOST}

    def __init__(self, node, name, kind):
        self.client = actionlib.SimpleActionClient("/{}/{}".format(node, name), kind)
        self.feedback = []
        if not self.client.wait_for_server(rospy.Duration(20.0)):
            raise AssertionError("no action server for /{}/{}".format(node, name))
        self.client.send_goal(feedback_cb=self.feedback.append, goal=kind().action_goal.goal)

    def state(self):
        return self.client.get_state()

    def is_running(self):
        return self.state() not in self.ENDED

    def wait(self, deadline=60.0):
        """The result of a goal that ends within `deadline` [s]."""
        wait_until(lambda: not self.is_running() and self.client.get_result() is not None, deadline, "the goal's end")
        return self.client.get_result()

    def cancel(self):
        self.client.cancel_goal()


class Latest:
    """Messages of a topic: the newest, and all of them."""

    def __init__(self, topic, kind):
        self.lock = threading.Lock()
        self.messages = []
        self.subscriber = rospy.Subscriber(topic, kind, self.add)

    def add(self, message):
        with self.lock:
            self.messages.append(message)

    def newest(self):
        with self.lock:
            return self.messages[-1] if self.messages else None

    def wait(self, condition, deadline, what):
        def check():
            message = self.newest()
            return message if message is not None and condition(message) else None
        try:
            return wait_until(check, deadline, what)
        except AssertionError as failure:
            raise AssertionError("{}; the newest is\n{}".format(failure, self.newest()))

    def close(self):
        self.subscriber.unregister()


class Folder:
    """A temporary folder with a space in its name."""

    def __init__(self):
        self.path = tempfile.mkdtemp(prefix="battery sof ")

    def file(self, name):
        return os.path.join(self.path, name)

    def remove(self):
        shutil.rmtree(self.path)


class NodeTest(unittest.TestCase):
    """Whatever a test starts ends with it."""

    def start(self, name, environment=None, remappings=(), **parameters):
        node = start_node(name, parameters, environment, remappings)
        self.addCleanup(node.stop)
        return node

    def latest(self, topic, kind):
        latest = Latest(topic, kind)
        self.addCleanup(latest.close)
        return latest

    def play(self, *arguments):
        player = play(*arguments)
        self.addCleanup(player.stop)
        return player
