"""One SQLite file from a fleet's folder, by one writer; the folder from the file; tables as CSV; a digest of what is in it."""

import csv
import hashlib
import json
import os
import sqlite3
import zlib

from ..files import read_json, write_json
from . import plan, rows, schema

NAME = "fleet.sqlite"


def path_of(folder):
    """Of a folder's database, or of a database itself."""
    return os.path.join(folder, NAME) if os.path.isdir(folder) else folder


def open_read(folder):
    path = path_of(folder)
    if not os.path.exists(path):
        raise SystemExit(f"{path}: no database; sof-fleet run or load makes one")
    base = sqlite3.connect(f"file:{path}?mode=ro", uri=True)
    base.row_factory = sqlite3.Row
    version = base.execute("SELECT value FROM fleet WHERE name = 'version'").fetchone()
    if version is None or int(version[0]) != schema.VERSION:
        raise SystemExit(f"{path}: schema {version and version[0]}, this program knows {schema.VERSION}; sof-fleet load makes it anew from its folder")
    return base


def told(folder, key):
    """The steps' files of a recording by step."""
    where = plan.results(folder, key)
    return {step: read_json(os.path.join(where, step + ".json")) for step in plan.STEPS if os.path.exists(os.path.join(where, step + ".json"))}


def files_of(folder, key, with_pages):
    where = plan.results(folder, key)
    for name in sorted(os.listdir(where)) if os.path.isdir(where) else ():
        if name.endswith((".json", ".yaml")) or (with_pages and name.endswith(".html")):
            with open(os.path.join(where, name), "rb") as file:
                content = file.read()
            yield key, name, len(content), zlib.compress(content, 6)


def answers(base, step):
    """(recording, what a step answered) of all recordings that it was asked of, without what the engine says of it."""
    for row in base.execute("SELECT recording, content FROM file WHERE name = ? ORDER BY recording", (step + ".json",)):
        yield row["recording"], json.loads(zlib.decompress(row["content"])).get("answer") or {}


def insert(base, table, lines):
    if lines:
        base.executemany(f"INSERT INTO {table} VALUES ({', '.join('?' * len(lines[0]))})", lines)


def load(folder, with_pages=True):
    """Makes a folder's database anew: written beside, then renamed. Rows are in the order of keys, whoever worked on them and when.

    @return recordings in it.
    """
    kept, recordings = plan.load(folder)
    path = os.path.join(folder, NAME)
    beside = path + ".part"
    if os.path.exists(beside):
        os.remove(beside)
    base = sqlite3.connect(beside)
    base.execute("PRAGMA journal_mode = OFF")
    base.execute("PRAGMA synchronous = OFF")  # a file that was not finished is not used
    for statement in schema.statements():
        base.execute(statement)
    insert(base, "fleet", sorted(dict({name: json.dumps(kept[name]) for name in kept}, version=str(schema.VERSION)).items()))
    for entry in recordings:
        for table, lines in rows.of_recording(entry, told(folder, entry["key"])).items():
            insert(base, table, lines)
        insert(base, "file", list(files_of(folder, entry["key"], with_pages)))
    base.commit()
    base.close()
    os.replace(beside, path)
    return len(recordings)


def rebuild(database, folder):
    """The folder that a database was loaded from: results, plan and recordings. SystemExit where the folder holds something."""
    if os.path.isdir(folder) and os.listdir(folder):
        raise SystemExit(f"{folder} is not empty")
    base = open_read(database)
    os.makedirs(folder, exist_ok=True)
    write_json(os.path.join(folder, "fleet.json"), {row["name"]: json.loads(row["value"]) for row in base.execute("SELECT * FROM fleet") if row["name"] != "version"})
    write_json(os.path.join(folder, "recordings.json"), [entry_of(row, base) for row in base.execute("SELECT * FROM recording ORDER BY recording")])
    for row in base.execute("SELECT * FROM file"):
        where = plan.results(folder, row["recording"])
        os.makedirs(where, exist_ok=True)
        with open(os.path.join(where, row["name"]), "wb") as file:
            file.write(zlib.decompress(row["content"]))


def entry_of(row, base):
    """A recording as plan.py describes it."""
    unreadable = None
    if row["sha256"] is None:
        unreadable = base.execute("SELECT reason FROM step WHERE recording = ?", (row["recording"],)).fetchone()[0]
    entry = dict({"discharge_positive": False}, **json.loads(row["options"]), path=row["path"], battery=row["battery"], key=row["recording"], sha256=row["sha256"], bytes=row["bytes"],
                 unreadable=unreadable)
    return dict(entry, **{name: row[name] for name in ("vehicle_type", "age_years") if row[name] is not None})


def export(folder, out):
    """One CSV file a table, but for the files' contents. A missing number is an empty cell."""
    base = open_read(folder)
    os.makedirs(out, exist_ok=True)
    for table in schema.TABLES:
        if table == "file":
            continue
        lines = base.execute(f"SELECT * FROM {table} ORDER BY rowid")
        with open(os.path.join(out, table + ".csv"), "w", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow([column[0] for column in lines.description])
            writer.writerows(lines)


def contents(folder):
    """Every row but measured times, as sorted text: the same for the same recordings, whatever engine, order and number of cores."""
    base = open_read(folder)
    return sorted(json.dumps([table, *row]) for table in schema.TABLES if table not in schema.MEASURED for row in base.execute(f"SELECT * FROM {table}"))


def digest(folder):
    return hashlib.sha256("\n".join(contents(folder)).encode()).hexdigest()
