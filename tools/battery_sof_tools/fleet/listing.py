"""Which recordings a fleet has: folders, files, and lists of files with what is known of each."""

import collections
import csv
import os

import yaml

KINDS = (".csv", ".bag")
LISTS = (".yaml", ".yml")
COLUMNS = ("time_column", "current_column", "voltage_column", "temperature_column", "topic")  # options of every subcommand of sof
KNOWN = ("path", "battery", "vehicle_type", "age_years", *COLUMNS, "discharge_positive", "from_s", "to_s", "effects")
YES = ("1", "true", "yes")


def entries(given):
    """One dictionary a recording, with the keys of KNOWN that are known of it. SystemExit with a sentence for what cannot be read."""
    found = []
    for path in given:
        found += of_folder(path) if os.path.isdir(path) else of_file(path)
    if not found:
        raise SystemExit("no recordings: give folders, .csv or .bag files, or lists of them")
    return named([complete(one) for one in found])


def of_folder(folder):
    return [{"path": os.path.join(parent, name)} for parent, _, names in sorted(os.walk(folder)) for name in sorted(names) if name.endswith(KINDS)]


def of_file(path):
    if not os.path.exists(path):
        raise SystemExit(f"{path}: no such recording, list or folder")
    if path.endswith(LISTS):
        return of_list(path, yaml_rows(path))
    if path.endswith(".csv"):
        with open(path, newline="", errors="replace") as file:
            reader = csv.DictReader(file)
            if "path" in (reader.fieldnames or ()):
                return of_list(path, list(reader))
    return [{"path": path}]


def yaml_rows(path):
    with open(path) as file:
        rows = yaml.safe_load(file)
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise SystemExit(f"{path}: a list is meant: - path: ...")
    return rows


def of_list(path, rows):
    """Paths in a list are beside it where they are not whole."""
    for number, row in enumerate(rows, 1):
        unknown = sorted(str(key) for key in row if key not in KNOWN)
        if unknown:
            raise SystemExit(f"{path}: row {number}: no column {', '.join(unknown)}; there are {', '.join(KNOWN)}")
        if not row.get("path"):
            raise SystemExit(f"{path}: row {number}: no path")
    beside = os.path.dirname(os.path.abspath(path))
    return [dict(row, path=os.path.join(beside, row["path"])) for row in rows]


def complete(row):
    """Texts as they are, numbers as numbers, nothing that is empty."""
    known = {key: str(value).strip() for key, value in row.items() if value is not None and str(value).strip()}
    known["path"] = os.path.abspath(known["path"])
    known["discharge_positive"] = known.get("discharge_positive", "").lower() in YES
    if "age_years" in known:
        known["age_years"] = float(known["age_years"])
    return known


def named(rows):
    """A battery without a name is called as its file; where files of several folders are called alike, with as many of these in front as tell them apart."""
    stems = {row["path"]: os.path.splitext(row["path"])[0] for row in rows if "battery" not in row}
    parts = {stem: stem.split(os.sep) for stem in stems.values()}
    depth = dict.fromkeys(parts, 1)
    clashes = list(parts)
    while clashes:
        alike = collections.defaultdict(list)
        for stem, folders in parts.items():
            alike["/".join(folders[-depth[stem]:])].append(stem)
        clashes = [stem for those in alike.values() if len(those) > 1 for stem in those]
        for stem in clashes:
            depth[stem] += 1
    for row in rows:
        if row["path"] in stems:
            stem = stems[row["path"]]
            row["battery"] = "/".join(parts[stem][-depth[stem]:])
    return rows


def column_options(entry):
    """What tells `sof` the columns of a recording."""
    options = [word for key in COLUMNS if key in entry for word in ("--" + key.replace("_", "-"), entry[key])]
    return options + (["--discharge-positive"] if entry["discharge_positive"] else [])


def window_options(entry):
    return [word for key in ("from", "to") if key + "_s" in entry for word in ("--" + key, entry[key + "_s"])]
