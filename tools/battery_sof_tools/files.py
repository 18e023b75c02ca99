"""Files of results: JSON that appears whole or not at all, rows that a run which was cut off goes on from, digests; work in turns."""

import concurrent.futures
import hashlib
import json
import os

from .progress import followed

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))  # of the package


def read_json(path):
    with open(path) as file:
        return json.load(file)


def write_json(path, value):
    """Written beside, then renamed."""
    write_text(path, json.dumps(value))


def write_text(path, text):
    """Written beside, then renamed."""
    beside = f"{path}.{os.getpid()}.part"
    with open(beside, "w") as file:
        file.write(text)
    os.replace(beside, path)


def lines_of(path):
    """One object a line; a last line that was cut off is left, a missing file has none."""
    if not os.path.exists(path):
        return []
    with open(path) as file:
        return [json.loads(line) for line in file if line.endswith("\n")]


def append(path, entry):
    with open(path, "a") as file:
        file.write(json.dumps(entry) + "\n")


def digest(*paths):
    """SHA-256 of files, one after the other."""
    total = hashlib.sha256()
    for path in paths:
        with open(path, "rb") as file:
            total.update(file.read())
    return total.hexdigest()


def require_same(path, value, what):
    """Keeps a value; SystemExit where another is kept already."""
    if os.path.exists(path) and read_json(path) != value:
        raise SystemExit(f"{os.path.dirname(path)} holds {what}; take an empty folder")
    write_json(path, value)


def finished(jobs, work, todo, what):
    """Results of work(*arguments) as they come, each from a process of its own, with progress on standard error."""
    if not todo:
        return
    with concurrent.futures.ProcessPoolExecutor(jobs) as pool:
        pending = [pool.submit(work, *arguments) for arguments in todo]
        for one in followed(concurrent.futures.as_completed(pending), what, len(todo)):
            yield one.result()
