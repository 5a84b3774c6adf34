#!/usr/bin/env python3
"""Takes robots from a URDF to a folder whose rostest passes: by pair_audit --setup, and the decision that it asks for.
Prints a row of the table in src/tools/pair_audit/README.md for each.

usage: setup_table.py PAIR_AUDIT ROBOTS [NAME...]      in the environment of the package, as devel/env.sh makes it
ROBOTS is the folder of example-robot-data and public_robots; without names, all robots.

The decision: if another state of rest is enough, that of rest.yaml is taken; otherwise all overlaps are accepted, by the
lines that pair_audit prints. The seconds are those of the wall, of all that: loading with an empty cache of meshes too.
"""

import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "benchmark"))
from load_benchmark import EXAMPLES, PUBLIC, ROBOTS  # noqa: E402

SRDFS = {
    "Panda": f"{EXAMPLES}/panda_description/srdf/panda.srdf",
    "UR5": f"{EXAMPLES}/ur_description/srdf/ur5.srdf",
    "PR2": f"{EXAMPLES}/pr2_description/srdf/pr2.srdf",
    "Solo12": f"{EXAMPLES}/solo_description/srdf/solo.srdf",
    "HyQ": f"{EXAMPLES}/hyq_description/srdf/hyq.srdf",
    "Kinova": f"{EXAMPLES}/kinova_description/srdf/kinova.srdf",
    "Romeo": f"{EXAMPLES}/romeo_description/srdf/romeo.srdf",
    "B1 with Z1": f"{EXAMPLES}/b1_description/srdf/b1-z1.srdf",
    "Z1": f"{EXAMPLES}/z1_description/srdf/z1.srdf",
    "Go2": f"{EXAMPLES}/go2_description/srdf/go2.srdf",
    "Baxter": f"{EXAMPLES}/baxter_description/srdf/baxter_manipulation.srdf",
    "iCub": f"{EXAMPLES}/icub_description/srdf/icub.srdf",
    "Talos": f"{EXAMPLES}/talos_data/srdf/talos.srdf",
    "IRB 6640": f"{PUBLIC}/irb6640/irb6640.srdf",
    "xArm7": f"{PUBLIC}/xarm7/xarm7.srdf",
}
PATIENCE = 1800.0  # [s]


def levels(line, printed):
    """Returns CLEAR / WARN / STOP / COLLISION in percent, from the line that begins so."""
    shares = re.findall(r"([\d.]+) %", re.search(rf"(?m){line}(.*)$", printed)[1])
    return " / ".join(f"{float(share):.0f}" for share in shares)


def decide(folder, printed):
    """Does what a person does with a folder that is not ready. Returns the decision, and the line with the levels after it."""
    pairs = re.findall(r"(?m)^  .*: an overlap of the model(, or the robot never rests so)?\n    (<disable_collisions .*/>)$", printed)
    if all(only_at_rest for only_at_rest, _ in pairs) and "level is COLLISION" not in (folder / "rest.yaml").read_text():
        return "another rest", "^  after "
    srdf = folder / "robot.srdf"
    text = re.sub(r"(<robot [^>]*)/>\s*$", r"\1>\n</robot>", srdf.read_text())
    end = text.rindex("</robot>")
    srdf.write_text(text[:end] + "".join(f"{line}\n" for _, line in pairs) + text[end:])
    return f"{len(pairs)} overlap{'s' if len(pairs) > 1 else ''}", r"Then (?=\d)"


def passes(folder, environment):
    """Returns whether the rostest of the folder passes. It has a ROS master of its own."""
    result = subprocess.run(["rostest", "--package", folder.name, "--pkgdir", folder, folder / "proximity.test"],
                            env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, timeout=PATIENCE)
    return result.returncode == 0


def row_of(name, pair_audit, robots):
    """Returns the cells of the row of a robot."""
    robots = pathlib.Path(robots).resolve()
    with tempfile.TemporaryDirectory(prefix="setup_table_") as temporary:
        folder = pathlib.Path(temporary, "robot_proximity")
        packages = f"{robots}:{os.environ.get('ROS_PACKAGE_PATH', '')}"
        environment = {**os.environ, "XDG_CACHE_HOME": temporary, "ROS_HOME": temporary, "ROS_TEST_RESULTS_DIR": temporary,
                       "ROS_PACKAGE_PATH": packages}
        srdf = ("--srdf", robots / SRDFS[name]) if name in SRDFS else ()
        start = time.monotonic()
        audit = subprocess.run([pair_audit, robots / dict(ROBOTS)[name], *srdf, "--allow-missing-meshes", "--quiet", "--setup", folder],
                               env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=PATIENCE)
        if audit.returncode not in (0, 2):
            raise RuntimeError(f"{name}: {audit.stderr}")
        decision, after = decide(folder, audit.stdout) if audit.returncode == 2 else ("none", "^  after ")
        passed = "passes" if passes(folder, environment) else "fails"
        return [name, "its own" if srdf else "none", levels("^  before", audit.stdout), levels(after, audit.stdout), decision,
                passed, f"{time.monotonic() - start:.0f}"]


def main(pair_audit, robots, *names):
    print("| robot | SRDF | before | after | decision | rostest | s |\n|---|---|---|---|---|---|---|")
    for name in names or dict(ROBOTS):
        print("| " + " | ".join(row_of(name, pair_audit, robots)) + " |", flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
