#include <chrono>
#include <filesystem>
#include <string>

#include <doctest/doctest.h>

#include <holdfast/io/trajectory.hpp>

using namespace holdfast;
using namespace holdfast::io;

namespace {

const std::filesystem::path recordings = HOLDFAST_RECORDINGS;

/// The message of the InputError that parsing throws; empty when it throws none.
std::string complaint(std::string_view text, ReadMode mode = ReadMode::strict) {
  try {
    static_cast<void>(parse_trajectory(text, "motion.tum", mode));
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

bool contains(const std::string& text, std::string_view part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("TUM: seconds, xyzw, comments, empty lines, Windows line ends, commas, tabs") {
  for (const char* text :
       {"# c\n1.5 1 2 3 0 0 0 1\n\n2.5 4 5 6 0 0 1 0\n", "1.5,1,2,3,0,0,0,1\r\n2.5,4,5,6,0,0,1,0\r\n",
        "\xEF\xBB\xBF"
        "1.5\t1\t2\t3\t0\t0\t0\t1\n2.5\t4\t5\t6\t0\t0\t1\t0"}) {
    const TrajectoryFile file = parse_trajectory(text, "x");
    CHECK(file.report.format == TrajectoryFormat::tum);
    REQUIRE(file.samples.size() == 2);
    CHECK(file.samples[0].t.time_since_epoch().count() == 1'500'000'000);
    CHECK(file.samples[0].X_WB.p() == Vector3(1, 2, 3));
    CHECK(file.samples[0].X_WB.q().w() == 1.0);
    CHECK(file.samples[1].X_WB.q().z() == 1.0);
  }
}

TEST_CASE("EuRoC: whole nanoseconds, wxyz, further columns allowed") {
  const TrajectoryFile file = parse_trajectory(
      "#timestamp, p_RS_R_x [m], ...\n"
      "1520530308189679351,1,2,3,1,0,0,0,9,9,9\n"
      "1520530308198012351,1,2,3,0,0,0,1,9,9,9\n",
      "x");
  CHECK(file.report.format == TrajectoryFormat::euroc);
  CHECK(file.samples[0].t.time_since_epoch().count() == 1520530308189679351);
  CHECK(file.samples[0].X_WB.q().w() == 1.0);
  CHECK(file.samples[1].X_WB.q().z() == 1.0);
}

TEST_CASE("named CSV: quoted cells are understood, a comma within quotes is not misread") {
  const TrajectoryFile file = parse_trajectory(
      "\"t_s\",x,y,z,note\n"
      "0,1,2,3,\"start\"\n"
      "1,1,2,3,\"a,b\"\n"
      "2,1,2,\"4\",\n",
      "x", ReadMode::lenient);
  CHECK(file.report.dropped[0] == 1);  // one cell too many
  CHECK(file.samples.size() == 2);
  CHECK(file.samples[1].X_WB.p() == Vector3(1, 2, 4));
}

TEST_CASE("named CSV: values land where the names say") {
  const TrajectoryFile file = parse_trajectory(
      "qx;time_ms;acc_x_m_s2;px_mm;py;pz;qy;qz;qw\n"
      "0;1000.5;9.8;1000;2000;3000;0;0.6;0.8\n"
      "0;1010.5;9.8;1001;2000;3000;0;0;1\n",
      "x");
  CHECK(file.report.format == TrajectoryFormat::named_csv);
  CHECK(file.samples[0].t.time_since_epoch().count() == 1'000'500'000);
  CHECK((file.samples[0].X_WB.p() - Vector3(1, 2, 3)).norm() < 1e-15);
  CHECK(file.samples[0].X_WB.q().w() == doctest::Approx(0.8).epsilon(1e-15));
  CHECK(file.samples[0].X_WB.q().z() == doctest::Approx(0.6).epsilon(1e-15));
}

TEST_CASE("a comment that names the columns of a TUM file decides the quaternion's order") {
  const std::string rows = "1.0 0 0 0 1 0 0 0\n2.0 0 0 0 1 0 0 0\n";
  CHECK(parse_trajectory(rows, "x").samples[0].X_WB.q().x() == 1.0);
  CHECK(parse_trajectory("# timestamp tx ty tz qw qx qy qz\n" + rows, "x").samples[0].X_WB.q().w() == 1.0);
}

TEST_CASE("orientation alone and position alone are read, and said") {
  const TrajectoryFile turning = parse_trajectory("t_s,qw,qx,qy,qz\n0,1,0,0,0\n1,0,1,0,0\n", "x");
  CHECK_FALSE(turning.report.has_position);
  CHECK(turning.samples[1].X_WB.p() == Vector3::Zero());
  CHECK(turning.samples[1].X_WB.q().x() == 1.0);
  CHECK(contains(describe(turning.report), "no position"));
  const TrajectoryFile moving = parse_trajectory("t_s,x,y,z\n0,1,0,0\n1,0,1,0\n", "x");
  CHECK_FALSE(moving.report.has_orientation);
  CHECK(moving.samples[1].X_WB.p() == Vector3(0, 1, 0));
  CHECK(contains(describe(moving.report), "no orientation"));
}

TEST_CASE("times are exact to the nanosecond") {
  struct Case {
    const char* text;
    int digits;
    std::int64_t ns;
  };
  for (const Case& c :
       {Case{"1705504375.238748312", 9, 1705504375238748312}, Case{"1.705504375238748312e+09", 9, 1705504375238748312},
        Case{"-0.000000001", 9, -1}, Case{"0.0000000005", 9, 1}, Case{"0.00000000049999", 9, 0}, Case{"12", 0, 12},
        Case{"12.5", 0, 13}, Case{"1520530308189679351", 0, 1520530308189679351}, Case{".5", 9, 500000000},
        Case{"5.", 9, 5000000000}, Case{"1e-3", 6, 1000}, Case{"7", 3, 7000}, Case{"0e9999", 9, 0},
        Case{"1705504375.2387483120000000000000001", 9, 1705504375238748312}}) {
    CAPTURE(std::string(c.text));
    const auto time = io::detail::parse_time(c.text, c.digits);
    REQUIRE(time.has_value());
    CHECK(time->count() == c.ns);
  }
  for (const char* text :
       {"", "-", ".", "1.2.3", "1e", "1e+", "e5", "0x10", "1 ", "nan", "1e99", "9223372036854775808", "1e2147483648"}) {
    CAPTURE(std::string(text));
    CHECK_FALSE(io::detail::parse_time(text, 9).has_value());
  }
}

TEST_CASE("strict: each kind of bad row is an error that names file, line, what was found and expected") {
  const std::string good = "1.0 0 0 0 0 0 0 1\n";
  struct Case {
    const char* row;
    const char* says;
  };
  for (const Case& c :
       {Case{"2.0 0 0 0 0 0 1", "malformed"}, Case{"2.0 0 0 0 0 0 0 1 7", "expected 8 columns"},
        Case{"2.0 0 zero 0 0 0 0 1", "y: malformed (found 'zero'); expected a number"},
        Case{"2.0 0 1,5 0 0 0 0 1", "(found '1,5')"}, Case{"2.0 0 nan 0 0 0 0 1", "non-finite"},
        Case{"2.0 0 0 0 inf 0 0 1", "non-finite"}, Case{"nan 0 0 0 0 0 0 1", "time: non-finite"},
        Case{"later 0 0 0 0 0 0 1", "time: malformed (found 'later'); expected a number"},
        Case{"1.0 0 0 0 0 0 0 1", "duplicate time (found '1.0')"}, Case{"0.9 0 0 0 0 0 0 1", "backward time"},
        Case{"2.0 0 0 0 0 0 0 0", "bad quaternion"}, Case{"2.0 0 0 0 0 0 0 2.5", "a length between 0.5 and 2"},
        Case{"2.0 0 0 0 0 0 0 1e200", "bad quaternion"}, Case{"2.0 1e300 0 0 0 0 0 1", "position"},
        Case{"2.0 1e999 0 0 0 0 0 1", "malformed"},
        Case{"1705504375238.7 0 0 0 0 0 0 1", "milliseconds or nanoseconds"}}) {
    CAPTURE(std::string(c.row));
    const std::string text = "# header\n" + good + c.row + "\n3.0 0 0 0 0 0 0 1\n";
    const std::string message = complaint(text);
    CHECK_MESSAGE(message.starts_with("motion.tum:3: "), message);
    CHECK_MESSAGE(contains(message, c.says), message);
    CHECK(contains(message, "; expected "));
    const TrajectoryFile file = parse_trajectory(text, "x", ReadMode::lenient);
    CHECK(file.samples.size() == 2);
    CHECK(file.report.rows == 3);
    CHECK(file.report.dropped_rows() == 1);
  }
}

TEST_CASE("lenient: dropped rows are counted by cause and described") {
  const TrajectoryFile file = parse_trajectory(
      "1 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n0 0 0 0 0 0 0 1\nx\n2 nan 0 0 0 0 0 1\n3 0 0 0 0 0 0 0\n4 0 0 0 0 0 0 1\n",
      "x", ReadMode::lenient);
  for (const std::size_t count : file.report.dropped) CHECK(count == 1);
  const std::string words = describe(file.report);
  for (const std::string_view name : row_fault_names) CHECK(contains(words, name));
}

TEST_CASE("lenient: rubbish before the first row is dropped, rubbish alone is an error") {
  const TrajectoryFile file = parse_trajectory("hello\n1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1\n", "x", ReadMode::lenient);
  CHECK(file.report.dropped[0] == 1);
  CHECK(contains(complaint("hello\nworld\n", ReadMode::lenient), "motion.tum:1: "));
}

TEST_CASE("a row whose pose is NaN in named CSV is an occlusion in both modes; a part that is NaN is not") {
  const std::string header = "t_s,px,py,pz,qw,qx,qy,qz\n";
  const std::string text =
      header + "0,0,0,0,1,0,0,0\n1,nan,nan,nan,nan,nan,nan,nan\n2,0,0,0,nan,nan,nan,nan\n3,,,,,,,\n4,0,0,0,1,0,0,0\n";
  for (const ReadMode mode : {ReadMode::strict, ReadMode::lenient}) {
    const TrajectoryFile file = parse_trajectory(text, "x", mode);
    CHECK(file.samples.size() == 2);
    CHECK(file.report.occlusions == 3);
    CHECK(file.report.dropped_rows() == 0);
  }
  CHECK(contains(complaint(header + "0,0,0,0,1,0,0,0\n1,0,nan,0,1,0,0,0\n"), "motion.tum:3: non-finite"));
  CHECK(contains(complaint("1 nan nan nan nan nan nan nan\n2 0 0 0 0 0 0 1\n"),
                 "motion.tum:1: non-finite"));  // TUM has none
}

TEST_CASE("files without a trajectory say what is missing") {
  CHECK(contains(complaint(""), "no rows"));
  CHECK(contains(complaint("# only a comment\n"), "no rows"));
  CHECK(contains(complaint("t_s,gx_rad_s,gy,gz\n0,0,0,0\n"),
                 "motion.tum:1: the header names no position or orientation column"));
  CHECK(contains(complaint("id,x_m,y,z\n0,0,0,0\n"), "no time column"));
  CHECK(contains(complaint("t,x,y,qw,qx,qy,qz\n"), "only a part of the position"));
  CHECK(contains(complaint("t,x,y,z,qx,qy,qz\n"), "only a part of the quaternion"));
  CHECK(contains(complaint("t,x,px,y,z\n"), "twice"));
  CHECK(contains(complaint("1 2 3\n4 5 6\n"), "not a row of a known format"));
  CHECK(contains(complaint("1 0 0 0 0 0 0 1\n"), "holds 1 usable poses of 1 rows; expected at least two"));
  CHECK_THROWS_AS(static_cast<void>(read_trajectory("/nowhere/at/all.tum")), InputError);
  CHECK_THROWS_AS(static_cast<void>(read_trajectory("/")), InputError);
}

TEST_CASE("gaps, non-unit quaternions and the rate are reported") {
  std::string text;
  for (int i = 0; i < 50; ++i) {
    const int ms = 10 * i + (i > 20 ? 300 : 0) + (i > 40 ? 70 : 0);
    text += "0." + std::string(ms < 100 ? (ms < 10 ? "00" : "0") : "") + std::to_string(ms) + " 0 0 0 0 0 0 " +
            (i == 7 ? "1.01" : "1") + "\n";
  }
  const TrajectoryFile file = parse_trajectory(text, "x");
  CHECK(file.report.gaps == 2);
  CHECK(file.report.longest_gap == std::chrono::milliseconds(310));
  CHECK(file.report.longest_gap_start == std::chrono::milliseconds(200));
  CHECK(file.report.rate_hz() == doctest::Approx(100.0));
  CHECK(file.report.non_unit_quaternions == 1);
  CHECK(file.samples[7].X_WB.q().norm() == doctest::Approx(1.0).epsilon(1e-15));
  CHECK(file.report.suspicions.empty());
  CHECK(contains(describe(file.report), "2 gaps"));
}

TEST_CASE("likely unit and order mistakes are suspected, sound recordings are not") {
  const auto suspicion = [](const std::string& text) {
    const TrajectoryFile file = parse_trajectory(text, "x");
    std::string all;
    for (const std::string& s : file.report.suspicions) all += s;
    return all;
  };
  CHECK(contains(suspicion("0 0 0 0 0 0 0 1\n8333333 0 0 0 0 0 0 1\n16666666 0 0 0 0 0 0 1\n"), "nanoseconds"));
  CHECK(contains(suspicion("0 0 0 0 0 0 0 1\n8.3 0 0 0 0 0 0 1\n16.6 0 0 0 0 0 0 1\n"), "milliseconds"));
  CHECK(contains(suspicion("0.00 0 1700 0 0 0 0 1\n0.01 2 1700 0 0 0 0 1\n0.02 4 1700 0 0 0 0 1\n"), "millimetres"));
  CHECK(
      contains(suspicion("0.00 0 0 0 0 0 0 1\n0.01 0 0 0 0 1 0 0\n0.02 0 0 0 0 0 0 1\n0.03 0 0 0 1 0 0 0\n"), "order"));
  CHECK(suspicion("0.00 0 1.7 0 0 0 0 1\n0.01 0 1.7 0.01 0 0 0.01 1\n0.02 0 1.7 0 0 0 0 1\n").empty());
}

TEST_CASE("write_tum is read back the same, and leaves nothing when it cannot write") {
  const std::filesystem::path path = std::filesystem::temp_directory_path() / "holdfast_write_tum_test.tum";
  std::vector<TimedPose> poses;
  poses.push_back(
      {HostTime(Duration(-500'000'001)), Rigid(Quaternion(0.8, 0.6, 0, 0), Vector3(1.0 / 3.0, -2e-9, 12345.678))});
  poses.push_back({HostTime(Duration(1705504375238748312)), Rigid(Quaternion(0.1, -0.2, 0.3, 0.4), Vector3(0, 0, 0))});
  write_tum(path, poses);
  const TrajectoryFile file = read_trajectory(path);
  std::filesystem::remove(path);
  REQUIRE(file.samples.size() == 2);
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(file.samples[i].t == poses[i].t);
    CHECK(file.samples[i].X_WB.p() == poses[i].X_WB.p());
    // Reading normalises once more: a rounding.
    CHECK((file.samples[i].X_WB.q().coeffs() - poses[i].X_WB.q().coeffs()).norm() < 1e-15);
  }
  CHECK_THROWS_AS(write_tum("/nowhere/at/all.tum", poses), InputError);
}

TEST_CASE("every recording loads, strictly") {
  if (!std::filesystem::is_directory(recordings)) {
    MESSAGE("skipped: no recordings at " << recordings.string());
    return;
  }
  struct Case {
    const char* file;
    TrajectoryFormat format;
    std::size_t poses, occlusions;
  };
  using enum TrajectoryFormat;
  for (const Case& c :
       {Case{"head/optitrack_head_120hz.tum", tum, 13479, 0}, Case{"head/quest2_traj1_headset_72hz.tum", tum, 8534, 0},
        Case{"head/quest2_traj1_robot_truth_30hz.tum", tum, 3555, 0}, Case{"handheld/table_01.txt", tum, 8156, 0},
        Case{"handheld/table_02.txt", tum, 9515, 0}, Case{"handheld/table_03.txt", tum, 23162, 0},
        Case{"handheld/table_04.txt", tum, 20036, 0}, Case{"handheld/room1.csv", euroc, 16541, 0},
        Case{"handheld/room2.csv", euroc, 15477, 0}, Case{"handheld/room3.csv", euroc, 15200, 0},
        Case{"imu/broad_07_fast_rotation.csv", named_csv, 50924, 1594},
        Case{"range/0607_twr_obs1_pose.csv", named_csv, 13309, 0}}) {
    CAPTURE(std::string(c.file));
    const auto start = std::chrono::steady_clock::now();
    const TrajectoryFile file = read_trajectory(recordings / c.file);
    const std::chrono::duration<double, std::milli> elapsed = std::chrono::steady_clock::now() - start;
    MESSAGE(std::string(c.file) << " in " << elapsed.count() << " ms\n" << describe(file.report));
    CHECK(file.report.format == c.format);
    CHECK(file.samples.size() == c.poses);
    CHECK(file.report.occlusions == c.occlusions);
    CHECK(elapsed.count() < 1000.0);  // 10 MB; a debug build on a busy machine, still well below a second
  }
}
