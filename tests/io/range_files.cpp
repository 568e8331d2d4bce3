#include <filesystem>
#include <string>

#include <doctest/doctest.h>

#include <holdfast/io/range_files.hpp>

using namespace holdfast;

namespace {

const std::vector<RangeAnchor> two_anchors{{3, Vector3(1.0, 2.0, 3.0)}, {7, Vector3(4.0, 5.0, 6.0)}};

/// The message of the InputError that `read` throws; empty when it throws none.
template <typename Read>
std::string complaint(const Read& read) {
  try {
    (void)read();
  } catch (const io::InputError& error) {
    return error.what();
  }
  return "";
}
std::string anchors_complaint(const std::string& text) {
  return complaint([&] { return io::parse_anchors(text, "a.csv"); });
}
std::string ranges_complaint(const std::string& text) {
  return complaint([&] { return io::parse_ranges(text, "r.csv", two_anchors); });
}
std::string inertial_complaint(const std::string& text) {
  return complaint([&] { return io::parse_inertial(text, "i.csv"); });
}

void check_says(const std::string& message, std::initializer_list<std::string> parts) {
  for (const std::string& part : parts) {
    INFO("message: ", message);
    CHECK(message.find(part) != std::string::npos);
  }
}

}  // namespace

TEST_CASE("anchors, ranges and inertial samples are found by their columns' names") {
  const auto anchors =
      io::parse_anchors("id,x_m,y,z (Vicon/world frame)\n3,1,2,3\n\n# a comment\n7,4,5,6.5\r\n", "a.csv");
  REQUIRE(anchors.size() == 2);
  CHECK(anchors[1].id == 7);
  CHECK(anchors[1].p_W == Vector3(4.0, 5.0, 6.5));

  const auto ranges = io::parse_ranges("range_m,note,t_s,anchor_id\n1.5,x,0.25,7\n2,y,0.25,3\n", "r.csv", two_anchors);
  REQUIRE(ranges.size() == 2);
  CHECK(ranges[0].t == time_at(0.25));
  CHECK(ranges[0].anchor == 1);
  CHECK(ranges[0].range_m == 1.5);
  CHECK(ranges[1].anchor == 0);

  const auto inertial = io::parse_inertial("t_s gx_rad_s gy gz ax_m_s2 ay az\n0.001 1 2 3 4 5 9.8\n", "i.csv");
  REQUIRE(inertial.size() == 1);
  CHECK(inertial[0].t == time_at(0.001));
  CHECK(inertial[0].rate_B == Vector3(1.0, 2.0, 3.0));
  CHECK(inertial[0].force_B == Vector3(4.0, 5.0, 9.8));
}

TEST_CASE("EuRoC's inertial files; a lenient reading drops bad rows and counts them") {
  const std::string header =
      "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],"
      "a_RS_S_z [m s^-2]\n";
  const std::string good = "1403636579758555392,1,2,3,4,5,9.8\n", bad = "1403636579763555584,1,2,nan,4,5,9.8\n";
  const auto read = io::parse_inertial(header + good, "i.csv");
  REQUIRE(read.size() == 1);
  CHECK(read[0].t.time_since_epoch().count() == 1403636579758555392);
  CHECK(read[0].rate_B == Vector3(1.0, 2.0, 3.0));
  CHECK(read[0].force_B == Vector3(4.0, 5.0, 9.8));
  check_says(inertial_complaint(header + good + bad), {"i.csv:3", "w_RS_S_z", "nan"});
  const io::InertialFile lenient =
      io::parse_inertial(header + good + bad + "7,1\n" + good, "i.csv", io::ReadMode::lenient);
  CHECK(lenient.readings.size() == 2);
  CHECK(lenient.dropped == 2);
}

TEST_CASE("units in the names are heeded") {
  const auto ranges = io::parse_ranges("timestamp [ns],anchor,distance (mm)\n250000001,3,1500\n", "r.csv", two_anchors);
  CHECK(ranges[0].t.time_since_epoch().count() == 250'000'001);
  CHECK(ranges[0].range_m == doctest::Approx(1.5).epsilon(1e-15));
  CHECK(io::parse_ranges("t_ms,anchor,range\n250,3,1\n", "r.csv", two_anchors)[0].t == time_at(0.25));
  for (const std::string column : {"gx_deg_s", "gx [deg/s]", "gx (degrees per second)", "gx [mrad/s]", "gx_dps"}) {
    check_says(inertial_complaint("t," + column + ",gy,gz,ax,ay,az\n0,0,0,0,0,0,0\n"),
               {"i.csv:1", column, "not in rad/s", "gx_rad_s"});
  }
  for (const std::string column : {"ax_g", "ax [g]", "ax (mg)", "ax [cm/s^2]", "ax [mm s^-2]", "ax [ft/s^2]"}) {
    check_says(inertial_complaint("t,gx,gy,gz," + column + ",ay,az\n0,0,0,0,0,0,0\n"),
               {"i.csv:1", column, "not in m/s^2", "ax_m_s2"});
  }
  for (const char* right : {"t [s],gx [rad/s],gy (rad/s),gz,ax [m/s^2],ay (m/s2),az\n",
                            "t,gx (body frame),gy [radians/s],gz [rad/second],ax (body frame),ay [meters/s^2],az\n"}) {
    const auto read = io::parse_inertial(right + std::string("0,1,2,3,4,5,6\n"), "i.csv");
    CHECK(read[0].rate_B == Vector3(1.0, 2.0, 3.0));
    CHECK(read[0].force_B == Vector3(4.0, 5.0, 6.0));
  }
}

