#include "narrowphase/shape/near_origin.h"

#include <cmath>
#include <limits>

namespace proximity_server::narrowphase {
namespace {

using Eigen::Vector3d;

/// A sum with its rounding errors summed beside it.
class AccurateSum {
 public:
  explicit AccurateSum(double first) : sum_(first) {}

  void add(double term) {
    const double sum = sum_ + term, added = sum - sum_;
    errors_ += (sum_ - (sum - added)) + (term - added);  // Knuth: exact
    sum_ = sum;
  }
  void addProduct(double x, double y) {
    const double product = x * y;
    add(product);
    errors_ += std::fma(x, y, -product);  // exact
  }
  double value() const { return sum_ + errors_; }

 private:
  double sum_, errors_ = 0.0;
};

Vector3d movedFrom(const Shape& shape) {
  return shape.isFarFromOrigin() ? shape.hull().vertices().front() : Vector3d(Vector3d::Zero());
}

}  // namespace

NearOrigin::NearOrigin(const Shape& a, const Shape& b, const Eigen::Isometry3d& a_T_b)
    : p_(movedFrom(a)), a_(a.nearOrigin()), b_(b.nearOrigin()), pose_(a_T_b) {
  const Vector3d q = movedFrom(b), t = a_T_b.translation();
  for (int row = 0; row < 3; ++row) {
    AccurateSum sum(t[row]);
    sum.add(-p_[row]);
    for (int column = 0; column < 3; ++column) sum.addProduct(a_T_b.linear()(row, column), q[column]);
    pose_.translation()[row] = sum.value();
  }
  constexpr double kEps = std::numeric_limits<double>::epsilon();
  error_ = kEps * (a_.coreReach() + b_.coreReach() + pose_.translation().norm()) +
           16.0 * kEps * kEps * (p_.norm() + q.norm() + t.norm());
}

}  // namespace proximity_server::narrowphase
