"""Runs the commands that pages show.

A block of commands has a mark before it that a reader does not see:
    <!-- run me -->                  its commands end with 0
    <!-- run me, exit 1 -->          they end with 1
    <!-- run me with roscore -->     under a roscore of its own: launch files are started in the background, then the other lines are run
    <!-- not run: REASON -->
Where a line begins with "$ ", what stands below it is what it prints; "..." represents anything. Blocks of one page share a folder, in which
build/ is the build that is tested, config/ and docs/ are those of the checkout, and src/battery_sof is the checkout, as in a catkin workspace. Launch files serve the live page on a free port in place of the one that is shown.

Usage: pages_test.py BUILD
"""

import os
import re
import subprocess
import sys
import tempfile
import time
import unittest

from battery_sof_tools.files import ROOT
from battery_sof_tools.stress.ros import Processes

MARKED = ("README.md", "docs/tutorial.md")  # every block of these has a mark
PAGES = MARKED + ("docs/your-recordings.md", "docs/json.md", "docs/worked-diagnosis.md", "docs/node.md", "docs/energy-manager.md")
# Files that pages show as they are.
SHOWN = {"docs/node.md": ("examples/clients/src/crank_client.cpp", "examples/clients/scripts/crank_client.py"), "docs/your-recordings.md": ("examples/clients/scripts/can_to_csv.py",)}
MARK = re.compile(r"<!-- (?:run me(?P<exit>, exit \d)?(?P<core> with roscore)?|not run: (?P<reason>.+)) -->$")
BUILD = ""


class Block:
    def __init__(self, page, line, mark):
        self.where, self.lines = f"{page}:{line}", []
        self.mark = mark
        self.is_run = bool(mark) and not mark["reason"]
        self.code = int((mark and mark["exit"] or "0")[-1])

    def steps(self):
        """Commands, each with what is shown below it (None: nothing is said of it)."""
        steps = []
        for line in self.lines:
            if line.startswith("$ "):
                steps.append((line[2:], []))
            elif any(one.startswith("$ ") for one in self.lines):
                steps[-1][1].append(line)
            else:
                steps.append((line, None))
        return steps


def read(page):
    with open(os.path.join(ROOT, page)) as file:
        return file.read()


def blocks(page):
    """Indented blocks of a page; the mark is the last line of text before a block."""
    found, mark, open_block = [], None, None
    with open(os.path.join(ROOT, page)) as file:
        for number, line in enumerate(file, 1):
            if line.startswith("    ") and line.strip():
                if not open_block:
                    open_block = Block(page, number, mark)
                    found.append(open_block)
                open_block.lines.append(line[4:].rstrip())
            elif line.strip():
                open_block, mark = None, MARK.match(line.strip())
    return found


def like(shown, printed):
    """Whether a line is the one that is shown, trailing spaces apart."""
    return re.fullmatch(".*".join(map(re.escape, shown.rstrip().split("..."))), printed.rstrip()) is not None


class Shell:
    """Runs lines in a folder as a user would who has sourced the devel space."""

    def __init__(self, folder, environment=None):
        self.folder = folder
        self.environment = {"PATH": "/usr/local/bin:/usr/bin:/bin", "HOME": folder, "LC_ALL": "C.UTF-8", "ROS_HOME": os.path.join(folder, "ros"), **(environment or {})}

    def run(self, line):
        """Exit code, standard output and standard error."""
        done = subprocess.run(["bash", "--norc", "-c", f". build/devel/setup.bash; {line}"], cwd=self.folder, env=self.environment,
                              stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=240)
        return done.returncode, done.stdout, done.stderr


