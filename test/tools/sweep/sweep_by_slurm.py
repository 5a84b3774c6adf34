#!/usr/bin/env python3
"""A sweep by a Slurm array on one controller and two nodes, all on the loopback interface, with workers killed, submitted again
until it is done. Then the merged file must be that of one run on one core.

usage: sweep_by_slurm.py CLEARANCE SBATCH_SCRIPT [--shards N] -- ROBOT [options of clearance]

Keys, configuration, ports and logs are its own, and all is gone at the end. Exit code 77: this machine cannot have them.
"""

import argparse
import filecmp
import os
import pathlib
import random
import signal
import socket
import subprocess
import sys
import tempfile
import time

from hosts import kill, processes_of, random_pause, require_programs, run, skip, wait_until

NODES = ("node1", "node2")


def free_ports(count):
    probes = [socket.socket() for _ in range(count)]
    for probe in probes:
        probe.bind(("127.0.0.1", 0))
    ports = [probe.getsockname()[1] for probe in probes]
    for probe in probes:
        probe.close()
    return ports


class Slurm:
    """munge, slurmctld and two slurmd, while the with statement lasts."""

    def __init__(self, folder):
        self.folder = folder
        self.daemons = []

    def __enter__(self):
        try:
            self.start()
        except BaseException:
            self.stop()
            raise
        return self

    def __exit__(self, *error):
        self.stop()

    def start(self):
        self.write_configuration()
        os.environ["SLURM_CONF"] = str(self.folder / "slurm.conf")
        self.daemon("/usr/sbin/munged", "--foreground", f"--key-file={self.folder}/munge/key", f"--socket={self.folder}/munge.socket",
                    f"--pid-file={self.folder}/munge/pid", f"--log-file={self.folder}/munge/log", f"--seed-file={self.folder}/munge/seed")
        wait_until((self.folder / "munge.socket").exists, lambda: f"munged: {self.logs()}")
        self.daemon("/usr/sbin/slurmctld", "-D")
        for node in NODES:
            self.daemon("/usr/sbin/slurmd", "-D", "-N", node)
        wait_until(self.has_idle_nodes, lambda: f"two idle nodes: {self.logs()}")

    def write_configuration(self):
        host = socket.gethostname().split(".")[0]
        ports = free_ports(1 + len(NODES))
        for name in ("munge", "state", "spool"):
            (self.folder / name).mkdir()
        (self.folder / "munge").chmod(0o700)
        (self.folder / "munge" / "key").write_bytes(os.urandom(128))
        (self.folder / "munge" / "key").chmod(0o600)
        nodes = "".join(f"NodeName={node} NodeHostname={host} NodeAddr=127.0.0.1 Port={port} CPUs=1\n"
                        for node, port in zip(NODES, ports[1:]))
        (self.folder / "slurm.conf").write_text(
            f"ClusterName=sweep\nSlurmctldHost={host}(127.0.0.1)\nSlurmctldPort={ports[0]}\nSlurmUser=root\n"
            f"AuthType=auth/munge\nAuthInfo=socket={self.folder}/munge.socket\nCredType=cred/munge\n"
            f"StateSaveLocation={self.folder}/state\nSlurmdSpoolDir={self.folder}/spool/%n\n"
            f"SlurmctldPidFile={self.folder}/slurmctld.pid\nSlurmdPidFile={self.folder}/%n.pid\n"
            "ProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\nSwitchType=switch/none\nMpiDefault=none\n"
            "SelectType=select/cons_tres\nSelectTypeParameters=CR_Core\nReturnToService=2\n"
            f"SchedulerParameters=batch_sched_delay=0,sched_interval=1\n{nodes}"
            f"PartitionName=all Nodes={','.join(NODES)} Default=YES MaxTime=INFINITE State=UP\n")

    def daemon(self, *command):
        log = open(self.folder / f"daemon_{len(self.daemons)}.log", "w")
        self.daemons.append(subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=log))

    def logs(self):
        return "".join(path.read_text()[-1000:] for path in sorted(self.folder.glob("daemon_*.log")))

    def has_idle_nodes(self):
        for daemon in self.daemons:
            if daemon.poll() is not None:
                skip(f"{daemon.args[0]} does not run here: {self.logs()}")
        found = subprocess.run(["sinfo", "--noheader", "--Node", "--states=idle"], capture_output=True, text=True)
        return len(found.stdout.splitlines()) == len(NODES)

    def stop(self):
        """Slurm's daemons first, as they ask munge."""
        for daemon in reversed(self.daemons):
            if daemon.poll() is None:
                daemon.terminate()
        for daemon in reversed(self.daemons):
            try:
                daemon.wait(timeout=10)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()


