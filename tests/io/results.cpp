#include <algorithm>
#include <limits>

#include <doctest/doctest.h>

#include <holdfast/io/results.hpp>

using namespace holdfast;
using io::ResultJson;

namespace {

ExperimentRow example_row() {
  ExperimentRow row;
  row.motion = "a, \"quoted\" file.tum";
  row.pipeline = Pipeline::p1;
  row.eye = EyeSide::right;
  row.lens = LensMode::uncorrected;
  row.latency_ms = 37.5;
  row.display = ScanOut::rolling;
  row.frames = 12;
  row.registration = RegistrationSummary{1, 2, 3, 4, 5, 6, 7, 8, 9};
  row.swim = SwimSummary{10, 11, 12, 13};
  row.pose.peak_yaw_arcmin = 14;
  row.effective_latency_ms = -0.5;
  row.expected = {{"pose.peak_yaw_arcmin", 14.1, 0.2, 14}};
  row.verdict = Verdict::pass;
  return row;
}

}  // namespace

TEST_CASE("a row has the contract's keys, with the numbers where they belong") {
  const ResultJson json = io::row_json(example_row());
  CHECK(json["motion"] == "a, \"quoted\" file.tum");
  CHECK(json["pipeline"] == "P1");
  CHECK(json["eye"] == "right");
  CHECK(json["lens"] == "uncorrected");
  CHECK(json["latency_ms"] == 37.5);
  CHECK(json["display"] == "rolling");
  CHECK(json["frames"] == 12);
  const std::pair<const char*, double> registration[] = {{"rms_px", 1},  {"mean_px", 2},    {"p95_px", 4},
                                                         {"peak_px", 6}, {"rms_arcmin", 7}, {"peak_arcmin", 8},
                                                         {"rms_mm", 9}};
  for (const auto& [key, value] : registration) CHECK(json["registration"][key] == value);
  CHECK(json["swim"]["rms_deg_s"] == 12);
  CHECK(json["swim"]["peak_deg_s"] == 13);
  CHECK(json["effective_latency_ms"] == -0.5);
  CHECK(json["expected"]["pose.peak_yaw_arcmin"]["expected"] == 14.1);
  CHECK(json["expected"]["pose.peak_yaw_arcmin"]["measured"] == 14.0);
  CHECK(json["verdict"] == "pass");
}

TEST_CASE("what is undefined or not finite is null, and its key is there all the same") {
  ExperimentRow row;
  row.latency_ms = std::numeric_limits<double>::quiet_NaN();
  row.jitter_arcmin = std::numeric_limits<double>::infinity();
  const ResultJson json = io::row_json(row);
  for (const char* key : {"latency_ms", "jitter_arcmin", "overshoot_arcmin", "effective_latency_ms",
                          "coverage_missing_pct", "disocclusion_pct", "picture_vs_theory_px", "expected"}) {
    REQUIRE(json.contains(key));
    CHECK(json[key].is_null());
  }
  CHECK(json["registration"]["rms_px"].is_null());
  CHECK(json["swim"]["peak_deg_s"].is_null());
  CHECK(json["verdict"] == "none");
  const std::string text = io::json_text(json);
  CHECK(text.find("nan") == std::string::npos);
  CHECK(text.find("inf") == std::string::npos);
}

TEST_CASE("numbers keep every digit through the file") {
  ExperimentRow row = example_row();
  row.registration->rms_px = 0.1 + 0.2;
  CHECK(ResultJson::parse(io::json_text(io::row_json(row)))["registration"]["rms_px"].get<double>() == 0.1 + 0.2);
}

TEST_CASE("CSV has one header, one line a row, equal counts of cells, and quotes what needs it") {
  const std::vector<ExperimentRow> rows{example_row(), ExperimentRow()};
  const std::string text = io::rows_csv(rows);
  std::vector<std::string> lines;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = text.find('\n', begin);
    lines.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  REQUIRE(lines.size() == 3);
  const auto starts_with = [](const std::string& line, std::string_view start) { return line.rfind(start, 0) == 0; };
  CHECK(starts_with(lines[0],
                    "motion,pipeline,eye,lens,latency_ms,display,deflection,per_scanline,interval_error_ms,"
                    "ablation,late_ms,frames,registration.rms_px,"));
  CHECK(starts_with(
      lines[1], "\"a, \"\"quoted\"\" file.tum\",P1,right,uncorrected,37.5,rolling,none,false,0.0,false,,12,1.0,2.0,"));
  const auto commas = [](const std::string& line) { return std::count(line.begin(), line.end(), ','); };
  CHECK(commas(lines[0]) == commas(lines[2]));
  CHECK(commas(lines[0]) + 1 == commas(lines[1]));  // the motion's own comma
  CHECK(io::rows_csv({}).empty());
}

TEST_CASE("a latency without an estimate is null and says why") {
  LatencyResult result;
  result.status = LatencyStatus::no_motion;
  const ResultJson none = io::latency_json(result, FrameRelation::rigid);
  CHECK(none["schema"] == "holdfast/latency/1");
  CHECK(none["effective_latency_ms"].is_null());
  CHECK(none["angle_deg"]["rms"].is_null());
  CHECK(none["status"].get<std::string>().find("motion") != std::string::npos);

  result.status = LatencyStatus::ok;
  result.effective_latency_ms = 37.3;
  result.uncertainty_ms = std::numeric_limits<double>::infinity();
  result.angle_deg.p95 = 0.25;
  const ResultJson json = io::latency_json(result, FrameRelation::rigid);
  CHECK(json["effective_latency_ms"] == 37.3);
  CHECK(json["uncertainty_ms"].is_null());
  CHECK(json["angle_deg"]["p95"] == 0.25);
  CHECK(json["frames_aligned"] == true);
  CHECK(io::latency_json(result, FrameRelation::same)["frames_aligned"] == false);
}

TEST_CASE("a name that is not UTF-8 does not stop the file from being written") {
  ExperimentRow row;
  row.motion = "caf\xe9.tum";
  CHECK(ResultJson::parse(io::json_text(io::row_json(row)))["motion"].get<std::string>().rfind("caf", 0) == 0);
}