class Roscore(Processes):
    """A roscore on a free port, and the launch files under it; all ended at the end."""

    def __enter__(self):
        super().__enter__()
        self.shell = Shell(self.folder, {name: os.environ[name] for name in ("ROS_MASTER_URI", "ROS_IP")})
        return self

    def said(self):
        return "".join(read(os.path.join(self.folder, name)) for name in ("roscore.log", "bash.log") if os.path.exists(os.path.join(self.folder, name)))

    def until(self, line, what):
        """What a line prints once it ends with 0."""
        end = time.monotonic() + 40
        while True:
            code, out, error = self.shell.run(line)
            if code == 0:
                return out
            if time.monotonic() > end:
                raise AssertionError(f"{what}: {line}: {error}\n{self.said()}")
            time.sleep(0.2)

    def launch(self, line):
        line = re.sub(r" port:=\d+", "", line.split(" #")[0].rstrip()) + (" port:=0" if "live.launch" in line else "")
        code, told, error = self.shell.run(line + " --nodes")
        nodes = told.split()
        if code != 0 or not nodes:
            raise AssertionError(f"{line}: {error}")
        self.start("bash", "--norc", "-c", f". build/devel/setup.bash; exec {line}", cwd=self.folder, env=self.shell.environment)
        for node in nodes:
            self.until(f"rosservice list | grep -qx {node}/get_loggers", line)
        for node in nodes:
            if node.endswith("battery_sof_node"):  # its last service
                self.until(f"rosservice list | grep -qx {node}/predict_cranking", line)


class Pages(unittest.TestCase):
    def check(self, block, shell):
        for line, shown in block.steps():
            code, out, error = shell.run(line)
            self.assertEqual(code, block.code, f"{block.where}: {line}\n{out}{error}")
            if shown:
                printed = out.splitlines()
                self.assertEqual(len(printed), len(shown), f"{block.where}: {line}\n{out}")
                for one, other in zip(shown, printed):
                    self.assertTrue(like(one, other), f"{block.where}: {line}\nshown:   {one}\nprinted: {other}")

    def run_page(self, page):
        with tempfile.TemporaryDirectory(prefix="a page ") as folder:
            os.symlink(os.path.realpath(BUILD), os.path.join(folder, "build"))
            os.mkdir(os.path.join(folder, "src"))
            os.symlink(ROOT, os.path.join(folder, "src", "battery_sof"))
            for name in ("config", "docs"):
                os.symlink(os.path.join(ROOT, name), os.path.join(folder, name))
            for block in blocks(page):
                if block.is_run and block.mark["core"]:
                    with Roscore(folder) as core:
                        launched = [line for line in block.lines if line.startswith("roslaunch ")]
                        for line in launched:
                            core.launch(line)
                        block.lines = [line for line in block.lines if line not in launched]
                        self.check(block, core.shell)
                elif block.is_run:
                    self.check(block, Shell(folder))

    def test_every_block_of_the_first_pages_has_a_mark(self):
        for page in MARKED:
            self.assertEqual([block.where for block in blocks(page) if not block.mark], [])
            self.assertTrue([block for block in blocks(page) if block.is_run])

    def test_files_that_are_shown_are_those_of_the_examples(self):
        for page, files in SHOWN.items():
            for file in files:
                self.assertIn(f"\n{read(file)}```\n", read(page), f"{page}: not {file}")

    def test_every_parameter_of_the_node_is_listed(self):
        known = re.findall(r'schema\.(?:number|flag|text)\("(\w+)"', read("src/ros/node_options.cpp"))
        listed = re.findall(r"`(?:\w+/)?(\w+)`", read("docs/node.md").partition("## Parameters")[2].partition("\n## ")[0])
        self.assertGreater(len(known), 20)
        self.assertEqual(set(known) - set(listed), set())

    def test_another_line_than_the_one_shown_would_be_seen(self):
        self.assertTrue(like("in 2 iterations (... ms)", "in 2 iterations (20.8 ms)"))
        self.assertFalse(like("in 2 iterations (... ms)", "in 3 iterations (20.8 ms)"))
        self.assertFalse(like("11.527 V", "11a527 V"))


def named(page):
    return "test_commands_of_" + re.sub(r"\W", "_", page)


for shown_page in PAGES:
    setattr(Pages, named(shown_page), lambda self, page=shown_page: self.run_page(page))

if __name__ == "__main__":
    BUILD = sys.argv.pop(1)
    unittest.main(verbosity=2)
