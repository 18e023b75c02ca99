"""The sealed benchmark of `sof diagnose`: seal, run, score (docs/proof.md)."""
