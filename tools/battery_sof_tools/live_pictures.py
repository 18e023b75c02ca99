"""Picture of the live page for docs/node.md: a node that follows a simulated drive, by headless Chromium. Some two minutes.

    . build/devel/setup.bash; scripts/live_pictures [BUILD]

It has the digest of the page and of the status as the text "Description" (version_of_page()), so that a test finds a picture that is behind.
"""

import os
import subprocess
import sys
import tempfile
import time

from .files import ROOT, digest
from .page_pictures import browser, shoot
from .sof import call, program
from .stress.ros import Processes, free_port, is_listening, wait_until

PICTURES = ("live_page.png",)
SHOWN = ("live/index.html", "live/live.css", "live/live.js", "msg/SofStatus.msg", "msg/EventRecord.msg")
SCENARIO = os.path.join(ROOT, "config", "scenarios", "cold_morning.yaml")
PARAMETERS = ("_buffer_s:=400.0", "_window_s:=240.0", "_standing_query/i_load_a:=-15.0", "_standing_query/i_cranking_a:=-550.0", "_standing_query/t_cranking_s:=0.4")
RATE, CRANKS = 10, 4  # times real time; past cranks that are waited for


def version_of_page():
    return digest(*(os.path.join(ROOT, path) for path in SHOWN))[:16]


def text(driver, element):
    return driver.execute_script("return document.getElementById(arguments[0]).textContent", element)


def main():
    build = sys.argv[1] if len(sys.argv) > 1 else os.path.join(ROOT, "build")
    sof, node = program(build, "sof"), program(build, "battery_sof_node")
    with tempfile.TemporaryDirectory(prefix="live_", ignore_cleanup_errors=True) as folder, Processes(folder) as processes:
        bag, port = os.path.join(folder, "drive.bag"), free_port()
        call([sof, "simulate", SCENARIO, bag])
        wait_until(lambda: subprocess.run(["rosparam", "set", "/use_sim_time", "true"], capture_output=True, check=False).returncode == 0, 30.0, "roscore")
        processes.start(node, *PARAMETERS)
        processes.start(sys.executable, os.path.join(ROOT, "scripts", "live_page"), f"_port:={port}")
        wait_until(lambda: is_listening(port), 30.0, "the live page")
        with browser(os.path.join(folder, "profile")) as driver:
            driver.get(f"http://127.0.0.1:{port}/")
            processes.start("rosbag", "play", "--clock", "--hz", "100", "--quiet", "--wait-for-subscribers", "--rate", str(RATE), bag)
            wait_until(lambda: text(driver, "state") == "ready", 60.0, "a model")
            wait_until(lambda: driver.execute_script("return document.querySelectorAll('#cranks tbody tr th').length") >= CRANKS, 90.0, "past cranks")
            driver.find_element("id", "hold").click()
            time.sleep(0.6)
            bottom = driver.execute_script("return document.getElementById('past-title').closest('section').getBoundingClientRect().bottom + scrollY")
            shoot(driver, {"y": 0, "height": bottom + 12}, os.path.join(ROOT, "docs", "pictures", PICTURES[0]), version_of_page())
    print(f"docs/pictures/{PICTURES[0]} shows the live page")
