"""Repeats the paper's section V on simulated recordings."""
