"""A disk that is full, read-only or gone under the node's state file and the command's outputs (needs root: mounts a tmpfs)."""

import os
import shutil
import subprocess
import time

from ..tables import table
from .kill import PlayedDrive
from .ros import NODE, Newest, Processes, node_of_this_process, perform, wait_until

SIZE = 128 * 1024  # [byte] of the disk


class Disk:
    """A tmpfs of SIZE bytes."""

    def __init__(self, path):
        self.path = path
        os.mkdir(path)

    def __enter__(self):
        subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={SIZE}", "tmpfs", self.path], check=True)
        return self

    def __exit__(self, *_):
        subprocess.run(["umount", "--lazy", self.path], check=True)

    def fill(self):
        with open(os.path.join(self.path, "ballast"), "wb", buffering=0) as file:
            try:
                while True:
                    file.write(bytes(4096))
            except OSError:
                pass

    def free(self):
        os.remove(os.path.join(self.path, "ballast"))

    def set_writable(self, is_writable):
        subprocess.run(["mount", "-o", "remount," + ("rw" if is_writable else "ro"), self.path], check=True)


def command_on_full_disk(programs, disk, recording):
    """Every output of the command on a full disk: (command, exit code, message, files left)."""
    rows = []
    disk.fill()
    model = os.path.join(os.path.dirname(recording), "model.yaml")
    programs.identify(recording, model)
    there = set(os.listdir(disk.path))
    out = os.path.join(disk.path, "out")
    for words in (["identify", recording, "--out", out + ".yaml"], ["convert", recording, out + ".bag"], ["convert", recording, out + ".csv"],
                  ["predict", model, recording, "--csv", out + ".csv"], ["check", recording, "--json", out + ".json"],
                  ["demo", out + "_demo.csv"]):
        told = subprocess.run([programs.sof, *words], capture_output=True, text=True)
        left = [name for name in os.listdir(disk.path) if name not in there]
        rows.append((words[0] + " " + os.path.splitext(words[-1])[1], told.returncode, told.stderr.strip().replace(disk.path, "DISK"), ", ".join(left) or "none"))
        for name in left:
            os.remove(os.path.join(disk.path, name))
    disk.free()
    return rows


class WatchedNode:
    """A node that is driven through windows and identified on request; what it says of its state file."""

    def __init__(self, programs, processes, state, recording):
        from battery_sof.msg import SofStatus
        from diagnostic_msgs.msg import DiagnosticArray
        self.state = state
        self.node = processes.start(programs.node, f"_state_file:={state}", "_window_s:=60", "_min_window_quality:=0")
        self.drive, self.said = PlayedDrive(recording, node_of_this_process("disk")), Newest("/diagnostics", DiagnosticArray)
        self.status = Newest(NODE + "/status", SofStatus)
        self.drive.samples.until_connected()

    def saved(self):
        """(was the file written, what /diagnostics says) after an identification over another window."""
        before = os.stat(self.state).st_mtime_ns if os.path.exists(self.state) else None
        for _ in range(9000):
            self.drive.publish()
            time.sleep(0.0002)
        time.sleep(1.0)
        perform("identify")
        time.sleep(2.5)
        after = os.stat(self.state).st_mtime_ns if os.path.exists(self.state) else None
        said = self.said.message.status if self.said.message else ()
        return after is not None and after != before, next((status.message for status in said if "identification" in status.name), "")


def node_on_disks(programs, folder, disk, recording):
    """(disk, written, whole, goes on, said) for each thing that happens to the disk under one node."""
    state, rows = os.path.join(disk.path, "state", "state.yaml"), []
    os.mkdir(os.path.dirname(state))
    with Processes(folder) as processes:
        node = WatchedNode(programs, processes, state, recording)
        for what, happens in (("sound", lambda: None), ("full", disk.fill), ("room again", disk.free), ("read-only", lambda: disk.set_writable(False)),
                              ("writable again", lambda: disk.set_writable(True)), ("folder gone", lambda: shutil.rmtree(os.path.dirname(state)))):
            happens()
            written, said = node.saved()
            taken = node.status.message.accepted
            node.drive.publish()
            wait_until(lambda: node.status.message.accepted > taken or node.drive.publish(), 20.0, "a sample taken")
            whole = programs.reads(state) if os.path.exists(state) else None
            rows.append((what, "yes" if written else "no", {True: "yes", False: "NO", None: "none there"}[whole],
                         "yes" if node.node.poll() is None else "NO", said.replace(disk.path, "DISK")))
    return rows


def measured(programs, folder):
    recording = os.path.join(folder, "drive.csv")
    programs.drive(recording, 600.0)
    with Disk(os.path.join(folder, "disk")) as disk:
        return command_on_full_disk(programs, disk, recording), node_on_disks(programs, folder, disk, recording)


def report(results):
    command, node = results
    return (table(("command on a full disk, output", "exit code", "message", "files left"), command) + [""] +
            table(("disk under the state file", "written", "file whole", "node goes on", "/diagnostics"), node))
