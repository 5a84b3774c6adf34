// Asks the node for the closest pair of links, and the library for a distance that is known.
#include <proximity_server/QueryPairs.h>
#include <proximity_server/narrowphase/signed_distance.h>
#include <proximity_server/scene/loading/load_robot_model.h>

#include <ros/ros.h>

#include <cstdio>

int main(int argc, char** argv) {
  using namespace proximity_server;
  Eigen::Isometry3d a_T_b = Eigen::Isometry3d::Identity();
  a_T_b.translation().x() = 1.0;
  const double gap = narrowphase::signedDistance(narrowphase::Sphere{0.25}, narrowphase::Sphere{0.25}, a_T_b).distance;
  const auto robot = scene::loadRobotModel("<robot name='r'><link name='a'/></robot>", scene::packageResolver({}));
  std::printf("%g m, %zu link\n", gap, robot.links.size());

  ros::init(argc, argv, "closest");
  QueryPairs query;
  query.request.mode = QueryPairs::Request::MINIMUM;
  if (!ros::service::waitForService("/proximity_server/query_pairs", ros::Duration(30.0)) ||
      !ros::service::call("/proximity_server/query_pairs", query) || !query.response.success)
    return 1;
  const Proximity& closest = query.response.minimum;
  std::printf("%s - %s: %.3f m\n", closest.a.link.c_str(), closest.b.link.c_str(), closest.distance);
  return 0;
}
