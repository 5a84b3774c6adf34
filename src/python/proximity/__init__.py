"""How close a robot is to itself and to objects, in many states and between them: distances with proven bounds.

    robot = proximity.Robot("robot.urdf", srdf="robot.srdf")
    answer = robot.minimum(q)      # q: float64 of shape (states, joints), in the order of robot.joints
    answer["distance"]             # [m] of shape (states,), negative in overlap
    robot.pairs[answer["pair"][0]] # the two links that are closest in the first state

    cell = robot.with_object("table", proximity.Box((1.0, 0.6, 0.05)), (0.7, 0.0, 0.4))  # a robot with the table
    contact = cell.first_contact(start, goal)    # on the straight way in joint space, or with velocities on a spline

Every question is a method of Robot, and answers with a structured array of numpy, one row for each state, pair or edge.
A q of shape (joints,) is one state, and its answer one row; the answer has its other dimensions, too. Lengths are in
metres, angles in radian; points and normals are in the frame of the root link.

The fields of PAIR, the dtype of rows about a pair in a state:
    state                 number of the state, from 0; with several dimensions as numpy.ndarray.flat counts
    status                see Status; 0 is "no answer", and then no other field but `state` has a meaning
    unique                False: points and normal are one choice of many, and the distance has a kink there
    depth_is_lower_bound  True: the two overlap, possibly deeper, as one of them has several pieces
    representation        how the geometry is represented, see Representation; the less exact one of the two
    pair                  number in Robot.pairs; -1 without an answer
    distance              [m] signed: minus the penetration depth in overlap; paddings are taken off
    lower, upper          [m] proven bounds of the true distance
    point_a, point_b      [m] closest (or deepest) points, on the first and the second of the pair; NaN if there are
                          none
    normal                unit vector from the first towards the second: point_b = point_a + distance * normal

LEVELED_PAIR, the dtype of these rows if the robot has thresholds, has one more:
    level                 see Level; of the pair by its own thresholds, decided by the lower bound

EDGE_MINIMUM, the dtype of Robot.minimum_between, has the fields of PAIR with `edge` in place of `state`, the bounds of
the smallest distance of the whole edge, and one more:
    time                  from 0 at the start to 1 at the goal, when the pair is so close

The fields of CONTACT, the dtype of Robot.first_contact:
    edge                  number of the edge, from 0
    status                CONVERGED: complete. ITERATION_LIMIT, DEGENERATE: t_free holds, but a contact may come later.
                          UNKNOWN: nothing is known, as a position is not finite
    contact               True: there is a contact
    unique, representation, pair, distance, lower, upper, point_a, point_b, normal   as in PAIR, at the contact
    t_free                until this time every pair is proven to be farther than the distance of the question; 1: the
                          whole edge. With a tracking_error that holds for every motion within it
    t_contact             time at which the pair is proven to be at this distance, up to the tolerance; NaN without a
                          contact

The fields of VERDICT, the dtype of Robot.below:
    verdict               see Verdict
    pair                  number in Robot.pairs of a pair that is below; -1 if there is none

The fields of PROOF, the dtype of Robot.prove:
    pair                  number in Robot.pairs
    outcome               see Outcome
    lower                 [m] proven: in no state of the box is the pair nearer
    upper                 [m] the pair is not farther apart in the closest state that was found
    undecided             the share of the volume of the box that is not decided

POINT, the dtype of Robot.point_distance, has the fields of PAIR with `link` in place of `pair`: the first of the two is
the closest link or object, the second the ball about the point, and all distances are distances of the point. One more:
    link                  number in Robot.links; from len(Robot.links) on in the order of Robot.objects; -1 for none
    point                 number of the point, from 0; with several dimensions as numpy.ndarray.flat counts

The fields of HIT, the dtype of Robot.first_hit:
    state, ray            numbers of the state and the ray, as of the point above
    hit                   see Hit
    link                  that is hit, numbered as above; -1 for none
    distance              [m] along the ray, at which it is on the surface; NaN without a hit
    free_until            [m] proven: nothing is nearer to the origin
    point, normal         [m] of the hit; of the surface there, a unit vector outwards
"""

import enum

from proximity._native import (CONTACT, EDGE_MINIMUM, HIT, LEVELED_PAIR, PAIR, POINT, PROOF, VERDICT, Joint, Robot,
                               __version__)
from proximity._shapes import (Box, Boxes, Capsule, Cone, Cylinder, Ellipsoid, HalfSpace, Mesh, MeshFile, Object,
                               Sphere)

__all__ = [
    "CONTACT", "EDGE_MINIMUM", "HIT", "LEVELED_PAIR", "PAIR", "POINT", "PROOF", "VERDICT",
    "Box", "Boxes", "Capsule", "Cone", "Cylinder", "Ellipsoid", "HalfSpace", "Mesh", "MeshFile", "Object", "Sphere",
    "Hit", "Joint", "Level", "Outcome", "Representation", "Robot", "Status", "Verdict", "__version__",
]


class Status(enum.IntEnum):
    """How a distance was found. The bounds hold in all cases but the first."""

    UNKNOWN = 0  #: no answer: a position is not finite, or there is no pair
    CONVERGED = 1  #: the bounds are within 1e-9 m
    THRESHOLD = 2  #: the bounds decide the distance that was asked for; they may be wide, and points may be missing
    ITERATION_LIMIT = 3  #: the bounds are wider than 1e-9 m
    DEGENERATE = 4  #: the same: no further progress in double precision


class Verdict(enum.IntEnum):
    """Whether something is at or below a distance in a state."""

    UNKNOWN = 0  #: no answer: a position is not finite
    ABOVE = 1  #: proven: every pair is farther
    BELOW = 2  #: a pair is not proven to be farther


class Hit(enum.IntEnum):
    """What a ray meets; the numbers are the same as in RayHit.msg."""

    UNKNOWN = 0  #: no answer, or it is not known what is behind free_until
    HIT = 1  #: a surface; or the ray begins inside
    FREE = 2  #: proven: nothing within its range


class Outcome(enum.IntEnum):
    """What is known of a pair in a whole box of joint positions."""

    UNDECIDED = 0  #: the budget was not enough
    PROVEN = 1  #: in no state of the box is it at or below the distance
    REFUTED = 2  #: a state is known in which it is


class Level(enum.IntEnum):
    """How near a pair is by its own thresholds; the numbers are the same as in Clearance.msg, the worst last."""

    CLEAR = 0  #: farther than its warn distance
    WARN = 1  #: at or below its warn distance
    STOP = 2  #: at or below its stop distance
    COLLISION = 3  #: touching or overlapping
    INVALID = 4  #: no answer


class Representation(enum.IntEnum):
    """How the geometry of a link is represented."""

    EXACT = 0  #: a primitive, or a mesh that is convex
    CONVEX_HULL = 1  #: the hull of a mesh
    DECOMPOSED = 2  #: several convex pieces, within the tolerance of the mesh
    TRIANGLES = 3  #: the triangles of the mesh
