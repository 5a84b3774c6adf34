"""Hosts that are network namespaces, each with its own sshd, on this machine alone; and what a test of engines needs."""

import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import time

UNUSABLE = 77  # exit code of a program that cannot run here; standard error says why

SSHD = "/usr/sbin/sshd"
RUN_SSHD = pathlib.Path("/run/sshd")  # sshd needs this empty folder


def skip(reason):
    print(reason, file=sys.stderr)
    sys.exit(UNUSABLE)


def require_programs(*programs):
    for program in programs:
        if not shutil.which(program, path=os.environ["PATH"] + ":/usr/sbin:/sbin"):
            skip(f"there is no {program}")


def run(*command, **options):
    return subprocess.run([str(word) for word in command], check=True, **options)


def wait_until(holds, what, seconds=30.0):
    deadline = time.monotonic() + seconds
    while not holds():
        if time.monotonic() > deadline:
            raise RuntimeError(f"in vain: {what()}")
        time.sleep(0.02)


def processes_of(program, word):
    """The ids of the running processes of a program that have the word among their arguments."""
    found = []
    for folder in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            words = (folder / "cmdline").read_bytes().split(b"\0")
            if words[0] == str(program).encode() and str(word).encode() in words:
                found.append(int(folder.name))
        except OSError:  # it has ended
            pass
    return found


def kill(process):
    try:
        os.kill(process, signal.SIGKILL)
        return True
    except ProcessLookupError:
        return False


class Hosts:
    """A network namespace "head", from which commands are given, and two hosts that it reaches by ssh as "a" and "b".

    Keys, configuration and logs are in `folder`. All that was started and made is gone when the with statement ends.
    """

    NAMES = ("a", "b")

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.mark = f"sweep{os.getpid()}"
        self.made_run_sshd = False

    def namespace(self, name):
        return f"{self.mark}{name}"

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
        if os.geteuid() != 0:
            skip("network namespaces need root")
        require_programs("ip", "ssh", "ssh-keygen", SSHD)
        made = subprocess.run(["ip", "netns", "add", self.namespace("head")], capture_output=True, text=True)
        if made.returncode != 0:
            skip(f"there are no network namespaces: {made.stderr.strip()}")
        self.inside("head", "ip", "link", "set", "lo", "up")
        if not RUN_SSHD.exists():
            RUN_SSHD.mkdir(mode=0o755)
            self.made_run_sshd = True
        for key in ("host_key", "user_key"):
            run("ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", self.folder / key)
        for number, name in enumerate(self.NAMES, start=1):
            self.add_host(name, number)
        for name in self.NAMES:
            wait_until(lambda: self.reaches(name), lambda: f"the sshd of {name}: {self.log(name)}")

    def add_host(self, name, number):
        space, head = self.namespace(name), self.namespace("head")
        run("ip", "netns", "add", space)
        run("ip", "link", "add", f"to_{name}", "netns", head, "type", "veth", "peer", "name", "eth0", "netns", space)
        for where, device, address in ((head, f"to_{name}", f"10.213.{number}.1/30"), (space, "eth0", f"10.213.{number}.2/30")):
            run("ip", "-n", where, "address", "add", address, "dev", device)
            run("ip", "-n", where, "link", "set", device, "up")
        run("ip", "-n", space, "link", "set", "lo", "up")
        (self.folder / f"sshd_{name}").write_text(
            f"ListenAddress 10.213.{number}.2\nHostKey {self.folder}/host_key\nAuthorizedKeysFile {self.folder}/user_key.pub\n"
            "PidFile none\nStrictModes no\nUsePAM no\nPermitRootLogin prohibit-password\nPasswordAuthentication no\n"
            "ClientAliveInterval 1\nClientAliveCountMax 2\nMaxStartups 100\n")
        with open(self.folder / "ssh_config", "a") as config:
            config.write(
                f"Host {name}\n  HostName 10.213.{number}.2\n  User root\n  IdentityFile {self.folder}/user_key\n"
                "  IdentitiesOnly yes\n  UserKnownHostsFile /dev/null\n  StrictHostKeyChecking no\n  LogLevel ERROR\n  BatchMode yes\n"
                "  ConnectTimeout 2\n  ServerAliveInterval 1\n  ServerAliveCountMax 2\n")
        self.inside(name, SSHD, "-f", self.folder / f"sshd_{name}", "-E", self.folder / f"log_{name}")

    def log(self, name):
        path = self.folder / f"log_{name}"
        return path.read_text() if path.exists() else ""

    def reaches(self, name):
        return self.start_inside("head", *self.ssh(name), "true", stderr=subprocess.DEVNULL).wait() == 0

    def ssh(self, name):
        return ("ssh", "-F", str(self.folder / "ssh_config"), name)

    def inside(self, name, *command):
        return run("ip", "netns", "exec", self.namespace(name), *command)

    def start_inside(self, name, *command, **options):
        words = ["ip", "netns", "exec", self.namespace(name), *(str(word) for word in command)]
        return subprocess.Popen(words, stdin=subprocess.DEVNULL, **options)

    def cut(self, name):
        """The link to a host breaks."""
        run("ip", "-n", self.namespace("head"), "link", "set", f"to_{name}", "down")

    def mend(self, name):
        run("ip", "-n", self.namespace("head"), "link", "set", f"to_{name}", "up")

    def processes(self, name):
        found = subprocess.run(["ip", "netns", "pids", self.namespace(name)], capture_output=True, text=True)
        return [int(word) for word in found.stdout.split()]

    def stop(self):
        """Ends the processes in the namespaces, by their ids, and removes the namespaces with their links."""
        for name in ("head", *self.NAMES):
            for _ in range(100):
                if not [process for process in self.processes(name) if kill(process)]:
                    break
                time.sleep(0.02)
            subprocess.run(["ip", "netns", "del", self.namespace(name)], capture_output=True)
        if self.made_run_sshd:
            RUN_SSHD.rmdir()


class SmallDisk:
    """A folder in memory that gets full; it can be enlarged."""

    def __init__(self, folder, bytes_at_first):
        self.folder = pathlib.Path(folder)
        self.bytes = bytes_at_first

    def __enter__(self):
        self.folder.mkdir()
        made = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={self.bytes}", "sweep", self.folder], capture_output=True, text=True)
        if made.returncode != 0:
            skip(f"no small disk can be mounted: {made.stderr.strip()}")
        return self

    def enlarge(self):
        run("mount", "-o", "remount,size=90%", self.folder)

    def __exit__(self, *error):
        run("umount", "--lazy", self.folder)


def random_pause(chance: random.Random, most):
    time.sleep(chance.uniform(0.0, most))
