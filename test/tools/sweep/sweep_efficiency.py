#!/usr/bin/env python3
"""How much of two cores a sweep uses: with two threads, and on two hosts of one core each by GNU parallel, against one core.

usage: sweep_efficiency.py CLEARANCE [--repeats N] [--shards N] -- ROBOT [options of clearance, with --sample N]

The runs are interleaved, and the shortest of each counts. The time of loading the robot is a part of all. The machine must have
nothing else to do. Exit code 77: this machine cannot have the hosts, see hosts.py.
"""

import argparse
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

from hosts import Hosts, require_programs
from sweep_over_hosts import Sweep, engine


def timed(work):
    begin = time.monotonic()
    work()
    return time.monotonic() - begin


def on_cores(sweep, cores, threads):
    command = ["taskset", "-c", cores, str(sweep.clearance), *sweep.words, "--threads", str(threads), "--out", sweep.folder / "whole"]
    subprocess.run(command, check=True, stderr=subprocess.DEVNULL)


def on_hosts(sweep, hosts):
    for path in (sweep.parts, sweep.folder / "sweep.log"):
        shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)
    assert engine(sweep, hosts, jobs=1).wait() == 0, (sweep.folder / "engine.log").read_text()


def main():
    arguments = sys.argv[1:]
    split = arguments.index("--")
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("clearance")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--shards", type=int, default=8)
    options = parser.parse_args(arguments[:split])
    options.words, options.seed = arguments[split + 1:], 1
    require_programs("parallel", "taskset")
    os.environ.setdefault("ROS_PACKAGE_PATH", "")
    with tempfile.TemporaryDirectory(prefix="sweep_") as name, Hosts(name) as hosts:
        sweep = Sweep(options, pathlib.Path(name))
        ways = {"one core": lambda: on_cores(sweep, "0", 1), "two threads": lambda: on_cores(sweep, "0,1", 2),
                "two hosts": lambda: on_hosts(sweep, hosts)}
        shortest = {}
        for _ in range(options.repeats):
            for way, work in ways.items():
                shortest[way] = min(shortest.get(way, float("inf")), timed(work))
    for way, seconds in shortest.items():
        share = shortest["one core"] / seconds / (1 if way == "one core" else 2)
        print(f"{way}: {seconds:.2f} s, efficiency {100.0 * share:.0f} %")


if __name__ == "__main__":
    main()
