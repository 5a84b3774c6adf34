#!/usr/bin/env python3
"""Shows the joint space of a robot: its clearance in random states, and in a slice over two joints.

The left half of the picture is a histogram of the clearance in random states within the limits. The right half is the
clearance over two joints: red means overlap, and the line is contact. All other joints have the positions of --at, or
are at 0 or at the limit that is nearest to 0.

    joint_space.py robot.urdf --srdf robot.srdf --joints shoulder elbow --at wrist=0.5 --out slice.png
"""

import argparse
import collections
import os
import warnings

import matplotlib.pyplot as pyplot
import numpy

import proximity


def random_states(robot, count, seed=1):
    return numpy.random.default_rng(seed).uniform(*robot.ranges.T, (count, len(robot.joints)))


def slice_states(robot, joints, cells, rest):
    """Makes a grid over two joints: its axes, and its states of shape (cells * cells, joints of the robot)."""
    axes = [numpy.linspace(*robot.ranges[joint], cells) for joint in joints]
    q = numpy.tile(rest, (cells * cells, 1))
    q[:, joints] = numpy.stack(numpy.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    return axes, q


def report(robot, minimum):
    worst = minimum[numpy.nanargmin(minimum["distance"])]
    contact = 100.0 * numpy.mean(minimum["distance"] <= 0.0)
    print(f"{len(minimum)} states: {contact:.1f} % in contact, smallest distance {worst['distance']:.4f} m of "
          + " - ".join(robot.pairs[worst["pair"]]))
    for pair, count in collections.Counter(minimum["pair"].tolist()).most_common(5):
        print(f"{100.0 * count / len(minimum):5.1f} % have the smallest distance between " + " - ".join(robot.pairs[pair]))


def label(joint):
    return f"{joint.name} [{'m' if joint.type == 'prismatic' else 'rad'}]"


def draw_histogram(axes, minimum):
    axes.hist(minimum["distance"], bins=60, color="0.5")
    axes.axvline(0.0, color="tab:red")
    axes.set_xlabel("clearance [m]")
    axes.set_ylabel(f"of {len(minimum)} random states")


def draw_slice(axes, joints, grid, clearance):
    reach = numpy.abs(clearance).max()
    image = axes.pcolormesh(*grid, clearance.T, cmap="RdBu", vmin=-reach, vmax=reach, shading="nearest")
    if clearance.min() < 0.0 < clearance.max():
        axes.contour(*grid, clearance.T, levels=[0.0], colors="black")
    axes.set_xlabel(label(joints[0]))
    axes.set_ylabel(label(joints[1]))
    axes.figure.colorbar(image, ax=axes, label="clearance [m]")


def position(text):
    name, _, value = text.rpartition("=")
    return name, float(value)


def make_parser():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("urdf")
    parser.add_argument("--srdf", help="which pairs not to check")
    parser.add_argument("--package", action="append", metavar="FOLDER", help="where package:// is looked for")
    parser.add_argument("--joints", nargs=2, metavar="JOINT", required=True, help="of the slice")
    parser.add_argument("--at", nargs="+", type=position, default=[], metavar="JOINT=POSITION", help="where other joints are")
    parser.add_argument("--states", type=int, default=100_000, help="random ones (default: 100000)")
    parser.add_argument("--cells", type=int, default=300, help="of the slice in each direction (default: 300)")
    parser.add_argument("--out", default="joint_space.png", help="the picture (default: joint_space.png)")
    return parser


def main():
    parser = make_parser()
    options = parser.parse_args()
    for path in (options.urdf, options.srdf):
        if path and os.path.exists(path) and os.path.exists(options.out) and os.path.samefile(path, options.out):
            parser.error(f"--out {options.out}: is the same file as {path}, which is read and would be lost")
    warnings.simplefilter("ignore", UserWarning)  # they are also in proximity.Robot.warnings
    try:
        robot = proximity.Robot(options.urdf, options.srdf, packages=options.package)
    except (OSError, ValueError) as error:
        parser.error(str(error))
    columns = {joint.name: column for column, joint in enumerate(robot.joints)}
    for name in (*options.joints, *(name for name, _ in options.at)):
        if name not in columns:
            parser.error(f"there is no joint {name}; the robot has {', '.join(columns)}")

    minimum = robot.minimum(random_states(robot, options.states))
    report(robot, minimum)

    rest = numpy.clip(0.0, *robot.ranges.T)
    for name, value in options.at:
        rest[columns[name]] = value
    joints = [columns[name] for name in options.joints]
    grid, q = slice_states(robot, joints, options.cells, rest)
    clearance = robot.minimum(q)["distance"].reshape(options.cells, options.cells)

    figure, (left, right) = pyplot.subplots(1, 2, figsize=(12, 5), constrained_layout=True)
    draw_histogram(left, minimum)
    draw_slice(right, [robot.joints[joint] for joint in joints], grid, clearance)
    figure.savefig(options.out, dpi=100)
    print(f"wrote {options.out}")


if __name__ == "__main__":
    main()
