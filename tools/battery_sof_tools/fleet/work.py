"""One job of the engine: the recordings of a group, one after the other.

    python3 -m battery_sof_tools.fleet.work FOLDER GROUP.json DONE

A group that another process still works on, such as one that outlived the run it belonged to, is waited for.
"""

import fcntl
import os
import sys

from ..files import read_json, write_json
from . import plan, steps


def main(folder, group, done):
    kept, recordings = plan.load(folder)
    setting = dict(kept["options"], steps=kept["steps"], **read_json(os.path.join(folder, "setting.json")))
    mine = set(read_json(group))
    with open(group) as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        taken = sum(steps.run(folder, one, setting) for one in recordings if one["key"] in mine)
    write_json(done, {"recordings": len(mine), "steps": taken})
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
