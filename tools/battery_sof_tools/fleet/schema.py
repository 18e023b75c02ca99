"""The database of a fleet: tables, their columns, and the version (docs/fleet.md has what they mean)."""

VERSION = 3

# Every table but `fleet` begins with the recording's key. Rows are in the order of the columns in ORDER.
TABLES = {
    "fleet": "name TEXT PRIMARY KEY, value TEXT",
    "recording": "recording TEXT PRIMARY KEY, name TEXT, path TEXT, sha256 TEXT, bytes INTEGER, battery TEXT, vehicle_type TEXT, age_years REAL, options TEXT, outcome TEXT, reason TEXT, "
                 "samples INTEGER, from_s REAL, to_s REAL, median_interval_s REAL, temperature_min_c REAL, temperature_max_c REAL, charger_present INTEGER, charger_share REAL",
    "step": "recording TEXT, step TEXT, exit INTEGER, reason TEXT, PRIMARY KEY (recording, step)",
    "finding": "recording TEXT, id TEXT, severity TEXT, value REAL, unit TEXT, samples INTEGER, what TEXT",
    "window": "recording TEXT, from_s REAL, to_s REAL, samples INTEGER, effects TEXT, status TEXT, window_quality REAL, q_dyn_percent REAL, rmse_v REAL",
    "parameter": "recording TEXT, source TEXT, effects TEXT, name TEXT, value REAL, std REAL, unit TEXT, determined INTEGER, at_bound INTEGER",
    "prediction": "recording TEXT, from_s REAL, to_s REAL, q_dyn_percent REAL, rmse_v REAL, max_abs_v REAL, coverage_90 REAL, crank_mae_v REAL, cranks INTEGER, "
                  "share_percent REAL, baseline_share_percent REAL, baseline_crank_mae_v REAL",
    "verdict": "recording TEXT PRIMARY KEY, verdict TEXT, mechanism TEXT, probability REAL, gain REAL, summary TEXT, base_rmse_v REAL, extended_rmse_v REAL",
    "mechanism": "recording TEXT, mechanism TEXT, probability REAL, effects TEXT, PRIMARY KEY (recording, mechanism)",
    "candidate": "recording TEXT, id TEXT, mechanism TEXT, evidence REAL, confidence REAL, rejected_because TEXT",
    "change": "recording TEXT PRIMARY KEY, reference TEXT, verdict TEXT, id TEXT, mechanism TEXT, now REAL, unit TEXT, lower REAL, upper REAL, probability REAL, indistinguishable TEXT, "
              "summary TEXT",
    "score": "recording TEXT, start_s REAL, effects TEXT, window_quality REAL, share_percent REAL, current_share_percent REAL, voltage_share_percent REAL, crank_mae_v REAL, "
             "baseline_share_percent REAL, baseline_crank_mae_v REAL",
    "cost": "recording TEXT, step TEXT, wall_s REAL, cpu_s REAL, PRIMARY KEY (recording, step)",
    "file": "recording TEXT, name TEXT, bytes INTEGER, content BLOB, PRIMARY KEY (recording, name)",
}
# Columns that are never NULL, beside those of the tables' keys.
REQUIRED = {"fleet": ("value",), "recording": ("name", "path", "bytes", "battery", "options", "outcome"), "finding": ("id", "severity", "what"), "window": ("effects",),
            "parameter": ("source", "effects", "name"), "verdict": ("verdict",), "mechanism": ("effects",), "candidate": ("id", "mechanism"), "change": ("reference", "verdict"), "score": ("start_s", "effects"),
            "file": ("bytes", "content")}
MEASURED = ("cost", "file")  # differ from run to run: times are in both

INDICES = ("CREATE INDEX recording_by_battery ON recording (battery)", "CREATE INDEX parameter_by_name ON parameter (name)", "CREATE INDEX mechanism_by_name ON mechanism (mechanism)")


def statement(table):
    return f"CREATE TABLE {table} ({TABLES[table]})"


def statements():
    return [statement(table) for table in TABLES] + list(INDICES)


def fault(base):
    """What is wrong with a database whatever is in it, in words: damaged pages, other tables, or a cell that is not of its column's type. None where nothing is."""
    said = base.execute("PRAGMA quick_check(1)").fetchone()[0]
    if said != "ok":
        return " ".join(said.split())
    made = dict(base.execute("SELECT name, sql FROM sqlite_master WHERE type = 'table'").fetchall())
    wrong = [table for table in TABLES if made.get(table) != statement(table)]
    if wrong:
        return f"its table {wrong[0]} is not that of schema {VERSION}"
    return next(filter(None, (fault_of(base, table) for table in TABLES)), None)


def fault_of(base, table):
    for _, column, kind, _, _, place in base.execute(f"PRAGMA table_info({table})").fetchall():
        never = place or column == "recording" or column in REQUIRED.get(table, ())
        allowed = f"'{kind.lower()}'" + ("" if never else ", 'null'")
        wrong = f"typeof({column}) NOT IN ({allowed})"
        if column == "recording":
            wrong += f" OR length({column}) != 16 OR {column} GLOB '*[^0-9a-f]*'"
        if kind == "REAL":
            wrong += f" OR abs({column}) = 9e999"
        found = base.execute(f"SELECT quote({column}) FROM {table} WHERE {wrong}").fetchone()
        if found:
            return f"{column} of table {table} is {found[0][:40]}"
    return None
