"""Cases whose labels are sealed before anything is asked: seal, run, score (docs/archive/proof.md)."""
