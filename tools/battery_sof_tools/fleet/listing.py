"""Which recordings a fleet has: folders, files, and lists of files with what is known of each."""

import csv
import math
import os

import yaml

from ..files import read_text, require_regular

KINDS = (".csv", ".bag")
LISTS = (".yaml", ".yml")
COLUMNS = ("time_column", "current_column", "voltage_column", "temperature_column", "topic")  # options of every subcommand of sof
KNOWN = ("path", "battery", "vehicle_type", "age_years", *COLUMNS, "discharge_positive", "from_s", "to_s", "effects")
YES = ("1", "true", "yes")
MAX_HEADER = 1 << 16  # [byte] of a CSV file's first line


def entries(given):
    """One dictionary a recording, with the keys of KNOWN that are known of it. SystemExit with a sentence for what cannot be read."""
    found = [one for path in given for one in of_path(path)]
    if not found:
        raise SystemExit("no recordings: give folders, .csv or .bag files, or lists of them")
    return named([complete(one) for one in found])


def of_path(path):
    if os.path.isdir(path):
        return [{"path": os.path.join(parent, name)} for parent, _, names in sorted(os.walk(path)) for name in sorted(names) if name.endswith(KINDS)]
    if not os.path.exists(path):
        raise SystemExit(f"{path}: no such recording, list or folder")
    if path.endswith(LISTS):
        return of_list(path, read(path, yaml_rows))
    if path.endswith(".csv") and os.path.isfile(path) and os.access(path, os.R_OK) and is_list(path):
        return of_list(path, read(path, csv_rows))
    return [{"path": path}]


def read(path, how):
    """SystemExit with a sentence where a file cannot be read as that."""
    try:
        require_regular(path)
        return how(path)
    except OSError as error:
        raise SystemExit(f"{path} cannot be read: {error.strerror}") from None
    except (csv.Error, yaml.YAMLError, ValueError, RecursionError) as fault:
        raise SystemExit(f"{path} is not a list of recordings: {' '.join(str(fault).split())}") from None


def is_list(path):
    """By its first line; a recording may be large."""
    with open(path, newline="", errors="replace") as file:
        try:
            return "path" in next(csv.reader([file.readline(MAX_HEADER)]), ())
        except csv.Error:
            return False


def csv_rows(path):
    with open(path, newline="", errors="replace") as file:
        return list(csv.DictReader(file, restkey="cells without a name"))


def yaml_rows(path):
    rows = yaml.safe_load(read_text(path))
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise SystemExit(f"{path}: a list is meant: - path: ...")
    return rows


def of_list(path, rows):
    """Paths in a list are beside it where they are not whole."""
    for number, row in enumerate(rows, 1):
        unknown = sorted(str(key) for key in row if key not in KNOWN)
        if unknown:
            raise SystemExit(f"{path}: row {number}: no column {', '.join(unknown)}; there are {', '.join(KNOWN)}")
        for key, value in row.items():
            if isinstance(value, (list, dict, set, bytes)):
                raise SystemExit(f"{path}: row {number}: {key} is {'a list' if isinstance(value, list) else 'no text'}, expected a text or a number")
        if not is_age(row.get("age_years")):
            raise SystemExit(f"{path}: row {number}: age_years is {row['age_years']}, expected a number of years from 0")
        if not str(row.get("path") or "").strip():
            raise SystemExit(f"{path}: row {number}: no path")
    beside = os.path.dirname(os.path.abspath(path))
    return [dict(row, path=os.path.join(beside, str(row["path"]))) for row in rows]


def is_age(value):
    """Whether it is a number of years, or not given."""
    try:
        return value is None or not str(value).strip() or 0.0 <= float(value) < math.inf
    except ValueError:
        return False


def complete(row):
    """Texts as they are, numbers as numbers, nothing that is empty."""
    known = {key: str(value).strip() for key, value in row.items() if value is not None and str(value).strip()}
    known["path"] = os.path.abspath(known["path"])
    known["discharge_positive"] = known.get("discharge_positive", "").lower() in YES
    if "age_years" in known:
        known["age_years"] = float(known["age_years"])
    return known


def named(rows):
    """A battery without a name is called as its file; where files of several folders are called alike, with as many of these in front as distinguish them."""
    ends = {row["path"]: tuple(os.path.splitext(row["path"])[0].split(os.sep)[::-1]) for row in rows if "battery" not in row}
    in_order = sorted(set(ends.values()))  # neighbours are the most alike
    alike = [len(os.path.commonprefix(pair)) for pair in zip(in_order, in_order[1:])]
    depth = dict(zip(in_order, map(max, [0, *alike], [*alike, 0])))
    for row in rows:
        if row["path"] in ends:
            end = ends[row["path"]]
            row["battery"] = "/".join(end[depth[end]::-1])
    return rows


def column_options(entry):
    """What reports `sof` the columns of a recording."""
    options = [word for key in COLUMNS if key in entry for word in ("--" + key.replace("_", "-"), entry[key])]
    return options + (["--discharge-positive"] if entry["discharge_positive"] else [])


def window_options(entry):
    return [word for key in ("from", "to") if key + "_s" in entry for word in ("--" + key, entry[key + "_s"])]
