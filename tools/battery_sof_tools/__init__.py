"""What the programs in scripts/ share and consist of."""
