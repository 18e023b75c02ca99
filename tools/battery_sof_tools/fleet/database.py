"""One SQLite file from a fleet's folder, by one writer; the folder from the file; tables as CSV; a digest of what is in it."""

import csv
import hashlib
import json
import os
import sqlite3
import urllib.parse
import zlib

from ..files import require_regular, utf8, write_json
from . import plan, rows, schema, stored

NAME = "fleet.sqlite"
REMEDY = "sof-fleet load makes it again from its folder"
MAX_BYTES = 1 << 28  # of one file in it


def path_of(folder):
    """Of a folder's database, or of a database itself."""
    return os.path.join(folder, NAME) if os.path.isdir(folder) else folder


def open_read(folder):
    """SystemExit with a sentence where there is no database, it is of another version, or anything in it is not of its kind."""
    path = path_of(folder)
    if not os.path.exists(path):
        raise SystemExit(f"{path}: no database; sof-fleet run or load makes one")
    require_regular(path)
    base = sqlite3.connect(f"file:{urllib.parse.quote(os.fsencode(os.path.abspath(path)))}?mode=ro", uri=True)
    base.row_factory = sqlite3.Row
    base.text_factory = lambda raw: text_of(path, raw)
    try:
        version = base.execute("SELECT value FROM fleet WHERE name = 'version'").fetchone()
        fault = schema.fault(base) if version and version[0] == str(schema.VERSION) else None
    except (sqlite3.Error, UnicodeDecodeError) as error:  # sqlite's own message may quote what is no UTF-8
        version, fault = (str(schema.VERSION),), str(error)
    if fault:
        raise SystemExit(f"{path} is damaged: {fault}; {REMEDY}")
    if version is None or version[0] != str(schema.VERSION):
        raise SystemExit(f"{path}: schema {version and version[0]}, this program knows {schema.VERSION}; {REMEDY}")
    return base


def text_of(path, raw):
    try:
        return raw.decode()
    except UnicodeDecodeError:
        raise SystemExit(f"{path} is damaged: a text in it is no UTF-8; {REMEDY}") from None


def told(folder, key):
    """The steps' files of a recording by step. One that is damaged is a step without an answer, and its reason."""
    where, found = plan.results(folder, key), {}
    for step in plan.STEPS:
        path = os.path.join(where, step + ".json")
        try:
            if os.path.lexists(path):
                found[step] = stored.read(path, stored.step(step), "delete it and call sof-fleet run again")
        except SystemExit as damaged:
            found[step] = {"exit": None, "reason": str(damaged), "answer": None, "cost": None}
    return found


def files_of(folder, key):
    where = plan.results(folder, key)
    for name in sorted(os.listdir(where)) if os.path.isdir(where) else ():
        path = os.path.join(where, name)
        is_plain = os.path.isfile(path) and not os.path.islink(path) and os.path.getsize(path) <= MAX_BYTES  # of the folder itself
        if stored.FILE_NAME.fullmatch(name) and is_plain:
            with open(path, "rb") as file:
                content = file.read()
            yield key, name, len(content), zlib.compress(content, 6)


def content(row):
    """Of a file. SystemExit where it is not what was packed."""
    unpacking = zlib.decompressobj()
    try:
        found = unpacking.decompress(row["content"], min(row["bytes"], MAX_BYTES) + 1)
    except zlib.error:
        found = None
    if found is None or len(found) != row["bytes"]:
        raise SystemExit(f"the database is damaged: {row['name']} of recording {row['recording']} cannot be unpacked; {REMEDY}")
    return found


def insert(base, table, lines):
    lines = [[utf8(cell) if isinstance(cell, str) else cell for cell in line] for line in lines]
    if lines:
        base.executemany(f"INSERT INTO {table} VALUES ({', '.join('?' * len(lines[0]))})", lines)


def load(folder):
    """Makes a folder's database again: written beside, then renamed. Rows are in the order of keys, whoever worked on them and when.

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
        insert(base, "file", list(files_of(folder, entry["key"])))
    base.commit()
    base.close()
    os.replace(beside, path)
    return len(recordings)


def rebuild(database, folder):
    """The folder that a database was loaded from: results, plan and recordings. SystemExit where the folder holds something, or a file would lie elsewhere."""
    if os.path.isdir(folder) and os.listdir(folder):
        raise SystemExit(f"{folder} is not empty")
    base = open_read(database)
    for row in base.execute("SELECT recording, name FROM file"):
        if not stored.FILE_NAME.fullmatch(row["name"]):
            raise SystemExit(f"{path_of(database)}: a file of recording {row['recording']} is called {row['name']!r}, expected a plain name of a .json, .yaml or .html file; nothing was written")
    try:
        kept = stored.require({row["name"]: json.loads(row["value"]) for row in base.execute("SELECT * FROM fleet") if row["name"] != "version"}, stored.FLEET)
        entries = [entry_of(row, base) for row in base.execute("SELECT * FROM recording ORDER BY recording")]
    except (ValueError, RecursionError) as fault:
        raise SystemExit(f"{path_of(database)} is damaged: {fault}; nothing was written") from None
    os.makedirs(folder, exist_ok=True)
    write_json(os.path.join(folder, "fleet.json"), kept)
    write_json(os.path.join(folder, "recordings.json"), entries)
    for row in base.execute("SELECT * FROM file"):
        where = plan.results(folder, row["recording"])
        os.makedirs(where, exist_ok=True)
        with open(os.path.join(where, row["name"]), "xb") as file:
            file.write(content(row))


def entry_of(row, base):
    """A recording as plan.py describes it."""
    unreadable = None
    if row["sha256"] is None:
        reason = base.execute("SELECT reason FROM step WHERE recording = ? AND reason IS NOT NULL", (row["recording"],)).fetchone()
        unreadable = reason[0] if reason else "cannot be read"
    entry = {"discharge_positive": False, **stored.parsed(row["options"], stored.OPTIONS), "path": row["path"], "battery": row["battery"], "key": row["recording"], "sha256": row["sha256"],
             "bytes": row["bytes"], "unreadable": unreadable}
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


def digest(folder):
    """SHA-256 of every row but measured times, as sorted text: the same for the same recordings, whatever engine, order and number of cores."""
    base = open_read(folder)
    rows = sorted(json.dumps([table, *row]) for table in schema.TABLES if table not in schema.MEASURED for row in base.execute(f"SELECT * FROM {table}"))
    return hashlib.sha256("\n".join(rows).encode()).hexdigest()
