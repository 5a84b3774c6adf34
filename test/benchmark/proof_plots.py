"""Draws what an uncertainty costs, and what a proof costs, for the robot of the demo.

usage: proof_plots.py FOLDER   the pictures uncertainty_loss.png and proofs.png go there; `prove` is on PATH

An uncertainty of joints, for the closest pair in random states: what the distance loses by the sum of all motions without
directions (weights of free motions), by `guaranteed`, and in the worst of many states within (corners of the box first). A
proof: what is not settled of a box against the number of its parts, and the time for boxes about random states.
"""

import json
import os
import subprocess
import sys
import time

import matplotlib.pyplot as plt
import numpy
import proximity

DEMO = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "config", "demo", "robot")
STATES = 60
WITHIN = 4000  # states within an uncertainty
SIZES = numpy.array([1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 1e-1])  # [rad] or [m] of each joint
RADII = numpy.array([1e-2, 2e-2, 5e-2, 0.1, 0.2])  # [rad] or [m] of a box
CLEARANCES = (0.0, 0.005, 0.02)  # [m]
BOXES = [10, 30, 100, 300, 1000, 3000, 10000, 30000, 100000]
PAIRS = (("left_forearm", "left_hand"), ("torso", "left_yoke"), ("left_upper_arm", "left_forearm"))
BLACK, BLUE, ORANGE, GREEN = "#000000", "#0072B2", "#D55E00", "#009E73"  # colour-blind readers tell them apart


def load(**arguments):
    return proximity.Robot(f"{DEMO}.urdf", srdf=f"{DEMO}.srdf", threads=1, **arguments)


def random_states(robot, count, seed=1):
    lower, upper = robot.ranges.T
    return numpy.random.default_rng(seed).uniform(lower, upper, (count, len(robot.joints)))


def worst_within(robot, q, size, random):
    """[m] The smallest distance of some states that differ from q by at most `size`: corners, the best of which is improved joint
    by joint."""
    signs = random.choice([-1.0, 1.0], (WITHIN, q.size))
    distances = robot.minimum(q + size * signs)["upper"]
    best, nearest = signs[distances.argmin()], distances.min()
    flipped = numpy.where(numpy.eye(q.size, dtype=bool), -best, best)
    return min(nearest, robot.minimum(q + size * flipped)["upper"].min(), robot.minimum(q + size * best)["upper"])


def losses():
    """Returns, by size and state, the loss of the cheap bound, of `guaranteed`, and of the worst state that was found."""
    whole = load()
    random = numpy.random.default_rng(2)
    found = []
    for q in random_states(whole, 4 * STATES):
        closest = whole.minimum(q)
        if closest["lower"] < 0.01 or len(found) == STATES:
            continue
        robot = load(only_pairs=[whole.pairs[closest["pair"]]])
        distance = robot.minimum(q)
        free = robot.free_motion(q, 0.0, influence_distance=10.0)
        cheap = distance["lower"] * numpy.nansum(1.0 / free)  # [m] by rad and m: infinitely free joints count 0
        found.append([[size * cheap, distance["upper"] - robot.guaranteed(q, size)[1],
                       distance["upper"] - worst_within(robot, q, size, random)] for size in SIZES])
    return numpy.array(found).transpose(2, 1, 0)


def draw_losses(file):
    names = ("without directions", "guaranteed", "worst state that was found")
    figure, axes = plt.subplots(figsize=(6.5, 4.2))
    for name, loss, colour, mark in zip(names, losses(), (ORANGE, BLACK, BLUE), "^os"):
        median, low, high = (1e3 * numpy.quantile(loss, share, axis=1) for share in (0.5, 0.1, 0.9))
        axes.plot(SIZES, median, color=colour, marker=mark, label=name)
        axes.fill_between(SIZES, low, high, color=colour, alpha=0.15, linewidth=0)
    axes.set(xscale="log", yscale="log", xlabel="uncertainty of each joint [rad] or [m]", ylabel="loss of the distance [mm]",
             title=f"demo robot, closest pair, {STATES} random states: median, 10 % to 90 %")
    axes.grid(alpha=0.3)
    axes.legend()
    figure.tight_layout()
    figure.savefig(file, dpi=110)


def unsettled(pair, boxes):
    """The share of the limits in which `prove` does not know after so many parts whether the pair is in contact."""
    command = ["prove", f"{DEMO}.urdf", "--quiet", "--pairs", "all", "--only", pair[0], "--only", pair[1], "--shares", "--boxes",
               str(boxes), "--format", "json"]
    proof = json.loads(subprocess.run(command, stdout=subprocess.PIPE, check=False).stdout)["pairs"][0]
    return proof["undecided"]


def seconds_of_proofs(robot, distance, radius):
    """[s] The median time of all pairs within `radius` of random states that are apart."""
    states = random_states(robot, 4 * STATES, seed=3)
    states = states[robot.minimum(states)["lower"] > distance][:STATES // 2]
    times = []
    for q in states:
        start = time.perf_counter()
        robot.prove(q - radius, q + radius, max(distance, 1e-6), boxes=2000)
        times.append(time.perf_counter() - start)
    return numpy.median(times)


def draw_proofs(file):
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.2))
    for pair, colour, mark in zip(PAIRS, (BLACK, BLUE, ORANGE), "os^"):
        left.plot(BOXES, [unsettled(pair, boxes) for boxes in BOXES], color=colour, marker=mark, label=" - ".join(pair))
    left.set(xscale="log", yscale="log", xlabel="parts of the box", ylabel="share of the limits that is not settled")
    robot = load()
    for clearance, colour, mark in zip(CLEARANCES, (BLACK, BLUE, GREEN), "os^"):
        right.plot(RADII, [1e3 * seconds_of_proofs(robot, clearance, radius) for radius in RADII], color=colour, marker=mark,
                   label=f"{1e3 * clearance:g} mm apart")
    right.set(xscale="log", yscale="log", xlabel="radius of the box [rad] or [m]",
              ylabel=f"median time for all {len(robot.pairs)} pairs [ms]")
    for axes in (left, right):
        axes.grid(alpha=0.3)
        axes.legend()
    figure.tight_layout()
    figure.savefig(file, dpi=110)


if __name__ == "__main__":
    os.makedirs(sys.argv[1], exist_ok=True)
    draw_losses(os.path.join(sys.argv[1], "uncertainty_loss.png"))
    draw_proofs(os.path.join(sys.argv[1], "proofs.png"))
