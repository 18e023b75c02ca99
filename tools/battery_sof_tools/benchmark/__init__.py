"""The benchmarks of `sof diagnose`: preregistered, out of the model, on measured recordings, and the calibration of its thresholds.

generator draws cases, answers holds what is kept of an answer and what a case is, runner asks, scorers count and print.
"""
