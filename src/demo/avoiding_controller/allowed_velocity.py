"""The velocity nearest to a wanted one that keeps linear constraints: a quadratic program, without ROS.

1. Shift the unknown to the difference from the wanted velocity: the shortest y with matrix * y >= missing, where missing is
   how far the wanted velocity is from each bound.
2. Solve that by non-negative least squares: with the residual r of min |E u - f|, u >= 0, for E = [matrix'; missing'] and
   f = (0, ..., 0, 1), it is y = -r / r_last. There is none if r is 0.

Source: Lawson, Hanson, Solving Least Squares Problems, 1974, chapter 23, algorithm LDP.
"""

import numpy
import scipy.optimize

FEASIBLE = 1e-9  # [m/s] what rounding may leave of a bound


class Infeasible(Exception):
    """No velocity keeps all constraints."""


def allowed_velocity(wanted, matrix, lower_bounds):
    """The velocity nearest to `wanted` with matrix * velocity >= lower_bounds; a bound of -infinity does not count.

    Failure: raises Infeasible if there is none, or if rounding does not find it; ValueError for a number that is NaN.
    """
    wanted, matrix, lower_bounds = (numpy.asarray(values, dtype=float) for values in (wanted, matrix, lower_bounds))
    if numpy.isnan(wanted).any() or numpy.isnan(matrix).any() or numpy.isnan(lower_bounds).any():
        raise ValueError("a constraint or the wanted velocity is NaN")
    counts = lower_bounds > -numpy.inf
    rows = matrix[counts]
    missing = lower_bounds[counts] - rows @ wanted
    if not (missing > 0.0).any():
        return wanted
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
    return velocity
