"""The sealed benchmark of `sof diagnose`: seal, run, score (docs/archive/proof.md)."""
