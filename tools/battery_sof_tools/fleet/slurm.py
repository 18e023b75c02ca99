"""A Slurm of this machine alone, on loopback, to try `sof-fleet run --slurm`: munge, slurmctld and slurmd, started and stopped by process id.

    sof-fleet slurm start FOLDER     prints the SLURM_CONF to set
    sof-fleet slurm stop FOLDER

Needs root, as slurmd does. Nothing outside FOLDER is written, and no other Slurm or munge is touched.
"""

import os
import shutil
import signal
import subprocess
import sys
import time

PORT = 26817  # of slurmctld; slurmd has the next one: not those of a Slurm that may be here
DAEMONS = ("slurmd", "slurmctld", "munged")  # in the order in which they are stopped
PATIENCE_S = 20.0
CONF = """ClusterName=battery_sof
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={port}
SlurmdPort={next}
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CryptoType=crypto/munge
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SwitchType=switch/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SchedulerType=sched/backfill
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
MinJobAge=30
MailProg=/bin/true
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus} State=UNKNOWN
PartitionName=fleet Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


def pid_of(folder, name):
    """Of a daemon that runs, or None."""
    try:
        with open(os.path.join(folder, name + ".pid")) as file:
            pid = int(file.read())
        with open(f"/proc/{pid}/comm") as file:
            return pid if file.read().strip() == name else None
    except (OSError, ValueError):
        return None


def until(what, holds):
    """SystemExit where something does not hold in time."""
    end = time.monotonic() + PATIENCE_S
    while not holds():
        if time.monotonic() > end:
            raise SystemExit(f"slurm: {what} within {PATIENCE_S:g} s")
        time.sleep(0.1)


def write(folder, name, content, mode=0o600):
    path = os.path.join(folder, name)
    with open(path, "wb") as file:
        file.write(content)
    os.chmod(path, mode)
    return path


def start(folder):
    """Starts the three and waits until the node takes jobs. @return path of slurm.conf."""
    missing = [name for name in DAEMONS if not found(name)]
    if missing:
        raise SystemExit(f"not installed: {', '.join(missing)}; apt-get install slurm-wlm munge")
    folder = os.path.abspath(folder)
    for name in ("state", "spool"):
        os.makedirs(os.path.join(folder, name), exist_ok=True)
    host = os.uname().nodename.split(".")[0]
    key = write(folder, "munge.key", os.urandom(128))
    conf = write(folder, "slurm.conf", CONF.format(host=host, port=PORT, next=PORT + 1, folder=folder, cpus=os.cpu_count()).encode(), 0o644)
    begin(folder, "munged", "--force", f"--key-file={key}", f"--socket={folder}/munge.socket", f"--pid-file={folder}/munged.pid", f"--log-file={folder}/munged.log",
          f"--seed-file={folder}/munge.seed")
    begin(folder, "slurmctld", "-f", conf)
    begin(folder, "slurmd", "-f", conf, "-N", host)
    until("the node takes no jobs", lambda: "idle" in told(conf))
    return conf


def found(name):
    return shutil.which(name, path=os.pathsep.join((os.environ.get("PATH", ""), "/usr/sbin", "/sbin")))


def begin(folder, name, *options):
    if pid_of(folder, name) is None:
        subprocess.run([found(name), *options], check=True, cwd=folder, stdout=subprocess.DEVNULL)
        until(f"{name} does not run", lambda: pid_of(folder, name))


def told(conf):
    return subprocess.run(["sinfo", "--noheader", "--format=%t"], capture_output=True, text=True, check=False, env=dict(os.environ, SLURM_CONF=conf)).stdout


def stop(folder):
    """Ends the three that were started in a folder, and no others."""
    folder = os.path.abspath(folder)
    for name in DAEMONS:
        pid = pid_of(folder, name)
        if pid:
            os.kill(pid, signal.SIGTERM)
            until(f"{name} does not stop", lambda: pid_of(folder, name) is None)


def main(what, folder):
    if what == "start":
        print(f"export SLURM_CONF={start(folder)}")
    else:
        stop(folder)
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