def submit(options, folder, parts):
    log = open(folder / "sbatch.log", "a")
    command = ["sbatch", "--wait", f"--array=1-{options.shards}", f"--output={folder}/task_%a.log", options.script, options.shards,
               *options.words, "--out", parts]
    return subprocess.Popen([str(word) for word in command], cwd=folder, stdin=subprocess.DEVNULL, stdout=log, stderr=log)


def kill_workers(parts, submitted, count):
    """Returns how many were killed before the array ended."""
    chance, killed = random.Random(1), set()
    while submitted.poll() is None and len(killed) < count:
        running = [worker for worker in processes_of("clearance", parts) if worker not in killed]
        if running:
            random_pause(chance, 0.2)
            worker = chance.choice(running)
            if worker in processes_of("clearance", parts) and kill(worker):
                killed.add(worker)
        else:
            time.sleep(0.005)
    return len(killed)


def sweep(options, folder):
    parts, clearance = folder / "parts", pathlib.Path(options.clearance).resolve()
    with Slurm(folder):
        killed = rounds = 0
        while True:
            rounds += 1
            submitted = submit(options, folder, parts)
            killed += kill_workers(parts, submitted, 2 if rounds <= 2 else 0)
            code = submitted.wait(timeout=120)
            print(f"round {rounds}: array ended with {code}, {killed} workers killed", flush=True)
            if code == 0:
                break
            logs = "".join(path.read_text()[-500:] for path in sorted(folder.glob("task_*.log")))
            assert rounds < 10, f"{(folder / 'sbatch.log').read_text()}\n{logs}"
    assert killed >= 2 and rounds >= 2, f"{killed} workers killed in {rounds} rounds"
    run(clearance, "--merge", parts, "--out", folder / "merged", "--summary", folder / "merged.json")
    run("taskset", "-c", "0", clearance, *options.words, "--threads", "1", "--out", folder / "whole", "--summary", folder / "whole.json",
        stderr=subprocess.DEVNULL)
    assert filecmp.cmp(folder / "merged", folder / "whole", shallow=False), "the merged file is not that of one run"
    assert (folder / "merged.json").read_text() == (folder / "whole.json").read_text(), "the merged summary is not that of one run"


def main():
    arguments = sys.argv[1:]
    split = arguments.index("--")
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("clearance")
    parser.add_argument("script")
    parser.add_argument("--shards", type=int, default=8)
    options = parser.parse_args(arguments[:split])
    options.words = arguments[split + 1:]
    options.script = pathlib.Path(options.script).resolve()
    if os.geteuid() != 0:
        skip("the daemons of Slurm are started by root")
    require_programs("sbatch", "slurmctld", "slurmd", "munged", "taskset")
    signal.signal(signal.SIGTERM, lambda number, frame: sys.exit(1))  # so that all is removed then, too
    os.environ["PATH"] = f"{pathlib.Path(options.clearance).resolve().parent}:{os.environ['PATH']}"
    with tempfile.TemporaryDirectory(prefix="slurm_") as name:
        os.chmod(name, 0o755)
        sweep(options, pathlib.Path(name))


if __name__ == "__main__":
    main()
