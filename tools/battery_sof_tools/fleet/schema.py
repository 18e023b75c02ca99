"""The database of a fleet: tables, their columns, and the version (docs/fleet.md has what they mean)."""

VERSION = 1

# Every table but `fleet` begins with the recording's key. Rows are in the order of the columns in ORDER.
TABLES = {
    "fleet": "name TEXT PRIMARY KEY, value TEXT",
    "recording": "recording TEXT PRIMARY KEY, name TEXT, path TEXT, sha256 TEXT, bytes INTEGER, battery TEXT, vehicle_type TEXT, age_years REAL, options TEXT, outcome TEXT, reason TEXT, "
                 "samples INTEGER, from_s REAL, to_s REAL, median_interval_s REAL, temperature_min_c REAL, temperature_max_c REAL, source_seen INTEGER, source_share REAL",
    "step": "recording TEXT, step TEXT, exit INTEGER, reason TEXT, PRIMARY KEY (recording, step)",
    "finding": "recording TEXT, id TEXT, severity TEXT, value REAL, unit TEXT, samples INTEGER, what TEXT",
    "window": "recording TEXT, from_s REAL, to_s REAL, samples INTEGER, effects TEXT, status TEXT, suitability REAL, q_dyn_percent REAL, rmse_v REAL",
    "parameter": "recording TEXT, source TEXT, effects TEXT, name TEXT, value REAL, std REAL, unit TEXT, determined INTEGER, at_bound INTEGER",
    "prediction": "recording TEXT, from_s REAL, to_s REAL, q_dyn_percent REAL, rmse_v REAL, max_abs_v REAL, coverage_90 REAL, crank_mae_v REAL, cranks INTEGER, "
                  "share_percent REAL, naive_share_percent REAL, naive_crank_mae_v REAL",
    "verdict": "recording TEXT PRIMARY KEY, verdict TEXT, family TEXT, probability REAL, gain REAL, summary TEXT, base_rmse_v REAL, extended_rmse_v REAL",
    "family": "recording TEXT, family TEXT, probability REAL, effects TEXT, PRIMARY KEY (recording, family)",
    "candidate": "recording TEXT, id TEXT, family TEXT, evidence REAL, probability REAL, rejected_because TEXT",
    "score": "recording TEXT, start_s REAL, effects TEXT, suitability REAL, share_percent REAL, current_share_percent REAL, voltage_share_percent REAL, crank_mae_v REAL, "
             "naive_share_percent REAL, naive_crank_mae_v REAL",
    "cost": "recording TEXT, step TEXT, wall_s REAL, cpu_s REAL, PRIMARY KEY (recording, step)",
    "file": "recording TEXT, name TEXT, bytes INTEGER, content BLOB, PRIMARY KEY (recording, name)",
}
MEASURED = ("cost", "file")  # differ from run to run: times are in both

INDICES = ("CREATE INDEX recording_by_battery ON recording (battery)", "CREATE INDEX parameter_by_name ON parameter (name)", "CREATE INDEX family_by_name ON family (family)")


def statements():
    return [f"CREATE TABLE {name} ({columns})" for name, columns in TABLES.items()] + list(INDICES)
