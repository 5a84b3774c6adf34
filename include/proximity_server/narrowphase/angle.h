#pragma once

namespace proximity_server::narrowphase {

struct SineCosine {
  double sine, cosine;
};

/// The sine and the cosine of an angle [rad], computed by sums and products alone. They have the same bits on every
/// processor and with every C library, so that the poses of a robot do not depend on the host.
///
/// Error:   below 0.9 units in the last place.
/// Failure: NaN if the angle is not finite.
/// Source:  Cody, Waite, Software Manual for the Elementary Functions, 1980 (the reduction by pi / 2 in parts, up to
///          1.6e6 rad); Payne, Hanek, Radian Reduction for Trigonometric Functions, ACM SIGNUM 1983 (larger angles);
///          Taylor's polynomials up to pi / 4; Knuth, The Art of Computer Programming, volume 2, 1997, section 4.2.2
///          (the rounding error of a difference).
SineCosine sineAndCosine(double angle);

/// The angle [rad] from -pi to pi whose sine and cosine have these ratios. std::atan2() gives another last digit with
/// another C library; this has the same bits, unless two libraries round to different multiples of 2^-16, which their
/// last digit does for one angle in about 2^36.
///
/// Error:   below 4 units in the last place, for arguments between 1e-290 and 1e290.
/// Failure: as std::atan2(), where both arguments are zero or one is not finite.
double angleOf(double sine, double cosine);

}  // namespace proximity_server::narrowphase
