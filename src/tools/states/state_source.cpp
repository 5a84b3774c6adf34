#include "tools/states/state_source.h"

#include <stdexcept>
#include <utility>

namespace proximity_server::tools {

int StateSource::read(Eigen::Ref<Eigen::MatrixXd> block) {
  if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
  int count = 0;
  try {
    for (; count < block.rows() && next(row_); ++count) {
      for (Eigen::Index joint = 0; joint < block.cols(); ++joint) block(count, joint) = row_[joint];
    }
  } catch (const std::invalid_argument&) {
    if (count == 0) throw;
    error_ = std::current_exception();
  }
  return count;
}

void StateSource::fail(const std::string& what) const { throw std::invalid_argument(place() + ": " + what); }

}  // namespace proximity_server::tools