TEST_CASE("bad input names file, line, column, value and expectation") {
  check_says(anchors_complaint(""), {"a.csv", "empty", "id,x_m,y_m,z_m"});
  check_says(anchors_complaint("id,x,y,z\n"), {"a.csv:1", "no rows"});
  check_says(anchors_complaint("\nid,x,y\n1,2,3\n"), {"a.csv:2", "z", "does not name", "id,x,y", "id,x_m,y_m,z_m"});
  check_says(anchors_complaint("id,x,y,z,x_mm\n1,2,3,4,5\n"), {"a.csv:1", "x", "twice"});
  check_says(anchors_complaint("id,x,y,z\n1,2,3,4\n1,5,6,7\n"), {"a.csv:3", "id", "stands twice", "'1'"});
  check_says(anchors_complaint("id,x,y,z\n1.5,2,3,4\n"), {"a.csv:2", "id", "whole number", "'1.5'", "integer"});
  check_says(anchors_complaint("id,x,y,z\n1,2,oops,4\n"), {"a.csv:2", "y", "'oops'", "finite number"});
  check_says(anchors_complaint("id,x,y,z\n1,2,nan,4\n"), {"a.csv:2", "y", "'nan'", "finite number"});
  check_says(anchors_complaint("id,x,y,z\n1,2,3\n"), {"a.csv:2", "3 cells", "'1,2,3'", "4"});

  check_says(ranges_complaint("t_s,anchor_id,range_m\n0,4,1\n"), {"r.csv:2", "anchor_id", "'4'", "one of 3, 7"});
  check_says(ranges_complaint("t_s,anchor_id,range_m\n0,3,0\n"), {"r.csv:2", "range_m", "'0'", "above 0"});
  check_says(ranges_complaint("t_s,anchor_id,range_m\n0,3,-2\n"), {"r.csv:2", "range_m", "'-2'", "above 0"});
  check_says(ranges_complaint("t_s,anchor_id,range_m\n0,3,inf\n"), {"r.csv:2", "range_m", "'inf'", "finite"});
  check_says(ranges_complaint("t_s,anchor_id,range_m\n1,3,1\n0.5,3,1\n"), {"r.csv:3", "t_s", "back in time", "'0.5'"});
  check_says(ranges_complaint("t_s,anchor_id,range_m\nsoon,3,1\n"), {"r.csv:2", "t_s", "'soon'"});
  check_says(ranges_complaint("1,3,1\n"), {"r.csv:1", "t", "does not name", "t_s,anchor_id,range_m"});

  check_says(inertial_complaint("t,gx,gy,gz,ax,ay\n"), {"i.csv:1", "az", "does not name"});
  check_says(inertial_complaint("t,gx,gy,gz,ax,ay,az\n1,0,0,0,0,0,0\n0,0,0,0,0,0,0\n"),
             {"i.csv:3", "t", "back in time"});
}

TEST_CASE("the recording of ranges is read whole") {
  const std::filesystem::path folder = std::filesystem::path(HOLDFAST_RECORDINGS) / "range";
  if (!std::filesystem::exists(folder)) {
    MESSAGE("skipped: no recording of ranges");
    return;
  }
  const io::RangeFiles files{folder / "0607_twr_obs1_range.csv", folder / "anchor_0607_positions.csv",
                             folder / "0607_twr_obs1_imu.csv", folder / "0607_twr_obs1_pose.csv"};
  const RangeRecording recording = io::read_range_recording(files);
  CHECK(recording.anchors.size() == 8);  // rows of the files
  CHECK(recording.ranges.size() == 5509);
  CHECK(recording.inertial.size() == 66740);
  CHECK(recording.truth.size() == 13309);
  io::RangeFiles swapped = files;
  std::swap(swapped.ranges, swapped.inertial);
  check_says(complaint([&] { return io::read_range_recording(swapped); }), {"_imu.csv:1", "anchor"});
  swapped = files;
  swapped.anchors = folder / "none.csv";
  check_says(complaint([&] { return io::read_range_recording(swapped); }), {"none.csv", "cannot be opened"});
}
