"""What is to be done: every recording under a key that follows from its content, and groups of them that are one job."""

import hashlib
import json
import os

from ..files import digest, require_regular, utf8, write_json
from . import listing, stored

SCHEMA = "battery_sof/fleet/1"
STEPS = ("check", "convert", "identify", "predict", "diagnose", "change", "score")
MEANT = ("discharge_positive", "from_s", "to_s", "effects", *listing.COLUMNS)  # what changes an answer
GROUP_BYTES = 8e6  # of recordings in one job
GROUP_MOST = 25    # recordings in one job
JOBS_A_CORE = 4    # at least, so that cores end together
REMEDY = "sof-fleet rebuild makes a folder from its database, sof-fleet run another one"


def described(entry):
    """An entry with its key, hash and size; a file that cannot be read keeps its path's digest as key and says why."""
    reason = unreadable(entry["path"])
    try:
        sha256, size = (None, 0) if reason else (digest(entry["path"]), os.path.getsize(entry["path"]))
    except OSError as error:
        sha256, size, reason = None, 0, f"cannot be read: {error.strerror}"
    entry = {name: utf8(value) if isinstance(value, str) else value for name, value in entry.items()}
    # The same content read the same way is one recording, whatever its path.
    meant = json.dumps([sha256 or "path " + entry["path"], {name: entry[name] for name in MEANT if name in entry}], sort_keys=True)
    return dict(entry, key=hashlib.sha256(meant.encode()).hexdigest()[:16], sha256=sha256, bytes=size, unreadable=reason)


def unreadable(path):
    """Why a recording cannot be read, or None."""
    if path != utf8(path):
        return "cannot be read: its path is no UTF-8, rename it"
    try:
        require_regular(path)
    except (OSError, ValueError) as error:  # ValueError: a null byte
        return f"cannot be read: {getattr(error, 'strerror', error)}"
    return None


def make(folder, given, steps, product, options):
    """Adds recordings to a folder's plan and keeps it. SystemExit where the folder holds answers of another product or other steps.

    @return all recordings of the folder, by key.
    """
    os.makedirs(folder, exist_ok=True)
    kept = {"schema": SCHEMA, "product": product, "steps": list(steps), "options": options}
    path, about = os.path.join(folder, "recordings.json"), os.path.join(folder, "fleet.json")
    if os.path.lexists(about) and stored.read(about, stored.FLEET, REMEDY) != kept:
        raise SystemExit(f"{folder} holds answers of another version, or other steps or options; take an empty folder")
    known = {one["key"]: one for one in recordings_in(path)} if os.path.lexists(path) else {}
    write_json(about, kept)
    for entry in sorted(map(described, listing.entries(given)), key=lambda one: (one["path"], one["key"])):
        known.setdefault(entry["key"], entry)
    everything = [known[key] for key in sorted(known)]
    write_json(path, everything)
    return everything


def load(folder):
    """(what is kept of the run, recordings); SystemExit where the folder holds none."""
    path = os.path.join(folder, "fleet.json")
    if not os.path.lexists(path):
        raise SystemExit(f"{folder} holds no fleet: sof-fleet run makes one")
    kept = stored.read(path, stored.FLEET, REMEDY)
    if kept["schema"] != SCHEMA or not set(kept["steps"]) <= set(STEPS):
        raise SystemExit(f"{path}: a fleet of another version ({kept['schema']}, this program knows {SCHEMA}); {REMEDY}")
    return kept, recordings_in(os.path.join(folder, "recordings.json"))


def with_first(recordings):
    """The recordings, each with `first`: its battery's first one, by age where that is given, else by path; None where it is that itself."""
    firsts = {}
    for one in sorted(recordings, key=lambda one: (one.get("age_years", 0.0), one["path"], one["key"])):
        if not one["unreadable"]:
            firsts.setdefault(one["battery"], one)
    return [dict(one, first=None if firsts.get(one["battery"], one)["key"] == one["key"] else firsts[one["battery"]]) for one in recordings]


def recordings_in(path):
    found = stored.read(path, [stored.RECORDING], REMEDY)
    if len({one["key"] for one in found}) != len(found):
        raise SystemExit(f"{path} is damaged: a recording is there twice; {REMEDY}")
    return found


def setting_of(folder, kept):
    """What a step has to know of the run."""
    path = os.path.join(folder, "setting.json")
    return dict(kept["options"], steps=kept["steps"], **stored.read(path, stored.SETTING, "sof-fleet run writes it again"))


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
