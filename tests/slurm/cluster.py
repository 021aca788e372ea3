"""A real Slurm on this machine alone, from Debian's packages, for as long as a test takes.

Needs the superuser: munge and Slurm's daemons change users, and compute jobs look for their configuration in
``/etc/slurm/slurm.conf`` whatever ``SLURM_CONF`` says. A configuration that is there already is left alone: then this
machine belongs to a cluster, and nothing is started.
"""

import contextlib
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

PACKAGES = ("munge", "slurmctld", "slurmd", "slurm-client")
PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scontrol")
CONFIGURATION = Path("/etc/slurm/slurm.conf")
# First line of a configuration that this script wrote; one that a killed run left may be replaced.
OURS = "# A Slurm of one machine, made for a test (python -m tests.slurm)"
TEMPLATE = """{ours}
ClusterName=camid
SlurmctldHost={host}(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
CredType=cred/munge
MpiDefault=none
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerType=sched/backfill
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
ReturnToService=2
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
# Ended jobs are remembered long enough to be asked about: there is no accounting.
MinJobAge=300
# A node that answers no more counts as lost after this many seconds.
SlurmdTimeout=20
NodeName={host} NodeAddr=127.0.0.1 CPUs={cores} RealMemory={megabytes} State=UNKNOWN
PartitionName=main Nodes={host} Default=YES MaxTime=INFINITE State=UP
"""
START_SECONDS = 60.0


def missing():
    """Programs of Slurm and munge that are not installed."""
    os.environ["PATH"] += f"{os.pathsep}/usr/sbin"
    return [name for name in PROGRAMS if shutil.which(name) is None]


def refusal():
    """Why no cluster can be started here; None if one can."""
    if sys.platform != "linux" or os.getuid() != 0:
        return "starting a Slurm needs Linux and the superuser"
    if names := missing():
        return f"{', '.join(names)} not found; on Debian: apt-get install {' '.join(PACKAGES)}"
    if CONFIGURATION.exists() and not CONFIGURATION.read_text(encoding="utf-8").startswith(OURS):
        return f"{CONFIGURATION} is there: this machine belongs to a cluster, use that one (docs/cluster.md)"
    return None


def megabytes():
    """Memory that the node offers: most of what is free."""
    return int(0.8 * os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") / 2**20)


class Cluster:
    """The daemons of one machine, started by :func:`one_machine`.

    ``folder`` holds state, logs and the numbers of the processes.
    """

    def __init__(self, folder):
        self.folder = folder
        self.host = socket.gethostname().split(".")[0]
        self.munged = None

    def start(self):
        """Start munge unless it runs, the controller and the node; wait until the node is idle."""
        (self.folder / "state").mkdir(parents=True)
        (self.folder / "spool").mkdir()
        CONFIGURATION.parent.mkdir(exist_ok=True)
        values = {"ours": OURS, "host": self.host, "folder": self.folder}
        text = TEMPLATE.format(**values, cores=os.cpu_count(), megabytes=megabytes())
        CONFIGURATION.write_text(text, encoding="utf-8")
        self._start_munge()
        subprocess.run(["slurmctld", "-c"], check=True, capture_output=True)
        self.start_node()

    def _start_munge(self):
        if subprocess.run("munge -n | unmunge", shell=True, capture_output=True, check=False).returncode == 0:
            return
        if not Path("/etc/munge/munge.key").exists():
            subprocess.run(["mungekey", "--create"], check=True)
            shutil.chown("/etc/munge/munge.key", "munge", "munge")
        for folder in ("/run/munge", "/var/log/munge", "/var/lib/munge"):
            Path(folder).mkdir(mode=0o755, exist_ok=True)
            shutil.chown(folder, "munge", "munge")
        subprocess.run(["runuser", "-u", "munge", "--", "munged"], check=True, capture_output=True)
        self.munged = int(Path("/run/munge/munged.pid").read_text())

    def start_node(self):
        """Start the node's daemon, and wait until Slurm takes jobs."""
        subprocess.run(["slurmd"], check=True, capture_output=True)
        end = time.monotonic() + START_SECONDS
        while time.monotonic() < end:
            state = self.ask("sinfo", "-h", "-o", "%t")
            if state in {"idle", "mix", "alloc"}:
                return
            time.sleep(0.3)
        raise RuntimeError(f"the node is {state!r} after {START_SECONDS:g} s; see {self.folder}/*.log")

    def ask(self, *command):
        """What a command of Slurm prints."""
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
        return done.stdout.strip()

    def running(self):
        """Numbers of the jobs that run."""
        return self.ask("squeue", "-h", "-t", "R", "-o", "%i").split()

    def wait_until_empty(self, seconds=180.0):
        """Whether no job is left within some seconds."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if not self.ask("squeue", "-h", "-t", "PD,R,CG", "-o", "%i"):
                return True
            time.sleep(0.5)
        return False

    def step_daemons(self, job=""):
        """Processes of ``slurmstepd``, of a job or of all, by what they call themselves: ``slurmstepd: [7.batch]``."""
        return [pid for pid, command in processes() if command.startswith(f"slurmstepd: [{job}")]

    def kill_node(self):
        """SIGKILL to the node's daemon and all its jobs, as a power cut would."""
        job_processes = [int(n) for n in self.ask("scontrol", "listpids").split() if n.isdigit() and int(n) > 1]
        node = int((self.folder / "slurmd.pid").read_text())
        scripts = {pid for job in self.running() for pid in self.job_processes(job)}
        for pid in {node, *self.step_daemons(), *scripts, *job_processes} - {os.getpid()}:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)

    def job_processes(self, job):
        """All processes below the ``slurmstepd`` of a job."""
        parents = {}
        for entry in Path("/proc").glob("[0-9]*"):
            with contextlib.suppress(OSError, ValueError):
                parents[int(entry.name)] = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
        found = set(self.step_daemons(job))
        grown = True
        while grown:
            children = {pid for pid, parent in parents.items() if parent in found} - found
            found |= children
            grown = bool(children)
        return found - set(self.step_daemons(job))

    def stop(self):
        """End what was started here, by its number."""
        self.ask("scancel", "--state=PENDING,RUNNING", f"--user={os.getuid()}")
        self.wait_until_empty(20.0)
        for name in ("slurmd.pid", "slurmctld.pid"):
            with contextlib.suppress(OSError, ValueError):
                end(int((self.folder / name).read_text()))
        if self.munged is not None:
            end(self.munged)
        CONFIGURATION.unlink(missing_ok=True)


def processes():
    """Number and command line of every process."""
    for entry in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            yield int(entry.name), (entry / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")


def end(pid):
    """Ask a process to end, and wait until it has."""
    with contextlib.suppress(ProcessLookupError):
        os.kill(pid, signal.SIGTERM)
        for _ in range(100):
            os.kill(pid, 0)
            time.sleep(0.1)
        os.kill(pid, signal.SIGKILL)


@contextlib.contextmanager
def one_machine(folder):
    """A :class:`Cluster` that runs, and is gone afterwards."""
    cluster = Cluster(folder)
    try:
        cluster.start()
        yield cluster
    finally:
        cluster.stop()
