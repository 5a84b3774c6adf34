"""Rows that pairs had before their closest points jumped, without ROS.

Where two places of a pair are equally near, its distance has a kink: the row is about the one place in this step, and about the other
one in the next. Who heeds the present row alone goes to and fro between them, and loses distance with each step. So the row
of before is heeded too, as bundle methods do, for as long as its own place stays about as near as the present one.

Source: Lemarechal, An extension of Davidon methods to non differentiable problems, Mathematical Programming Study, 1975.
"""

import collections

import numpy

JUMP = 0.3  # a gradient that changes in a step by that part of its norm is about another place
BAND = 1e-3  # [m] how much farther than the present place a remembered one may be
REACH = 0.1  # [rad, m] how far its gradient is taken to hold

# What was known of a pair in one step.
Place = collections.namedtuple("Place", "gradient distance positions")


class RememberedRows:
    def __init__(self):
        self.latest, self.before_jump = {}, {}  # by pair

    def update(self, positions, rows):
        """Takes the rows of a step, {pair: (gradient, distance)}. Returns {pair: gradient} of those to heed as well, with the
        bounds that the pairs have at present."""
        latest = {pair: Place(gradient, distance, positions) for pair, (gradient, distance) in rows.items()}
        self.before_jump = {pair: place for pair, now in latest.items()
                            if (place := self._place_before(pair, now)) is not None and is_about_as_near(place, now)}
        self.latest = latest
        return {pair: place.gradient for pair, place in self.before_jump.items()}

    def _place_before(self, pair, now):
        previous = self.latest.get(pair)
        return previous if previous is not None and jumps(previous, now) else self.before_jump.get(pair)


def jumps(place, now):
    norms = numpy.linalg.norm(place.gradient), numpy.linalg.norm(now.gradient)
    return numpy.linalg.norm(now.gradient - place.gradient) > JUMP * max(norms)


def is_about_as_near(place, now):
    way = now.positions - place.positions
    return place.distance + place.gradient @ way <= now.distance + BAND and numpy.linalg.norm(way) <= REACH
