"""Remembers rows that pairs had before their closest points jumped, without ROS.

If several places of a pair are equally near, its distance has a kink: its row may be about one place in this step, and
about another place in the next step. A controller that uses only the present row moves to and fro between these places,
and loses distance in each step. So it also uses earlier rows, as bundle methods do, as long as their places are about
as near as the present one.

Source: Lemarechal, An extension of Davidon methods to non differentiable problems, Mathematical Programming Study,
        1975.
"""

import collections

import numpy

# Two gradients are about different places if they differ by more than a part of their norm. This part is MIN_CHANGE
# plus CHANGE_PER_TRAVEL [1/rad, 1/m] times the distance between the two states, but at most MAX_CHANGE.
MIN_CHANGE, CHANGE_PER_TRAVEL, MAX_CHANGE = 0.02, 20.0, 0.1
NEAR = 1e-3  # [m] a remembered place may be farther than the present one by this much
MAX_TRAVEL = 0.1  # [rad, m] a gradient is not used farther from the state in which it was computed
MAX_PLACES = 4  # places of a pair that are remembered

# The row of a pair in one step, and the positions of the joints in this step.
Place = collections.namedtuple("Place", "gradient distance positions")


class RememberedRows:
    def __init__(self):
        self.latest = {}  # {pair: its place in the last step}
        self.others = {}  # {pair: its other places that were near, the newest first}

    def update(self, positions, rows):
        """Adds the rows of a step, {pair: (gradient, distance)}. Returns [(pair, gradient)] of the remembered rows that
        have to be kept, too; their bounds are those that the pairs have now."""
        latest = {pair: Place(gradient, distance, positions) for pair, (gradient, distance) in rows.items()}
        self.others = {pair: self._others(pair, now) for pair, now in latest.items()}
        self.latest = latest
        return [(pair, place.gradient) for pair, places in self.others.items() for place in places]

    def _others(self, pair, now):
        before = [self.latest[pair]] if pair in self.latest else []
        kept = []
        for place in before + self.others.get(pair, []):
            if is_nearly_as_near(place, now) and all(is_another_place(place, other) for other in [now, *kept]):
                kept.append(place)
        return kept[:MAX_PLACES]


def is_another_place(place, other):
    norm = max(numpy.linalg.norm(place.gradient), numpy.linalg.norm(other.gradient))
    travel = numpy.linalg.norm(other.positions - place.positions)
    change = min(MIN_CHANGE + CHANGE_PER_TRAVEL * travel, MAX_CHANGE)
    return numpy.linalg.norm(other.gradient - place.gradient) > change * norm


def is_nearly_as_near(place, now):
    travel = now.positions - place.positions
    distance = place.distance + place.gradient @ travel
    return distance <= now.distance + NEAR and numpy.linalg.norm(travel) <= MAX_TRAVEL
