"""The Python module: each question is an expression, or a statement, which those behind it in its group know."""

import ast
import math
import os
import pathlib
import pickle
import sys
import warnings

import numpy
import rosunit

import robots
from recording import Blocks
from robots import missing  # noqa: F401

run = rosunit.unitrun


def prepare(options):
    sys.path.insert(0, str(options.module))
    os.environ["ROS_PACKAGE_PATH"] = robots.ENVIRONMENT["ROS_PACKAGE_PATH"]
    pathlib.Path("thresholds.yaml").write_text("stop_distance: 0.1\nwarn_distance: 0.3\nobject_stop_distance: 0.05\n"
                                               "pair_stop_distance: [{links: [torso, left_upper_arm], distance: 0.01}]\n")
    pathlib.Path("crossing.urdf").write_text(
        robots.text_of_header("tools/robot/crossing_sliders.h", "kCrossingSliders"))
    pathlib.Path("angle.obj").write_text(robots.ANGLE)
    for path in sorted((robots.PLACES["CORPUS"] / "object_files").iterdir()):  # their first byte is for the fuzzer
        pathlib.Path(path.name).write_bytes(path.read_bytes()[1:])


def states(robot, seed, *shape):
    """Random ones, less the infinite ranges."""
    lower, upper = numpy.clip(robot.ranges, -math.pi, math.pi).T
    return numpy.random.default_rng(seed).uniform(lower, upper, (*shape, len(lower)))


def text(path):
    return pathlib.Path(path).read_text()


def at(x, y, z, angle):
    """A pose: a turn around z."""
    pose = numpy.eye(4)
    pose[:2, :2] = [[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]
    pose[:3, 3] = x, y, z
    return pose


def shown(value):
    """Each number as Python prints it: the shortest text that reads as the same double."""
    if isinstance(value, numpy.ndarray) and value.ndim:
        if value.dtype.names:
            return "\n".join([f"rows of {' '.join(value.dtype.names)} {value.shape}", *map(shown, value.ravel())])
        rows = value.reshape(-1, value.shape[-1])
        return "\n".join([f"{value.dtype} {value.shape}", *(" ".join(map(shown, row)) for row in rows)])
    if isinstance(value, numpy.void):
        return " ".join(f"({' '.join(map(shown, field))})" if numpy.ndim(field) else shown(field) for field in value)
    if isinstance(value, (numpy.generic, numpy.ndarray)):
        return repr(value.item())
    if isinstance(value, (tuple, list)):
        return "\n".join(map(shown, value)) or repr(value)
    if isinstance(value, dict):
        return "\n".join(f"{key}: {shown(item)}" for key, item in value.items()) or "{}"
    if type(value).__name__ == "Joint":
        return f"{value.name} {value.type} {value.lower!r} {value.upper!r} {value.mimic}"
    if type(value).__name__ == "Object":
        return "\n".join(f"  {name}: {shown(getattr(value, name))}" for name in dir(value) if name[0] != "_")
    return f"a robot, {value.name}" if type(value).__name__ == "Robot" else repr(value)


def answer_to(question, names):
    answer = Blocks()
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        try:
            tree = ast.parse(question)
            if isinstance(tree.body[0], ast.Expr):
                answer.add("", shown(eval(question, names)))
            else:
                exec(question, names)
        except Exception as error:
            answer.add("", f"{type(error).__name__}: {error}")
    answer.add("warnings", "\n".join(f"{warning.category.__name__}: {warning.message}" for warning in heard))
    return answer


def answers(group, asked):
    import proximity
    names = {**vars(proximity), "proximity": proximity, "numpy": numpy, "nan": math.nan, "inf": math.inf, "states": states, "at": at,
             "text": text, "pickle": pickle, "pathlib": pathlib, **robots.PLACES}
    for question in asked:
        yield question, answer_to(question, names)
