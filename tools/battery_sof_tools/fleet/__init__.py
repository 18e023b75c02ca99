"""Many recordings: Snakemake runs `sof` on each, one SQLite file holds what came out, one page shows it (docs/fleet.md)."""
