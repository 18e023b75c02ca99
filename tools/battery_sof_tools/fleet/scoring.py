"""The step `score`: what a model of a window says of the next one (score_next_window.py), as one answer for a recording.

Windows are those of score_next_window, longer where samples are rare; a recording too short for two of them is parted in the middle.
"""

import subprocess
import time

import numpy as np

from .. import recordings, score_next_window
from . import listing

LEAST = 20  # samples in a half


def answer(recording, patience_s):
    """(exit code, answer, reason) as of a call of sof. patience_s: for all of its windows."""
    end = time.monotonic() + patience_s
    try:
        t = times(recording)
    except (SystemExit, OSError, ValueError) as refused:
        return None, None, str(refused)
    if len(t) < 2 * LEAST:
        return None, None, f"{len(t)} samples, {2 * LEAST} are needed"
    window = max(recording.setting["window_s"], 2 * LEAST * float(np.median(np.diff(t))))
    found, stretches = [], stretches_of(t, window)
    path, *columns = recording.read()
    for ends in stretches:
        try:
            scores = score_next_window.score(recording.setting["sof"], path, columns, t, ends, recording.options(), end)
        except subprocess.TimeoutExpired:
            return None, None, f"no answer within {patience_s:g} s"
        if scores:
            found.append({key: value for key, value in scores.items() if key != "fit_ms"})
    if not found:
        return None, {"tried": len(stretches), "windows": []}, f"none of {len(stretches)} windows was fitted and predicted"
    return 0, {"tried": len(stretches), "windows": found}, None


def times(recording):
    entry = recording.entry
    names = recordings.COLUMNS if recording.is_bag else tuple(entry.get(key, name) for key, name in zip(listing.COLUMNS, recordings.COLUMNS))
    t = np.sort(recordings.read(recording.read()[0], names)[0])
    t = t[np.isfinite(t)]
    return t[(t >= float(entry.get("from_s", -np.inf))) & (t <= float(entry.get("to_s", np.inf)))] if is_number(entry) else t


def is_number(entry):
    """Whether the entry's window is on the recording's own clock, as a number."""
    try:
        return bool([float(entry[key]) for key in ("from_s", "to_s") if key in entry and not entry[key].startswith("+")])
    except ValueError:
        return False


def stretches_of(t, window):
    """(begin, begin of the next window, its end) of every pair."""
    if t[-1] - t[0] < 2.0 * window:
        middle = t[0] + 0.5 * (t[-1] - t[0])
        return [(t[0], middle, t[-1] + 1e-3)]
    return score_next_window.stretches_of(t, window)[0]
