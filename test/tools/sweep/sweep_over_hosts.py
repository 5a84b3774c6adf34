#!/usr/bin/env python3
r"""A sweep by GNU parallel over two hosts, with workers and engine killed, a full disk and a lost connection, resumed until it
is done. Then the merged file must be that of one run on one core.

usage: sweep_over_hosts.py CLEARANCE [options] -- ROBOT [options of clearance that choose states, pairs and format]

A billion states, resumed ten times, of which 1 % are computed again on one core:

  sweep_over_hosts.py build/devel/lib/proximity_server/clearance --shards 100 --faulty-rounds 10 --kill-engines --patience 6 \
    --check 0.01 --time-limit 7200 --folder /tmp/billion -- panda.urdf --srdf panda.srdf --sample 1000000000 --pairs any:0.05 --format npy

The hosts are network namespaces with an sshd each; see hosts.py. Exit code 77: this machine cannot have them.
"""

import argparse
import contextlib
import filecmp
import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time

from hosts import Hosts, SmallDisk, kill, processes_of, random_pause, require_programs

FULL = "No space left on device"


class Sweep:
    """What is computed: the command line of a worker, and the folder of its parts."""

    def __init__(self, options, folder):
        self.clearance = pathlib.Path(options.clearance).resolve()
        self.words = options.words
        self.shards = options.shards
        self.folder = folder
        self.parts = folder / "parts"
        self.chance = random.Random(options.seed)

    def command(self, *more):
        return [str(self.clearance), *self.words, "--threads", "1", *(str(word) for word in more)]

    def workers(self):
        return processes_of(self.clearance, self.parts)

    def complete_parts(self):
        return list(self.parts.glob("states-*.manifest"))

    def check_parts(self):
        """What has a manifest is complete, at any time."""
        for path in self.complete_parts():
            size = json.loads(path.read_text())["bytes"]
            assert path.with_suffix("").stat().st_size == size, f"{path}: its file does not have {size} bytes"


class Faults:
    """Kills workers at random moments while an engine runs, the engine too, and cuts links. Counts what it did."""

    def __init__(self, sweep, hosts):
        self.sweep, self.hosts, self.chance = sweep, hosts, sweep.chance
        self.killed_workers = self.killed_engines = self.cuts = 0

    def run(self, engine, kills, patience, cut, kill_engine):
        """In a round: so many kills, unless the engine ends before. Each comes within `patience` [s] of a worker's start."""
        cutter = threading.Thread(target=self.cut, args=(engine,)) if cut else None
        if cutter:
            cutter.start()
        for _ in range(kills):
            self.kill_worker(engine, patience)
        if kill_engine and engine.poll() is None:
            random_pause(self.chance, patience)
            if engine.poll() is None:
                kill(engine.pid)  # its workers go on, beside those of the next round
                self.killed_engines += 1
        if cutter:
            cutter.join()
        engine.wait()

    def kill_worker(self, engine, patience):
        known = set()
        while engine.poll() is None:
            running = self.sweep.workers()
            if not running:
                time.sleep(0.005)
                continue
            worker = self.chance.choice(running)
            if worker in known:
                time.sleep(0.005)
                continue
            known.add(worker)
            random_pause(self.chance, patience)
            if worker in self.sweep.workers() and kill(worker):
                self.killed_workers += 1
                return

    def cut(self, engine):
        """A link breaks while workers run, for longer than ssh waits."""
        while engine.poll() is None and not self.sweep.workers():
            time.sleep(0.005)
        name = self.chance.choice(Hosts.NAMES)
        self.hosts.cut(name)
        self.cuts += 1
        time.sleep(4.0)
        self.hosts.mend(name)


def engine(sweep, hosts, jobs):
    """GNU parallel, with the options that src/tools/sweep/README.md names."""
    hosts_file = sweep.folder / "hosts.txt"
    hosts_file.write_text("".join(f"{jobs}/{name}\n" for name in Hosts.NAMES))
    # The names have no spaces: --resume-failed does not understand a log with others.
    ssh = f"ssh -F {hosts.folder}/ssh_config"
    command = ["parallel", "--will-cite", "--ssh", ssh, "--sshloginfile", hosts_file, "--env", "PATH", "--env", "ROS_PACKAGE_PATH",
               "--workdir", ".", "--joblog", sweep.folder / "sweep.log", "--resume-failed",
               *sweep.command("--shard", f"{{}}/{sweep.shards}"), "--out", sweep.parts, ":::", *range(1, sweep.shards + 1)]
    # A command of its own, so that the engine is the process that is killed: ip netns exec replaces itself by it.
    log = open(sweep.folder / "engine.log", "a")
    return hosts.start_inside("head", *command, stdout=log, stderr=log)


def run_rounds(sweep, hosts, disk, options):
    """Rounds of the engine until all parts are there; the first ones have faults. Returns the faults and the number of rounds."""
    faults = Faults(sweep, hosts)
    deadline = time.monotonic() + options.time_limit
    rounds = 0
    while True:
        rounds += 1
        is_faulty = rounds <= options.faulty_rounds
        running = engine(sweep, hosts, options.jobs)
        faults.run(running, options.kills if is_faulty else 0, options.patience, cut=is_faulty and rounds % 3 == 2,
                   kill_engine=is_faulty and (options.kill_engines or rounds % 2 == 0))
        sweep.check_parts()
        print(f"round {rounds}: {len(sweep.complete_parts())} of {sweep.shards} parts, engine ended with {running.returncode}", flush=True)
        if running.returncode == 0:
            return faults, rounds
        log = (sweep.folder / "engine.log").read_text()
        if disk:
            if rounds >= 2 or FULL in log:
                assert FULL in log, "the disk did not get full"
                disk.enlarge()
                disk = None
        assert "parallel: Error" not in log and time.monotonic() < deadline, log[-3000:]


