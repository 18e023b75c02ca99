"""One job of the engine: the recordings of a group, one after the other.

    python3 -m battery_sof_tools.fleet.work FOLDER GROUP.json DONE

A recording that another process still works on, such as one that outlived the run it belonged to, is waited for.
"""

import fcntl
import os
import sys

from ..files import write_json
from . import plan, steps, stored


def alone(folder, entry, setting):
    """The steps of one recording, while nobody else takes them."""
    where = plan.results(folder, entry["key"])
    os.makedirs(where, exist_ok=True)
    lock = os.open(where, os.O_RDONLY)
    fcntl.flock(lock, fcntl.LOCK_EX)
    try:
        return steps.run(folder, entry, setting)
    finally:
        os.close(lock)


def main(folder, group, done):
    kept, recordings = plan.load(folder)
    setting = plan.setting_of(folder, kept)
    mine = set(stored.read(group, [stored.KEY], "sof-fleet run writes it again"))
    taken = sum(alone(folder, one, setting) for one in recordings if one["key"] in mine)
    write_json(done, {"recordings": len(mine), "steps": taken})
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
