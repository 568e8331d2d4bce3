/// swimlab calibrate inertial: orientation, biases, scales, places and time offset of inertial sensors (001 appendix C).
#include "calibrate_command.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include <holdfast/calibration/inertial_calibration.hpp>
#include <holdfast/io/inertial_files.hpp>
#include <holdfast/io/input_error.hpp>
#include <holdfast/io/result_json.hpp>
#include <holdfast/io/trajectory.hpp>

#include "exit_code.hpp"
#include "options.hpp"
#include "output_folder.hpp"

namespace swimlab {

using namespace holdfast;
using io::ResultJson;

namespace {

constexpr double degree_per_rad = 180.0 / std::numbers::pi;

struct CalibrateOptions {
  std::filesystem::path poses, imu, json;  ///< json empty: none
  std::vector<CalibrationMethod> methods;
  InertialCalibrationSettings settings;
  bool lenient = false;
};

/// A parameter as people read it: degrees, milliseconds, millimetres.
struct ReadableUnit {
  const char* name;
  double factor;
};

ReadableUnit readable(const std::string& unit) {
  if (unit == "rad") return {"deg", degree_per_rad};
  if (unit == "rad/s") return {"deg/s", degree_per_rad};
  if (unit == "s") return {"ms", 1e3};
  if (unit == "m") return {"mm", 1e3};
  return {unit == "1" ? "" : unit.c_str(), 1.0};
}

void print_fit(const ParameterFit& fit, const char* residual_unit) {
  std::printf("  %-36s %12s %12s\n", "", "found", "deviation");
  for (std::size_t i = 0; i < fit.parameters.size(); ++i) {
    const FitParameter& parameter = fit.parameters[i];
    const ReadableUnit unit = readable(parameter.unit);
    const int k = static_cast<int>(i);
    std::printf("  %-36s %12.4f %12.4f %-6s%s\n", parameter.name.c_str(), unit.factor * fit.x[k],
                unit.factor * fit.deviation(k), unit.name, fit.observed(k) ? "" : "not told by this recording");
  }
  std::printf("  residual %.4g %s RMS over %zu comparisons, %zu of them outliers; deviations enlarged %.2f times\n",
              fit.rms, residual_unit, fit.comparisons, fit.outliers, std::max(1.0, fit.excess));
  for (const std::string& direction : fit.unobserved) std::printf("  nominal still: %s\n", direction.c_str());
}

void print_result(CalibrationMethod method, const InertialCalibration& found) {
  std::printf("\n%s\n", name_of(method));
  for (const std::string& note : found.notes) std::printf("  note: %s\n", note.c_str());
  if (!found.problem.empty()) {
    std::printf("  not calibrated: %s\n", found.problem.c_str());
    return;
  }
  std::printf("  turning %.2f deg/s RMS; before calibration gyros and poses agree by %.4f, of 1\n",
              degree_per_rad * found.turning, found.agreement);
  print_fit(found.gyro_fit, method == CalibrationMethod::differentiating ? "rad/s" : "rad");
  if (!found.accelerometer_problem.empty()) {
    std::printf("  accelerometers not calibrated: %s\n", found.accelerometer_problem.c_str());
    return;
  }
  print_fit(found.accelerometer_fit, "m");
}

ResultJson axes_json(const Vector3& v) {
  return {v.x(), v.y(), v.z()};
}
ResultJson quaternion_json(const Quaternion& q) {
  return {q.x(), q.y(), q.z(), q.w()};
}

ResultJson fit_json(const ParameterFit& fit, const char* residual) {
  ResultJson json;
  json["parameters"] = ResultJson::array();
  for (std::size_t i = 0; i < fit.parameters.size(); ++i) {
    const FitParameter& parameter = fit.parameters[i];
    const int k = static_cast<int>(i);
    json["parameters"].push_back({{"name", parameter.name},
                                  {"unit", parameter.unit},
                                  {"value", io::number_or_null(fit.x[k])},
                                  {"deviation", io::number_or_null(fit.deviation(k))},
                                  {"nominal", parameter.nominal},
                                  {"nominal_deviation", parameter.deviation},
                                  {"observed", fit.observed(k)}});
  }
  json["unobserved"] = fit.unobserved;
  json[residual] = io::number_or_null(fit.rms);
  json["comparisons"] = fit.comparisons;
  json["outliers"] = fit.outliers;
  json["deviations_enlarged"] = io::number_or_null(std::max(1.0, fit.excess));
  return json;
}

ResultJson method_json(CalibrationMethod method, const InertialCalibration& found) {
  ResultJson row;
  row["method"] = name_of(method);
  row["problem"] = found.problem.empty() ? ResultJson(nullptr) : ResultJson(found.problem);
  row["accelerometer_problem"] =
      found.accelerometer_problem.empty() ? ResultJson(nullptr) : ResultJson(found.accelerometer_problem);
  row["notes"] = found.notes;
  row["gyro"] = nullptr;
  row["accelerometer"] = nullptr;
  if (found.problem.empty()) {
    ResultJson gyro = fit_json(
        found.gyro_fit, method == CalibrationMethod::differentiating ? "residual_rms_rad_s" : "residual_rms_rad");
    gyro["time_offset_ms"] = 1e3 * found.gyro.time_offset_s;
    gyro["time_offset_deviation_ms"] = 1e3 * found.gyro_fit.deviation(9);
    gyro["orientation_xyzw"] = quaternion_json(found.gyro.q_BS);
    gyro["bias_rad_s"] = axes_json(found.gyro.bias);
    gyro["scale"] = axes_json(found.gyro.scale);
    gyro["turning_rad_s"] = found.turning;
    gyro["agreement"] = found.agreement;
    row["gyro"] = gyro;
  }
  if (found.accelerometer_problem.empty()) {
    ResultJson accelerometer = fit_json(found.accelerometer_fit, "residual_rms_m");
    accelerometer["orientation_xyzw"] = quaternion_json(found.accelerometer.q_BA);
    accelerometer["bias_m_s2"] = axes_json(found.accelerometer.bias);
    accelerometer["scale"] = axes_json(found.accelerometer.scale);
    accelerometer["gravity_m_s2"] = axes_json(found.accelerometer.gravity_W);
    accelerometer["places_mm"] = ResultJson::array();
    for (const Vector3& place_B : found.accelerometer.places_B) {
      accelerometer["places_mm"].push_back(axes_json(1e3 * place_B));
    }
    row["accelerometer"] = accelerometer;
  }
  return row;
}

int calibrate(const CalibrateOptions& o) {
  const std::filesystem::path json_file = checked_json_file(o.json);
  const io::ReadMode mode = o.lenient ? io::ReadMode::lenient : io::ReadMode::strict;
  const io::TrajectoryFile recording = io::read_trajectory(o.poses, mode);
  std::printf("%s: %s", o.poses.string().c_str(), io::describe(recording.report).c_str());
  const io::InertialFile imu = io::read_inertial(o.imu, mode);
  std::printf("%s: %zu readings%s\n", o.imu.string().c_str(), imu.readings.size(),
              imu.dropped > 0 ? (", " + std::to_string(imu.dropped) + " bad rows dropped").c_str() : "");
  ResultJson json;
  json["schema"] = "holdfast/calibrate/1";
  json["sensor"] = "inertial";
  json["poses"] = o.poses.filename().string();
  json["imu"] = o.imu.filename().string();
  json["rows"] = ResultJson::array();
  std::string problem = "no method";
  for (const CalibrationMethod method : o.methods) {
    InertialCalibrationSettings settings = o.settings;
    settings.method = method;
    const InertialCalibration found = calibrate_inertial(recording.samples, imu.readings, settings);
    print_result(method, found);
    json["rows"].push_back(method_json(method, found));
    problem = found.problem.empty() ? "" : found.problem;
  }
  const bool any = std::ranges::any_of(json["rows"], [](const ResultJson& row) { return row["problem"].is_null(); });
  if (!any) {
    throw io::InputError({.file = o.imu.string(),
                          .problem = "no sensor can be calibrated: " + problem,
                          .expected = "poses and readings of one motion, with turns about all axes"});
  }
  if (!json_file.empty()) io::write_whole_file(json_file, io::json_text(json));
  return done;
}

std::vector<CalibrationMethod> methods_of(const Words& words) {
  std::vector<CalibrationMethod> methods;
  for (const std::string& word : words) {
    if (word == "differentiating") {
      methods.push_back(CalibrationMethod::differentiating);
    } else if (word == "integrating") {
      methods.push_back(CalibrationMethod::integrating);
    } else {
      refuse("--method", "is no method", word, "differentiating or integrating");
    }
  }
  return methods;
}

}  // namespace

void add_calibrate_command(CLI::App& app, int& exit_code) {
  struct Given {
    std::string poses, imu, json, prediction_ms = "100", longest_ms = "250";
    Words methods{"differentiating", "integrating"};
    bool separate = false, lenient = false;
  };
  CLI::App& calibrate_app = *app.add_subcommand("calibrate", "Find what sensors do not tell about themselves");
  calibrate_app.require_subcommand(1);
  CLI::App& inertial_app = *calibrate_app.add_subcommand(
      "inertial", "Orientation, biases, scales, places and time offset of inertial sensors, from any recording");
  const auto given = std::make_shared<Given>();
  inertial_app.add_option("--poses", given->poses, "The tracker's poses: TUM, EuRoC or CSV")
      ->required()
      ->type_name("FILE");
  inertial_app.add_option("--imu", given->imu, "CSV with t, gx, gy, gz, ax, ay, az: rad/s and m/s2")
      ->required()
      ->type_name("FILE");
  add_words(inertial_app, "--method", given->methods, "differentiating, integrating, or both");
  inertial_app.add_flag("--separate", given->separate, "Three accelerometers, each at a place of its own, not a triad");
  inertial_app.add_option("--prediction-ms", given->prediction_ms, "Time over which readings are integrated (100)");
  inertial_app.add_option("--longest-offset-ms", given->longest_ms, "Time offsets are sought within this (250)");
  inertial_app.add_flag("--lenient", given->lenient, "Drop and count bad rows instead of stopping");
  add_json(inertial_app, given->json);
  inertial_app.footer("Example:\n  swimlab calibrate inertial --poses head.tum --imu imu.csv --json calibration.json");
  inertial_app.callback([given, &exit_code] {
    CalibrateOptions o;
    o.poses = given->poses;
    o.imu = given->imu;
    o.json = given->json;
    o.lenient = given->lenient;
    o.methods = methods_of(given->methods);
    o.settings.accelerometer.separate = given->separate;
    o.settings.prediction_s =
        1e-3 * number_of("--prediction-ms", given->prediction_ms, 10.0, 1000.0, "milliseconds from 10 to 1000");
    o.settings.longest_offset_s =
        1e-3 * number_of("--longest-offset-ms", given->longest_ms, 1.0, 10000.0, "milliseconds from 1 to 10000");
    exit_code = calibrate(o);
  });
}

}  // namespace swimlab
