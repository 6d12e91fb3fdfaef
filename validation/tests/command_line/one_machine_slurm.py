"""Slurm on this machine alone: munged, slurmctld and slurmd on the loopback interface, in a folder of their own, as long as
a `with` lasts. Needs root, as slurmd does, and Debian's slurm-wlm and munge."""
import os
import pwd
import shutil
import socket
import subprocess
import tempfile
import time

PROGRAMS = ("munged", "slurmctld", "slurmd", "srun", "sbatch", "sinfo", "squeue", "scontrol")
CONFIGURATION = """ClusterName=atwood
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller_port}
SlurmdPort={node_port}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CredType=cred/munge
SlurmUser={user}
SlurmdUser={user}
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
MpiDefault=none
ReturnToService=2
JobRequeue=1
KillWait=1
SchedulerParameters=sched_interval=1,batch_sched_delay=0,requeue_delay=0
NodeName={host} NodeAddr=127.0.0.1 CPUs={processors} State=UNKNOWN
PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE State=UP OverSubscribe=FORCE:8
"""


def missing():
    """Why there can be no Slurm here; empty: there can."""
    if os.getuid() != 0:
        return "slurmd needs root"
    absent = [name for name in PROGRAMS if not shutil.which(name)]
    return f"{', '.join(absent)} of slurm-wlm and munge not installed" if absent else ""


def free_port():
    with socket.socket() as bound:
        bound.bind(("127.0.0.1", 0))
        return bound.getsockname()[1]


class Slurm:
    def __enter__(self):
        self.folder, self.daemons = tempfile.mkdtemp(prefix="slurm"), []
        os.chmod(self.folder, 0o755)  # munged refuses a socket that others cannot reach
        for name in ("state", "spool"):
            os.mkdir(os.path.join(self.folder, name))
        key = os.path.join(self.folder, "munge.key")
        with open(os.open(key, os.O_WRONLY | os.O_CREAT, 0o400), "wb") as file:
            file.write(os.urandom(1024))
        configuration = os.path.join(self.folder, "slurm.conf")
        with open(configuration, "w") as file:
            file.write(CONFIGURATION.format(folder=self.folder, host=socket.gethostname().partition(".")[0], processors=os.cpu_count(),
                                            user=pwd.getpwuid(os.getuid()).pw_name, controller_port=free_port(), node_port=free_port()))
        self.environment = {**os.environ, "SLURM_CONF": configuration}
        at = lambda name: os.path.join(self.folder, name)
        try:
            self.start("munged", "--foreground", "--force", "--key-file", key, "--socket", at("munge.socket"), "--pid-file", at("munged.pid"),
                       "--log-file", at("munged.log"), "--seed-file", at("munged.seed"))
            self.until("munged answers", lambda: os.path.exists(at("munge.socket")))
            self.start("slurmctld", "-D", "-f", configuration)
            self.start("slurmd", "-D", "-f", configuration)
            self.until("the node is idle", lambda: self.ask("sinfo", "-h", "-o", "%T").strip() == "idle")
        except BaseException:
            self.__exit__()
            raise
        return self

    def start(self, *words):
        with open(os.path.join(self.folder, words[0] + ".out"), "w") as out:
            self.daemons.append(subprocess.Popen(words, env=self.environment, stdout=out, stderr=out, start_new_session=True))

    def ask(self, *words, cwd=None, environment=None):
        ended = subprocess.run(words, env={**(environment or {}), **self.environment} if environment else self.environment, cwd=cwd,
                               text=True, capture_output=True, timeout=300)
        return ended.stdout if ended.returncode == 0 else ended.stdout + ended.stderr

    def until(self, what, holds, seconds=60):
        end = time.monotonic() + seconds
        while not holds():
            if time.monotonic() > end:
                tails = []
                for name in ("munged", "slurmctld", "slurmd"):
                    path = os.path.join(self.folder, name + ".out")
                    if os.path.exists(path):
                        with open(path) as file:
                            tails.append(f"{name}: {file.read()[-1500:]}")
                raise AssertionError(f"after {seconds} s not yet: {what}\n" + "\n".join(tails))
            time.sleep(0.1)

    def jobs(self):
        """Jobs and tasks that wait or run."""
        return self.ask("squeue", "-h", "-r", "-o", "%i %T").split("\n")[:-1]

    def __exit__(self, *_):
        for daemon in reversed(self.daemons):
            daemon.terminate()
            try:
                daemon.wait(20)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()
        shutil.rmtree(self.folder, ignore_errors=True)
