"""Asks `sof diagnose` about cases side by side and keeps one row a case: a run that was cut off goes on, answers of two builds do not mix."""

import itertools
import os
import tempfile
import time

from .. import recordings
from ..files import append, finished, lines_of, require_same
from ..sof import RECORDING, Failure, diagnose, product_digest

ANSWERS, PRODUCT = "answers.jsonl", "product.json"


def kept_for(out, sof):
    """Makes the folder of results. SystemExit where it holds answers of another build."""
    os.makedirs(out, exist_ok=True)
    require_same(os.path.join(out, PRODUCT), product_digest(sof), "answers of another build of sof")


def diagnose_samples(sof, samples, patience_s):
    """The answer of `sof diagnose` to a recording that is no file. samples: as of recordings.write()."""
    with tempfile.TemporaryDirectory(prefix="samples_") as folder:
        path = os.path.join(folder, RECORDING)
        recordings.write(path, *samples)
        return diagnose(sof, path, patience_s=patience_s)


def row_of(work, timed, case):
    """What work(case) gives, under the case's name; a Failure is kept as its words."""
    began = time.monotonic()
    try:
        row = work(case)
    except Failure as failure:
        row = {"failed": str(failure)}
    return dict(row, name=case["name"], **({"seconds": time.monotonic() - began} if timed else {}))


def complete(path, work, cases, jobs=1, what=None, timed=True, enough=lambda rows: False):
    """Rows {name: row} of a file once every case is in it.

    Cases are worked on as they come, each in a process of its own; without `what`, a word of
    progress, in turn in this process. enough: looked at before every further case, of cases that
    have no end.
    """
    rows = {row["name"]: row for row in lines_of(path)}
    if enough(rows):
        return rows
    todo = ((work, timed, case) for case in cases if case["name"] not in rows)
    done = finished(jobs, row_of, list(todo), what) if what else itertools.starmap(row_of, todo)
    for row in done:
        append(path, row)
        rows[row["name"]] = row
        if enough(rows):
            break
    return rows
