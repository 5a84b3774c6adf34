#include "tools/second_opinion/judgement.h"

#include <cmath>

namespace proximity_server::tools {
namespace {

using Eigen::Vector3d;

/// [m] The values that an answer allows, padding included.
struct AllowedValues {
  double least, most;
};

AllowedValues allowedBy(const OtherAnswer& answer, double padding) {
  if (answer.kind == OtherAnswer::Kind::Overlap) return {-kInfinity, -padding};
  return {answer.distance - padding, answer.distance - padding};
}

Hints hintsOf(const TwoOpinions& opinions) {
  const OtherAnswer& other = opinions.other.answer;
  const Vector3d other_a(other.point_a[0], other.point_a[1], other.point_a[2]),
      other_b(other.point_b[0], other.point_b[1], other.point_b[2]);
  Hints hints;
  hints.axes = {opinions.ours.normal, other_b - other_a, other_a - other_b};
  hints.points = {{opinions.ours.point_a, opinions.ours.point_b}, {other_a, other_b}};
  return hints;
}

bool mayBeInside(const TwoOpinions& opinions) {
  return (opinions.a.has_interior || opinions.b.has_interior) && !(opinions.ours.lower_bound > 0.0);
}

ProvenBounds provenOf(const TwoOpinions& opinions) {
  const ProvenBounds proven = provenBounds(opinions.a, opinions.b, hintsOf(opinions));
  return {mayBeInside(opinions) ? -kInfinity : proven.lower - opinions.padding, proven.upper - opinions.padding};
}

}  // namespace

const char* toString(Ruling ruling) {
  switch (ruling) {
    case Ruling::Agrees:
      return "within the tolerance";
    case Ruling::NotAsked:
      return "FCL has no shape for it";
    case Ruling::BelowLower:
      return "FCL's value is below the proven lower bound";
    case Ruling::AboveUpper:
      return "FCL's value is above the proven upper bound";
    case Ruling::Failed:
      return "FCL failed";
    case Ruling::Inside:
      return "ours is inside of a closed mesh, which FCL does not know";
    case Ruling::Undecided:
      return "undecided: what is proven allows both";
    case Ruling::OursRefuted:
      return "our bounds contradict what is proven";
  }
  return "";
}

Judgement judge(const TwoOpinions& opinions, double tolerance) {
  const narrowphase::SignedDistance& ours = opinions.ours;
  if (opinions.other.end != ChildEnd::Answered || std::isnan(opinions.other.answer.distance)) return {Ruling::Failed};
  if (opinions.other.answer.kind == OtherAnswer::Kind::NoShape) return {Ruling::NotAsked};
  const AllowedValues other = allowedBy(opinions.other.answer, opinions.padding);
  const bool agrees = other.most >= ours.lower_bound - tolerance && other.least <= ours.upper_bound + tolerance;
  if (agrees) return {Ruling::Agrees};
  const ProvenBounds proven = provenOf(opinions);
  if (proven.lower > ours.upper_bound || proven.upper < ours.lower_bound) return {Ruling::OursRefuted, proven};
  if (other.most < proven.lower - tolerance) return {Ruling::BelowLower, proven};
  if (other.least > proven.upper + tolerance) return {Ruling::AboveUpper, proven};
  return {mayBeInside(opinions) ? Ruling::Inside : Ruling::Undecided, proven};
}

}  // namespace proximity_server::tools
