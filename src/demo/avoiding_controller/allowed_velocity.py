"""Finds the velocity that keeps linear constraints and is nearest to a wanted one: quadratic programs, without ROS.

1. Let y be the difference from the wanted velocity, and `missing` the differences of the bounds from the values of the
   rows at the wanted velocity. The problem is then to find the shortest y with matrix * y >= missing.
2. Solve this by non-negative least squares: let r be the residual of min |E u - f|, u >= 0, for E = [matrix'; missing']
   and f = (0, ..., 0, 1). Then y = -r / r_last. If r is 0, there is no solution.

Source: Lawson, Hanson, Solving Least Squares Problems, 1974, chapter 23, algorithm LDP.
"""

import numpy
import scipy.optimize

ROUNDING = 1e-9  # [m/s] by which a solution may violate a bound because of rounding
SLACK = 0.02  # [m/rad, m/m] see yielding_velocity()


class Infeasible(Exception):
    """No velocity keeps all constraints."""


def allowed_velocity(wanted, matrix, lower_bounds):
    """Returns the velocity nearest to `wanted` with matrix * velocity >= lower_bounds. A bound of -infinity is ignored.

    Failure: raises Infeasible if there is no such velocity, or if it is not found because of rounding; raises
             ValueError for a number that is NaN.
    """
    return nearest_velocity(wanted, matrix, lower_bounds)[0]


def nearest_velocity(wanted, matrix, lower_bounds):
    """Returns the velocity of allowed_velocity(), and the pushes of the rows: velocity = wanted + pushes * matrix. The
    push of a row that has no effect is 0."""
    wanted, matrix, lower_bounds = (numpy.asarray(values, dtype=float) for values in (wanted, matrix, lower_bounds))
    if numpy.isnan(wanted).any() or numpy.isnan(matrix).any() or numpy.isnan(lower_bounds).any():
        raise ValueError("a constraint or the wanted velocity is NaN")
    pushes = numpy.zeros(len(lower_bounds))
    counts = lower_bounds > -numpy.inf
    rows = matrix[counts]
    missing = lower_bounds[counts] - rows @ wanted
    if not (missing > 0.0).any():
        return wanted, pushes
    equations = numpy.vstack([rows.T, missing])
    ones = numpy.zeros(len(wanted) + 1)
    ones[-1] = 1.0
    try:
        multipliers, _ = scipy.optimize.nnls(equations, ones)
    except (RuntimeError, ValueError) as error:  # too many iterations; a bound of +infinity
        raise Infeasible(str(error)) from error
    residual = equations @ multipliers - ones
    if not residual[-1] < 0.0:
        raise Infeasible("the constraints contradict each other")
    velocity = wanted - residual[:-1] / residual[-1]
    worst = (lower_bounds[counts] - rows @ velocity).max()
    if not worst <= ROUNDING * max(1.0, numpy.abs(lower_bounds[counts]).max()):
        raise Infeasible("no velocity was found that keeps all constraints")
    pushes[counts] = -multipliers / residual[-1]
    return velocity, pushes


def yielding_velocity(wanted, matrix, lower_bounds, lower, upper):
    """Returns the velocity nearest to `wanted` within [lower, upper] that keeps the rows, and the pushes of the rows. A
    row with a positive bound demands that a pair separates. Such a row may be violated if the joints cannot separate
    the pair, or if another row demands the contrary. Of all velocities with

        matrix * velocity >= min(lower_bounds, 0)        matrix * velocity + slack >= lower_bounds

    the result is the one with the smallest |velocity - wanted|^2 + |slack / SLACK|^2. So no pair approaches faster than
    its row allows, and a velocity of 0 is always allowed if the limits allow it. If `wanted` is 0 and there is a single
    row with the norm g and the bound b, the speed along the row is b g / (g^2 + SLACK^2). It is b / g if the joints
    separate the pair easily, 0 if they do not separate it at all, and never more than b / (2 SLACK). A speed of b / g
    in all cases would grow without limit for small g, and its direction would change from step to step.

    Failure: as allowed_velocity().
    Source: Wampler, Manipulator inverse kinematic solutions based on vector formulations and damped least-squares
            methods, IEEE Transactions on Systems, Man, and Cybernetics, 1986.
    """
    wanted, matrix, lower_bounds = (numpy.asarray(values, dtype=float) for values in (wanted, matrix, lower_bounds))
    joints, is_positive = len(wanted), lower_bounds > 0.0
    slacks = numpy.count_nonzero(is_positive)
    limits = numpy.eye(joints, joints + slacks)
    rows = numpy.hstack([matrix, numpy.zeros((len(matrix), slacks))])
    soft = numpy.hstack([matrix[is_positive], SLACK * numpy.eye(slacks)])
    velocity, pushes = nearest_velocity(
        numpy.concatenate([wanted, numpy.zeros(slacks)]), numpy.vstack([rows, soft, limits, -limits]),
        numpy.concatenate([numpy.minimum(lower_bounds, 0.0), lower_bounds[is_positive], lower, -numpy.asarray(upper)]))
    pushes_of_rows = pushes[:len(matrix)]
    pushes_of_rows[is_positive] += pushes[len(matrix):len(matrix) + slacks]
    return velocity[:joints], pushes_of_rows
