#pragma once

#include "proximity_server/narrowphase/cso/cso.h"

#include <array>
#include <functional>

namespace proximity_server::narrowphase {

/// Refines the first of two unit directions, which is shallower than the known depth. The other one is nearby, perhaps
/// on another smooth piece of the CSO. Returns the depth [m] that is known then, at most that along the first
/// direction; or 0 to end the search.
using RefineDirection = std::function<double(const std::array<Eigen::Vector3d, 2>& directions)>;

/// Lower bound of the depth of two overlapping cores, by branch and bound over the directions. If cores that are round
/// about nearly parallel axes lie nearly on one axis, the depth is nearly the same in a ring of directions, and EPA would
/// have to cover the ring with faces. So it is for a needle on the axis of a round core, and in all directions for a small
/// core in the centre of a nearly round ellipsoid.
///
/// 1. A direction has the latitude v and the azimuth p about the axis of a, or of b if a has none. The directions are
///    divided into patches [v1, v2] x [q - d, q + d].
/// 2. For v1 and v2 at the azimuth q take the support points of both cores. A core contains the circle of latitude
///    through its support point; of a core without an axis, the point alone is taken. The sum of both circles bounds the
///    support function h of the CSO from below in all directions, and is exact in the direction of the support points.
/// 3. In each direction, take one point of each circle instead of the farthest: the one whose azimuth differs from that
///    of the direction as much as in step 2. Its height is L = P(p) cos(v) + Q(p) sin(v), where P and Q are sums of 1,
///    cos(p), sin(p), cos(2 p) and sin(2 p). The circle of an ellipsoid may be an ellipse.
/// 4. An ellipsoid is the sum of a ball and a convex rest. The ball adds its radius to h in all directions, so that steps
///    2 and 3 see the rest only. It is left as large as the next steps need, for which L must be positive.
/// 5. A weighted mean of the bounds by v1 and by v2 is also a bound of this form. It is exact at a kink between two
///    smooth pieces of h. For each azimuth, it is between v1 and v2 at least the smaller one of its values at v1 and
///    v2, if that is positive. Each of these has a closed minimum over the azimuths, up to a bound of the second
///    harmonics.
/// 6. If this is less than the known depth minus half the tolerance, divide the patch: at the latitude where both
///    bounds are equal, or in the middle of its azimuths, depending on where more is lost. A direction that is
///    shallower than the known depth is refined, and its depth known from then on. The patch whose bound was the
///    smallest comes first, so that few are divided in which the depth is not smaller; while many wait, the newest comes
///    first, so that they fit into a fixed place.
///
/// A curved sweep that is not along the axis is replaced by its start. The search then bounds the depth of these inner
/// cores, which is at most the depth of the CSO, while the known depth is always the depth of the CSO. Where the CSO
/// reaches farther than the inner cores, all other patches come first: it may reach as far as they do in a part of the
/// ring only. The search is given up after 64 such directions, or after 2000 patches.
///
/// The loss is of second order in the size of the patch across the ring, and in the tilt times its size along the ring;
/// with a polytope it is of first order at the kinks between its vertices. So some hundred patches suffice, whatever the
/// amplitude of the depth along the ring is.
///
/// Kinds:   ellipsoids of which two radii are nearly equal, solids of revolution, and their sweeps along the axis. The
///          axes may be tilted by 0.02 rad. One of them or both may instead, in any pose, be nearly a ball or a
///          polytope that is thin beside both cores; and other sweeps if they are as deep as their start.
/// Returns: [m] the bound, which is half the tolerance below the smallest depth that was known or found; -infinity for
///          other cores, for a known depth that is not positive, for a tolerance that rounding exceeds, or if the search
///          is given up.
/// Source:  Land, Doig, An Automatic Method of Solving Discrete Programming Problems, Econometrica 1960 (branch and
///          bound); the bound of a patch is our own.
double depthAboutAxis(const Cso& cso, double depth, double tolerance, const RefineDirection& refine);

}  // namespace proximity_server::narrowphase
