#include "tools/clearance/trajectory_run.h"

#include "proximity_server/scene/levels/make_scene_model.h"
#include "proximity_server/scene/loading/load_robot_model.h"
#include "scene/files.h"
#include "tools/clearance/clearance_rows.h"
#include "tools/robot/two_sliders.h"
#include "tools/states/csv_states.h"
#include "tools/text/csv.h"

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

namespace proximity_server::tools::trajectory_run_test {

using namespace narrowphase;
using namespace scene;

const RobotModel& robot() {
  static const RobotModel model = loadRobotModel(kTwoSliders, packageResolver({}));
  return model;
}

std::vector<TrajectorySegment> segmentsOf(const std::string& text) {
  std::istringstream stream(text);
  CsvStates states(stream, "s.csv", robot());
  TrajectorySegments segments(states);
  std::vector<TrajectorySegment> all;
  for (TrajectorySegment segment; segments.next(segment);) all.push_back(segment);
  EXPECT_FALSE(segments.next(all.emplace_back())) << "nothing comes after the end";
  all.pop_back();
  return all;
}

std::string errorIn(const std::string& text) {
  return errorOf([&] { segmentsOf(text); });
}

TEST(TrajectorySegments, LeadFromWayPointToWayPoint) {
  const std::vector<TrajectorySegment> segments = segmentsOf("time,slide\n-1,0\n\n3,1\n3.5,-1\n");
  ASSERT_EQ(segments.size(), 2U);
  EXPECT_EQ(segments[0].begin, -1.0);
  EXPECT_EQ(segments[0].end, 3.0);
  EXPECT_EQ(segments[1].number, 1);
  EXPECT_EQ(segments[1].begin, 3.0);
  EXPECT_EQ(segments[1].end, 3.5);
  EXPECT_EQ(segments[1].from, segments[0].to);
  EXPECT_EQ(segments[1].positionsAt(0.25), segmentsOf("slide\n0.5\n0\n")[0].from);
}

TEST(TrajectorySegments, LastASecondEachWhereNoTimesAreGiven) {
  const std::vector<TrajectorySegment> segments = segmentsOf("slide\n0\n1\n2\n");
  ASSERT_EQ(segments.size(), 2U);
  EXPECT_EQ(segments[1].begin, 1.0);
  EXPECT_EQ(segments[1].end, 2.0);
}

TEST(TrajectorySegments, NameWhatIsNoTrajectory) {
  EXPECT_EQ(errorIn("slide\n"), "s.csv: a trajectory has at least two way points, this one has none");
  EXPECT_EQ(errorIn("slide\n1\n"), "s.csv: a trajectory has at least two way points, this one has 1");
  EXPECT_EQ(errorIn("slide,time\n1,2\n\n1,2\n"), "s.csv, line 4: column \"time\": 2 is not later than 2");
  EXPECT_EQ(errorIn("slide,time\n1,2\n1,3\n1,0.5\n"), "s.csv, line 4: column \"time\": 0.5 is not later than 3");
  EXPECT_EQ(errorIn("slide,time\n1,-1e308\n1,1e308\n"),
            "s.csv, line 3: column \"time\": 1e+308 is too far from -1e+308");
  EXPECT_EQ(errorIn("slide\n-1e308\n1e308\n"), "s.csv, line 3: column \"slide\": 1e+308 is too far from -1e+308");
}

// In doubles 0.2 + (0.9 - 0.2) is not 0.9.
TEST(TrajectorySegment, EndsWhereItEnds) {
  TrajectorySegment segment;
  segment.begin = 0.2;
  segment.end = 0.9;
  ASSERT_NE(segment.begin + 1.0 * (segment.end - segment.begin), segment.end);
  EXPECT_EQ(segment.timeAt(0.0), segment.begin);
  EXPECT_EQ(segment.timeAt(1.0), segment.end);
  EXPECT_TRUE(std::isnan(segment.timeAt(std::nan(""))));
}

TEST(SegmentRow, SaysWhereNothingIsKnown) {
  ClearanceQuestion question;
  question.model = std::make_shared<const SceneModel>(makeSceneModel(robot(), ""));
  question.thresholds.emplace();
  const std::vector<std::string> names = csvFields(segmentFormat(question, RowFormat::Csv).begin);
  const std::vector<std::string> fields = csvFields(rowText(ClearanceAnswer{}, question, RowFormat::Csv));
  ASSERT_EQ(fields.size(), names.size());
  const auto field = [&](const std::string& name) {
    return fields.at(std::find(names.begin(), names.end(), name) - names.begin());
  };
  EXPECT_EQ(field("contact"), "unknown");
  EXPECT_EQ(field("status"), "unknown");
  EXPECT_EQ(field("link_a") + field("contact_link_b"), "");
  EXPECT_EQ(field("t_minimum") + field("t_contact"), "nannan");
  EXPECT_EQ(field("lower"), "-inf");
  EXPECT_EQ(field("level") + field("t_level") + field("level_link_a"), "INVALIDnan");
  EXPECT_NE(rowText(ClearanceAnswer{}, question, RowFormat::Json).find("\"contact\":null"), std::string::npos);
}

}  // namespace proximity_server::tools::trajectory_run_test
