"""The velocity nearest to a wanted one that keeps linear constraints: quadratic programs, without ROS.

1. Shift the unknown to the difference from the wanted velocity: the shortest y with matrix * y >= missing, where missing is
   how far the wanted velocity is from each bound.
2. Solve that by non-negative least squares: with the residual r of min |E u - f|, u >= 0, for E = [matrix'; missing'] and
   f = (0, ..., 0, 1), it is y = -r / r_last. There is none if r is 0.

Source: Lawson, Hanson, Solving Least Squares Problems, 1974, chapter 23, algorithm LDP.
"""

import numpy
import scipy.optimize

FEASIBLE = 1e-9  # [m/s] what rounding may leave of a bound
SLACK = 0.02  # [m/rad, m/m] see yielding_velocity()


class Infeasible(Exception):
    """No velocity keeps all constraints."""


def allowed_velocity(wanted, matrix, lower_bounds):
    """The velocity nearest to `wanted` with matrix * velocity >= lower_bounds; a bound of -infinity does not count.

    Failure: raises Infeasible if there is none, or if rounding does not find it; ValueError for a number that is NaN.
    """
    return nearest_velocity(wanted, matrix, lower_bounds)[0]


def nearest_velocity(wanted, matrix, lower_bounds):
    """The same, and how hard each row pushes: velocity = wanted + push * matrix. It is 0 for a row that could be left out."""
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
    if not worst <= FEASIBLE * max(1.0, numpy.abs(lower_bounds[counts]).max()):
        raise Infeasible("no velocity was found that keeps all constraints")
    pushes[counts] = -multipliers / residual[-1]
    return velocity, pushes


def yielding_velocity(wanted, matrix, lower_bounds, lower, upper):
    """The velocity nearest to `wanted` within [lower, upper] that keeps the rows, and how hard each row pushes. A row with a
    positive bound asks two things to part. It yields where they cannot, or where another row asks for the contrary: of
    all velocities with

        matrix * velocity >= min(lower_bounds, 0)        matrix * velocity + slack >= lower_bounds

    it is the one with the smallest |velocity - wanted|^2 + |slack / SLACK|^2. So nothing approaches faster than its row allows,
    and rest is allowed by every row, as long as it is by the limits. Alone at rest, a row of the norm g with the bound b gives
    its direction the speed b g / (g^2 + SLACK^2): b / g where the joints part the two easily, at most b / (2 SLACK), and
    nothing where they do not part them at all. With b / g it would be ever faster there, and this way at one step and that way
    at the next.

    Failure: as allowed_velocity().
    Source: Wampler, Manipulator inverse kinematic solutions based on vector formulations and damped least-squares methods,
            IEEE Transactions on Systems, Man, and Cybernetics, 1986.
    """
    wanted, matrix, lower_bounds = (numpy.asarray(values, dtype=float) for values in (wanted, matrix, lower_bounds))
    joints, parting = len(wanted), lower_bounds > 0.0
    slacks = numpy.count_nonzero(parting)
    limits = numpy.eye(joints, joints + slacks)
    rows = numpy.hstack([matrix, numpy.zeros((len(matrix), slacks))])
    soft = numpy.hstack([matrix[parting], SLACK * numpy.eye(slacks)])
    velocity, pushes = nearest_velocity(
        numpy.concatenate([wanted, numpy.zeros(slacks)]), numpy.vstack([rows, soft, limits, -limits]),
        numpy.concatenate([numpy.minimum(lower_bounds, 0.0), lower_bounds[parting], lower, -numpy.asarray(upper)]))
    pushes_of_rows = pushes[:len(matrix)]
    pushes_of_rows[parting] += pushes[len(matrix):len(matrix) + slacks]
    return velocity[:joints], pushes_of_rows
