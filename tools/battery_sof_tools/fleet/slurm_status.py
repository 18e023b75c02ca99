#!/usr/bin/python3
"""What Snakemake asks of a job of Slurm: prints running, success or failed. A job that Slurm no longer knows has ended; its output says how."""
import subprocess
import sys

ENDED_WELL, ENDED = ("COMPLETED",), ("BOOT_FAIL", "CANCELLED", "DEADLINE", "FAILED", "NODE_FAIL", "OUT_OF_MEMORY", "PREEMPTED", "TIMEOUT")

told = subprocess.run(["squeue", "--noheader", "--states=all", "--format=%T", "--jobs", sys.argv[1]], capture_output=True, text=True, check=False)
state = told.stdout.strip()
print("failed" if state in ENDED else "success" if state in ENDED_WELL or not state else "running")
