"""What is to be done: every recording under a key that follows from its content, and groups of them that are one job."""

import hashlib
import json
import os

from ..files import digest, read_json, require_same, write_json
from . import listing

SCHEMA = "battery_sof/fleet/1"
STEPS = ("check", "convert", "identify", "predict", "diagnose", "score")
MEANT = ("discharge_positive", "from_s", "to_s", "effects", *listing.COLUMNS)  # what changes an answer
GROUP_BYTES = 8e6  # of recordings in one job
GROUP_MOST = 25    # recordings in one job
JOBS_A_CORE = 4    # at least, so that cores end together


def key_of(entry, sha256):
    """The same content read the same way is one recording, whatever its path."""
    meant = json.dumps([sha256, {name: entry[name] for name in MEANT if name in entry}], sort_keys=True)
    return hashlib.sha256(meant.encode()).hexdigest()[:16]


def described(entry):
    """An entry with its key, hash and size; a file that cannot be read keeps its path's digest as key and says why."""
    try:
        sha256, size, unreadable = digest(entry["path"]), os.path.getsize(entry["path"]), None
    except OSError as error:
        sha256, size, unreadable = None, 0, f"cannot be read: {error.strerror}"
    key = key_of(entry, sha256 or "path " + entry["path"])
    return dict(entry, key=key, sha256=sha256, bytes=size, unreadable=unreadable)


def make(folder, given, steps, product, options):
    """Adds recordings to a folder's plan and keeps it. SystemExit where the folder holds answers of another product or other steps.

    @return all recordings of the folder, by key.
    """
    os.makedirs(folder, exist_ok=True)
    kept = {"schema": SCHEMA, "product": product, "steps": list(steps), "options": options}
    require_same(os.path.join(folder, "fleet.json"), kept, "answers of another version, or other steps or options")
    path = os.path.join(folder, "recordings.json")
    known = {one["key"]: one for one in read_json(path)} if os.path.exists(path) else {}
    for entry in sorted(map(described, listing.entries(given)), key=lambda one: (one["path"], one["key"])):
        known.setdefault(entry["key"], entry)
    everything = [known[key] for key in sorted(known)]
    write_json(path, everything)
    return everything


def load(folder):
    """(what is kept of the run, recordings); SystemExit where the folder holds none."""
    path = os.path.join(folder, "fleet.json")
    if not os.path.exists(path):
        raise SystemExit(f"{folder} holds no fleet: sof-fleet run makes one")
    return read_json(path), read_json(os.path.join(folder, "recordings.json"))


def results(folder, key):
    """Folder of one recording's results; 256 folders hold them all."""
    return os.path.join(folder, "results", key[:2], key)


def missing(folder, key, steps):
    return [step for step in steps if not os.path.exists(os.path.join(results(folder, key), step + ".json"))]


def groups(entries, cores):
    """Lists of keys, one a job: neighbours until a group is full, large recordings first so that no core is left with one at the end."""
    most = max(1, min(GROUP_MOST, -(-len(entries) // (JOBS_A_CORE * cores))))
    made, room = [], 0.0
    for entry in sorted(entries, key=lambda one: (-one["bytes"], one["key"])):
        if not made or len(made[-1]) == most or room < entry["bytes"]:
            made.append([])
            room = GROUP_BYTES
        made[-1].append(entry["key"])
        room -= entry["bytes"]
    return made
