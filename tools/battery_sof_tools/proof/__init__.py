"""The sealed benchmark of `sof diagnose`: seal, run, score (docs/validation.md)."""
