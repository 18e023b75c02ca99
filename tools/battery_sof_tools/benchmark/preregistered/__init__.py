"""Cases whose labels are sealed before anything is asked: seal, run, score (docs/validation.md)."""
