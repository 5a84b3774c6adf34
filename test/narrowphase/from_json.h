#pragma once

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

namespace proximity_server::narrowphase {

/// Numbers that JSON cannot write stand in quotes: "inf", "-inf", "nan".
inline double numberFrom(const nlohmann::json& j) {
  return j.is_string() ? std::stod(j.get<std::string>()) : j.get<double>();
}

inline Eigen::Vector3d vectorFrom(const nlohmann::json& j) {
  return {numberFrom(j[0]), numberFrom(j[1]), numberFrom(j[2])};
}

/// A matrix [R | t] by rows, with its doubles as they are: some are orthonormal to ten digits only.
inline Eigen::Isometry3d poseFrom(const nlohmann::json& rows) {
  Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column) result.matrix()(row, column) = rows[row][column];
  return result;
}

}  // namespace proximity_server::narrowphase
