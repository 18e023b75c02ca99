"""What a fleet keeps in files, and its one reader: a file is read whole, and its shape is looked at once, here.

A shape is a type (float: any finite number), None, a tuple of shapes (one of them), [shape] (a list of such), [shape, shape] (a list of two), a compiled pattern (a text
that it matches) or {name: shape} (an object; one whose name ends in ? may be missing, others may be there beside).
"""

import json
import re

from ..files import require_regular
from . import listing

TEXT, NUMBER, COUNT, FLAG = (str, None), (float, None), (int, None), (bool, None)
KEY = re.compile("[0-9a-f]{16}")
FILE_NAME = re.compile(r"\w[\w.-]*\.(json|yaml|html)")
MAX_INTEGER = 2**63 - 1  # of the database
MAX_NUMBER = 1e300       # differences are finite too

OPTIONS = {"discharge_positive?": bool, "from_s?": str, "to_s?": str, "effects?": str, **{name + "?": str for name in listing.COLUMNS}}
FLEET = {"schema": str, "product": str, "steps": [str], "options": {"window_s": float, "without_pages": bool}}
RECORDING = {"path": str, "battery": str, "key": KEY, "sha256": TEXT, "bytes": int, "unreadable": TEXT, "vehicle_type?": str, "age_years?": float, **OPTIONS, "discharge_positive": bool}
SETTING = {"sof": str, "patience_s": float}
LABEL = {"kind": str, "mechanism?": TEXT}

PARAMETER = {"name": str, "value": NUMBER, "std_error?": NUMBER, "std?": NUMBER, "unit?": TEXT, "determined?": FLAG, "at_bound?": FLAG}
WINDOW = ({"from_s?": NUMBER, "to_s?": NUMBER}, None)
FIT = ({"train?": ({"rmse_v?": NUMBER}, None), "holdout?": ({"rmse_v?": NUMBER}, None)}, None)
SHARES = {"share_percent": NUMBER, "crank_mae_v": NUMBER}
ANSWERS = {
    "check": {"findings": [{"id": str, "severity": str, "value?": NUMBER, "unit?": TEXT, "samples?": COUNT, "what": str}], "source?": ({"seen?": bool, "share?": NUMBER}, None),
              "temperature_range_c?": ([float, float], None), "samples?": COUNT, "from_s?": NUMBER, "to_s?": NUMBER, "median_interval_s?": NUMBER},
    "convert": {},
    "identify": {"window?": WINDOW, "samples?": COUNT, "effects?": ([str], None), "status?": TEXT, "window_quality?": NUMBER, "q_dyn_percent?": NUMBER, "rmse_v?": NUMBER,
                 "parameters?": ([PARAMETER], None)},
    "predict": {"window?": WINDOW, "q_dyn_percent?": NUMBER, "rmse_v?": NUMBER, "max_abs_v?": NUMBER, "coverage_90?": NUMBER, "crank_mae_v?": NUMBER, "cranks?": (list, None),
                "mixed?": ({"share_percent?": NUMBER}, None), "baseline?": ({"share_percent?": NUMBER, "crank_mae_v?": NUMBER}, None)},
    "diagnose": {"verdict": str, "mechanism?": TEXT, "probability?": NUMBER, "summary?": TEXT, "fit?": ({"base?": FIT, "extended?": FIT}, None),
                 "evidence?": ({"base?": NUMBER, "extended?": NUMBER}, None), "effects?": ([{"id": str, "mechanism": str, "probability?": NUMBER, "parameters?": ([PARAMETER], None)}], None),
                 "candidates?": ([{"id": str, "mechanism": str, "evidence?": NUMBER, "confidence?": NUMBER, "rejected_because?": TEXT}], None)},
    "change": {"verdict": str, "summary?": TEXT, "references": [str],
               "changes": [{"id": str, "mechanism": str, "now": float, "unit": str, "interval": [float, float], "probability": float, "indistinguishable": [str]}]},
    "score": {"windows": [{"start_s": float, "effects": [str], "window_quality": NUMBER, "parameters": [PARAMETER], "baseline": SHARES,
                           "model": {"current_share_percent": NUMBER, "voltage_share_percent": NUMBER, **SHARES}}]},
}


def step(name):
    """Shape of a step's file."""
    return {"exit": COUNT, "reason": TEXT, "answer": (ANSWERS[name], None), "cost": {"wall_s": float, "cpu_s": float}}


WORDS = {str: "a text", float: "a finite number", int: "a whole number", bool: "true or false", None: "null", list: "a list"}


def expected(shape):
    """A shape in words."""
    if isinstance(shape, tuple):
        return " or ".join(expected(one) for one in shape)
    if isinstance(shape, re.Pattern):
        return f"a text like {shape.pattern}"
    if isinstance(shape, list):
        return "a list" if len(shape) == 1 else f"a list of {len(shape)}"
    return "an object" if isinstance(shape, dict) else WORDS[shape]


def holds(value, shape):
    """Whether a value is of a shape as far as it goes without what is in it."""
    if isinstance(shape, re.Pattern):
        return isinstance(value, str) and bool(shape.fullmatch(value))
    if isinstance(shape, list):
        return isinstance(value, list) and len(shape) in (1, len(value))
    if shape is float and isinstance(value, float):
        return abs(value) <= MAX_NUMBER
    if shape in (int, float):
        return isinstance(value, int) and not isinstance(value, bool) and abs(value) <= MAX_INTEGER
    return value is None if shape is None else isinstance(value, dict if isinstance(shape, dict) else shape)


def require(value, shape, place=""):
    """ValueError with the place where a value is not of a shape."""
    for one in shape if isinstance(shape, tuple) else (shape,):
        if holds(value, one):
            return require_inside(value, one, place)
    raise ValueError(f"{place or 'it'} is {json.dumps(value)[:40]}, expected {expected(shape)}")


def require_inside(value, shape, place):
    if isinstance(shape, list):
        for number, one in enumerate(value):
            require(one, shape[min(number, len(shape) - 1)], f"{place}[{number}]")
    for name, inner in shape.items() if isinstance(shape, dict) else ():
        plain = name.rstrip("?")
        if plain in value:
            require(value[plain], inner, f"{place}.{plain}" if place else plain)
        elif plain == name:
            raise ValueError(f"{place or 'it'} has no {name}")
    return value


def parsed(content, shape):
    """The value of JSON in bytes or a text. ValueError where it is none or of another shape."""
    try:
        return require(json.loads(content if isinstance(content, str) else content.decode()), shape)
    except UnicodeDecodeError:
        raise ValueError("it is no UTF-8") from None
    except RecursionError:
        raise ValueError("it is nested too deep") from None


def content(path):
    require_regular(path)
    with open(path, "rb") as file:
        return file.read()


def read(path, shape, remedy):
    """SystemExit with a sentence that ends in the remedy where a file is damaged or cannot be read."""
    try:
        return parsed(content(path), shape)
    except OSError as error:
        raise SystemExit(f"{path} cannot be read: {error.strerror}; {remedy}") from None
    except ValueError as fault:
        raise SystemExit(f"{path} is damaged: {fault}; {remedy}") from None
