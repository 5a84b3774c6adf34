"""Rows that pairs had before their closest points jumped, without ROS.

Where several places of a pair are equally near, its distance has a kink: the row is about one place in this step, and about another
one in the next. Who heeds the present row alone goes to and fro between them, and loses distance with each step. So the rows
of before are heeded too, as bundle methods do, for as long as their own places stay about as near as the present one.

Source: Lemarechal, An extension of Davidon methods to non differentiable problems, Mathematical Programming Study, 1975.
"""

import collections

import numpy

# A gradient is about another place if it differs by more than a part of its norm: by SAME, and by CHANGE [1/rad, 1/m] for the way between
# the two states, but not more than MOST_ALIKE.
SAME, CHANGE, MOST_ALIKE = 0.02, 20.0, 0.1
BAND = 1e-3  # [m] how much farther than the present place a remembered one may be
REACH = 0.1  # [rad, m] how far its gradient is taken to hold
MOST = 4  # places of a pair, besides the present one

# The row of a pair in one step, and the state of the robot then.
Place = collections.namedtuple("Place", "gradient distance positions")


class RememberedRows:
    def __init__(self):
        self.latest, self.others = {}, {}  # by pair: the place of the last step, and the other places that were near, the newest first

    def update(self, positions, rows):
        """Takes the rows of a step, {pair: (gradient, distance)}. Returns [(pair, gradient)] of those to heed as well, with the
        bounds that the pairs have at present."""
        latest = {pair: Place(gradient, distance, positions) for pair, (gradient, distance) in rows.items()}
        self.others = {pair: self._others(pair, now) for pair, now in latest.items()}
        self.latest = latest
        return [(pair, place.gradient) for pair, places in self.others.items() for place in places]

    def _others(self, pair, now):
        before = [self.latest[pair]] if pair in self.latest else []
        kept = []
        for place in before + self.others.get(pair, []):
            if is_about_as_near(place, now) and all(jumps(place, other) for other in [now, *kept]):
                kept.append(place)
        return kept[:MOST]


def jumps(place, other):
    norm = max(numpy.linalg.norm(place.gradient), numpy.linalg.norm(other.gradient))
    way = numpy.linalg.norm(other.positions - place.positions)
    return numpy.linalg.norm(other.gradient - place.gradient) > min(SAME + CHANGE * way, MOST_ALIKE) * norm


def is_about_as_near(place, now):
    way = now.positions - place.positions
    return place.distance + place.gradient @ way <= now.distance + BAND and numpy.linalg.norm(way) <= REACH
