"""Snakemake on what a folder still lacks: on this machine's cores, or as jobs of Slurm."""

import fcntl
import hashlib
import json
import os
import shutil
import subprocess
import sys

from ..files import write_json
from . import plan

HERE = os.path.dirname(os.path.abspath(__file__))
TOOLS = os.path.dirname(os.path.dirname(HERE))
SNAKEMAKE = "snakemake"
WITH_US = ("setpriv", "--pdeathsig", "TERM")  # ends with the process that called it
RETRIES = 1  # of a job that was lost; what fails for a reason is a row and no lost job


def alone(folder):
    """A lock on the folder that ends with this process, however it ends. SystemExit where another run has it."""
    lock = open(os.path.join(folder, "lock"), "w")
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise SystemExit(f"{folder}: another sof-fleet is at work there") from None
    return lock


def lay_groups(folder, todo, cores):
    """Writes the groups of what is left to do, in place of those of an earlier run."""
    for name in ("groups", "done"):
        shutil.rmtree(os.path.join(folder, name), ignore_errors=True)
        os.makedirs(os.path.join(folder, name))
    made = plan.groups(todo, cores)
    for number, keys in enumerate(made):
        name = hashlib.sha256(json.dumps(keys).encode()).hexdigest()[:8]
        write_json(os.path.join(folder, "groups", f"{number:05d}_{name}.json"), keys)
    return len(made)


def command(folder, jobs, slurm):
    engine = ["--cores", str(jobs)]
    if slurm:
        engine = ["--cluster", "sbatch --parsable --cpus-per-task=1 --output=slurm/%j.log", "--cluster-status", os.path.join(HERE, "slurm_status.py"),
                  "--cluster-cancel", "scancel", "--jobs", str(jobs), "--max-status-checks-per-second", "5", "--latency-wait", "60"]
    return [SNAKEMAKE, "--snakefile", os.path.join(HERE, "Snakefile"), "--directory", folder, "--keep-going", "--nolock", "--rerun-incomplete", "--rerun-triggers", "mtime",
            "--restart-times", str(RETRIES), "--quiet", "rules", "--config", "python=" + sys.executable, *engine]


def run(folder, entries, steps, jobs, slurm):
    """Runs what is missing. @return recordings that still lack a step afterwards."""
    todo = [one for one in entries if plan.missing(folder, one["key"], steps)]
    print(f"{len(entries)} recordings, {len(entries) - len(todo)} done before", file=sys.stderr, flush=True)
    if todo:
        if not shutil.which(SNAKEMAKE):
            raise SystemExit("snakemake is not installed: apt-get install snakemake")
        count = lay_groups(folder, todo, jobs)
        os.makedirs(os.path.join(folder, "slurm"), exist_ok=True)
        print(f"{len(todo)} recordings in {count} jobs", file=sys.stderr, flush=True)
        # With this package first, as jobs are processes of their own.
        environment = dict(os.environ, PYTHONPATH=os.pathsep.join(filter(None, (TOOLS, os.environ.get("PYTHONPATH")))), PYTHONDONTWRITEBYTECODE="1")
        with open(os.path.join(folder, "engine.log"), "a") as log:
            subprocess.run([*WITH_US, *command(os.path.abspath(folder), jobs, slurm)], stdout=log, stderr=log, env=environment, check=False)
    return [one for one in todo if plan.missing(folder, one["key"], steps)]