def merge(sweep):
    """The merged file, and its summary."""
    out, summary = sweep.folder / "merged", sweep.folder / "merged.json"
    subprocess.run([sweep.clearance, "--merge", sweep.parts, "--out", out, "--summary", summary], check=True)
    return out, summary


def on_one_core(sweep, *more):
    subprocess.run(["taskset", "-c", "0", *sweep.command(*more)], check=True, stderr=subprocess.DEVNULL)


def compare_with_one_run(sweep, merged, summary):
    whole, whole_summary = sweep.folder / "whole", sweep.folder / "whole.json"
    begin = time.monotonic()
    on_one_core(sweep, "--out", whole, "--summary", whole_summary)
    assert filecmp.cmp(merged, whole, shallow=False), "the merged file is not that of one run"
    assert summary.read_text() == whole_summary.read_text(), "the merged summary is not that of one run"
    return time.monotonic() - begin


def compare_ranges(sweep, merged, share):
    """Random ranges with this share of the states, computed anew on one core, against the rows of the merged file: one of a
    constant size for each state."""
    whole = json.loads(pathlib.Path(f"{merged}.manifest").read_text())
    states, rows = whole["range"][1], whole["rows"]
    assert states == rows, "the file does not have one row for each state"
    header = 256
    row_bytes = (whole["bytes"] - header) // rows
    pieces = max(1, min(100, states // 1000))
    size = max(1, int(states * share / pieces))
    begin_time = time.monotonic()
    with open(merged, "rb") as file:
        for piece in range(pieces):
            begin = sweep.chance.randrange(0, states - size + 1)
            folder = sweep.folder / f"check_{piece}"
            on_one_core(sweep, "--range", f"{begin}:{begin + size}", "--out", folder)
            part, = folder.glob("states-*.npy")
            file.seek(header + begin * row_bytes)
            found = part.read_bytes()[header:]
            assert len(found) == size * row_bytes and found == file.read(size * row_bytes), \
                f"the states {begin} to {begin + size - 1} differ"
            shutil.rmtree(folder)
    return pieces, size, time.monotonic() - begin_time


def parse(arguments):
    split = arguments.index("--")
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("clearance")
    parser.add_argument("--shards", type=int, default=12)
    parser.add_argument("--jobs", type=int, default=1, help="at once on each host")
    parser.add_argument("--faulty-rounds", type=int, default=4, help="rounds with faults; each ends with a resumed run")
    parser.add_argument("--kills", type=int, default=2, help="workers that are killed in such a round")
    parser.add_argument("--kill-engines", action="store_true", help="in every such round, not in every second one")
    parser.add_argument("--patience", type=float, default=0.25, help="a worker is killed within so many seconds")
    parser.add_argument("--first-disk", type=int, help="bytes of the disk at first; default: that of --folder, which does not get full")
    parser.add_argument("--check", type=float, help="only this share of the states is computed anew, in random ranges of .npy")
    parser.add_argument("--folder", help="for all files (default: a temporary one); it is kept")
    parser.add_argument("--time-limit", type=float, default=300.0, help="[s] of all rounds")
    parser.add_argument("--seed", type=int, default=1, help="of the faults and of the ranges")
    options = parser.parse_args(arguments[:split])
    options.words = arguments[split + 1:]
    return options


def sweep_with_faults(options, folder):
    sweep = Sweep(options, folder)
    begin = time.monotonic()
    # The disk comes first: each host keeps the mounts that there are when it starts.
    with contextlib.ExitStack() as made:
        disk = made.enter_context(SmallDisk(sweep.parts, options.first_disk)) if options.first_disk else None
        with Hosts(folder) as hosts:
            faults, rounds = run_rounds(sweep, hosts, disk, options)
        swept = time.monotonic() - begin
        merged, summary = merge(sweep)
    print(f"{sweep.shards} parts in {rounds} rounds and {swept:.1f} s, with {faults.killed_workers} workers and {faults.killed_engines} "
          f"engines killed and {faults.cuts} links cut")
    if options.faulty_rounds:
        least = options.faulty_rounds if options.kill_engines else 2
        assert faults.killed_workers >= least and rounds > least, f"only {faults.killed_workers} workers killed in {rounds} rounds"
    if options.check:
        pieces, size, seconds = compare_ranges(sweep, merged, options.check)
        print(f"{pieces} random ranges of {size} states, computed anew on one core in {seconds:.1f} s, are the same")
    else:
        seconds = compare_with_one_run(sweep, merged, summary)
        print(f"the same bytes as one run on one core, which took {seconds:.1f} s")


def main():
    options = parse(sys.argv[1:])
    signal.signal(signal.SIGTERM, lambda number, frame: sys.exit(1))  # so that all is removed then, too
    require_programs("parallel", "taskset")
    os.environ["PATH"] = f"{pathlib.Path(options.clearance).resolve().parent}:{os.environ['PATH']}"
    os.environ.setdefault("ROS_PACKAGE_PATH", "")
    if options.folder:
        folder = pathlib.Path(options.folder).resolve()
        folder.mkdir(parents=True)
        sweep_with_faults(options, folder)
    else:
        with tempfile.TemporaryDirectory(prefix="sweep_") as name:
            sweep_with_faults(options, pathlib.Path(name))


if __name__ == "__main__":
    main()
