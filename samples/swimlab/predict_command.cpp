/// swimlab predict: how far predictors are off on a recording (001's figures 6 and 7).
#include <algorithm>
#include <array>
#include <cstdio>
#include <optional>

#include <holdfast/io/inertial_files.hpp>
#include <holdfast/io/input_error.hpp>
#include <holdfast/io/result_json.hpp>
#include <holdfast/io/trajectory.hpp>
#include <holdfast/optics/hmd.hpp>
#include <holdfast/prediction/evaluation.hpp>
#include <holdfast/registration/inertial_recording.hpp>

#include "exit_code.hpp"
#include "options.hpp"
#include "output_folder.hpp"
#include "predict_page.hpp"
#include "progress.hpp"
#include "report_page.hpp"
#include "text.hpp"

namespace swimlab {

using namespace holdfast;
using io::ResultJson;

namespace {

/// Not among the contract's rows.
constexpr std::string_view further_predictor = "gyro_acceleration";

ResultJson summary_json(const ErrorStatistics& s) {
  return {
      {"mean", io::number_or_null(s.mean)}, {"p95", io::number_or_null(s.p95)}, {"peak", io::number_or_null(s.peak)}};
}

/// Where a point 1 m straight ahead of the true left eye is drawn by the predicted one, against where it is: px of the
/// default headset (1280 pixels over 60 degrees). A point that leaves the half space ahead is not counted.
ErrorStatistics screen_error(const PredictorRow& row) {
  const HmdModel hmd = default_hmd();
  const EyeModel& eye = hmd.left;
  const Vector3 p_E(0.0, 0.0, -1.0);
  const Vector2 at_truth = *project(eye, p_E);
  std::vector<double> errors;
  for (const PredictionError& error : row.errors) {
    const Rigid X_EpE = eye.X_HE.inverse() * error.X_WB_predicted.inverse() * error.X_WB_true * eye.X_HE;
    const auto drawn = project(eye, X_EpE * p_E);
    if (drawn) errors.push_back((*drawn - at_truth).norm());
  }
  return statistics_of(std::move(errors));
}

ResultJson vector_json(const Vector3& v) {
  return {v.x(), v.y(), v.z()};
}

/// What the inertial filter found out about the sensors.
ResultJson sensors_json(const InertialState& sensors) {
  return {{"time_offset_ms", 1e3 * sensors.time_offset_s},
          {"gyro_bias_rad_s", vector_json(sensors.bias.rate_B)},
          {"accelerometer_bias_m_s2", vector_json(sensors.bias.force_B)},
          {"gravity_m_s2", vector_json(sensors.gravity_W)},
          {"lever_mm", vector_json(1e3 * sensors.lever_B)}};
}

/// Of rad^2/Hz, in arcmin^2/Hz.
ResultJson spectrum_json(const Spectrum& spectrum) {
  ResultJson json = ResultJson::array();
  const double arcmin = radians(1.0).arcmin();
  for (const double power : spectrum.power) json.push_back(io::number_or_null(arcmin * arcmin * power));
  return json;
}

ResultJson block_json(double interval_ms, const PredictorEvaluation& evaluation, const PoseNoise& noise,
                      const std::string& inertial) {
  ResultJson json;
  json["schema"] = "holdfast/predict/1";
  json["interval_ms"] = interval_ms;
  json["rows"] = ResultJson::array();
  json["further_rows"] = ResultJson::array();
  for (const PredictorRow& row : evaluation.rows) {
    json[row.predictor == further_predictor ? "further_rows" : "rows"].push_back(
        {{"predictor", row.predictor},
         {"angle_deg", summary_json(row.angle_deg)},
         {"position_mm", summary_json(row.position_mm)},
         {"screen_px", summary_json(screen_error(row))},
         {"jitter_arcmin", io::number_or_null(row.jitter_arcmin)},
         {"inside_95_pct", io::number_or_null(row.inside_95_pct)},
         {"spectrum_arcmin2_per_hz", spectrum_json(row.angle_spectrum)}});
  }
  json["spectrum_hz"] =
      evaluation.rows.empty() ? std::vector<double>() : evaluation.rows.front().angle_spectrum.frequency_hz;
  json["samples"] = evaluation.rows.empty() ? 0 : evaluation.rows.front().errors.size();
  json["skipped"] = evaluation.skipped;
  json["kalman_noise"] = {{"position_mm", 1e3 * noise.position_m},
                          {"orientation_deg", radians(noise.orientation_rad).degrees()}};
  json["inertial"] = {
      {"readings", inertial}, {"predicted_by_poses", evaluation.by_poses}, {"found", sensors_json(evaluation.sensors)}};
  return json;
}

void print_rows(const ResultJson& rows) {
  for (const ResultJson& row : rows) {
    std::printf("  %-21s", row["predictor"].get<std::string>().c_str());
    for (const char* key : {"angle_deg", "position_mm", "screen_px"}) {
      std::printf(" ");
      for (const char* of : {"mean", "p95", "peak"}) std::printf(" %8.3f", row[key][of].get<double>());
    }
    for (const char* key : {"jitter_arcmin", "inside_95_pct"}) {
      if (row[key].is_null()) {
        std::printf(" %8s", "-");
      } else {
        std::printf(" %8.2f", row[key].get<double>());
      }
    }
    std::printf("\n");
  }
}

void print_block(const ResultJson& block) {
  std::printf("\n%g ms ahead, %zu predictions (%zu samples skipped)\n", block["interval_ms"].get<double>(),
              block["samples"].get<std::size_t>(), block["skipped"].get<std::size_t>());
  std::printf("  %-21s %27s %27s %27s %8s %8s\n", "", "angle deg", "position mm", "screen px", "jitter", "inside");
  std::printf("  %-21s %9s%9s%9s %9s%9s%9s %9s%9s%9s %8s %8s\n", "predictor", "mean", "p95", "peak", "mean", "p95",
              "peak", "mean", "p95", "peak", "arcmin", "95%");
  print_rows(block["rows"]);
  print_rows(block["further_rows"]);
}

void print_sensors(const ResultJson& inertial) {
  const ResultJson& found = inertial["found"];
  std::printf("\nkalman_inertial found: readings %.2f ms after the poses' clock",
              found["time_offset_ms"].get<double>());
  const auto print = [&](const char* what, const char* key) {
    std::printf("; %s (%.4g, %.4g, %.4g)", what, found[key][0].get<double>(), found[key][1].get<double>(),
                found[key][2].get<double>());
  };
  print("gyro bias rad/s", "gyro_bias_rad_s");
  print("accelerometer bias m/s2", "accelerometer_bias_m_s2");
  print("gravity m/s2", "gravity_m_s2");
  print("lever mm", "lever_mm");
  const auto by_poses = inertial["predicted_by_poses"].get<std::size_t>();
  if (by_poses > 0) std::printf("; %zu predictions from the poses alone, for want of a sensor to believe", by_poses);
  std::printf("\n");
}

/// Throws when no reading was made while poses were.
void check_overlap(const std::vector<InertialReading>& readings, const std::vector<TimedPose>& poses,
                   const PredictOptions& options) {
  if (readings.empty() || poses.empty()) return;
  const auto seconds = [](HostTime t) { return to_seconds(t.time_since_epoch()); };
  const auto [first, last] = std::ranges::minmax_element(readings, {}, &InertialReading::t);
  if (first->t <= poses.back().t && last->t >= poses.front().t) return;
  std::array<char, 200> text;
  std::snprintf(text.data(), text.size(), "its readings, %.3f to %.3f s, do not overlap with the poses, %.3f to %.3f s",
                seconds(first->t), seconds(last->t), seconds(poses.front().t), seconds(poses.back().t));
  throw io::InputError({.file = options.imu.string(),
                        .problem = text.data(),
                        .expected = "readings stamped by the clock of " + options.trajectory.string()});
}

OutputKind predict_output() {
  return {.command = "swimlab predict",
          .summary = "predict.json",
          .schema = "\"holdfast/predict/1\"",
          .files = {"report.html"}};
}

/// What is evaluated: which poses are measured, what they are compared with, and the readings.
struct Recording {
  std::vector<TimedPose> poses, truth;
  std::vector<InertialReading> inertial;
  std::string readings;  ///< in words

  [[nodiscard]] double poses_hz() const { return poses.size() > 1 ? 1.0 / to_seconds(median_interval(poses)) : 0.0; }
};

Recording recording_of(const PredictOptions& options) {
  const io::ReadMode mode = options.lenient ? io::ReadMode::lenient : io::ReadMode::strict;
  io::TrajectoryFile file = io::read_trajectory(options.trajectory, mode);
  std::printf("%s: %s", options.trajectory.string().c_str(), io::describe(file.report).c_str());
  Recording recording;
  recording.truth = std::move(file.samples);
  if (!options.imu.empty()) {
    io::InertialFile imu = io::read_inertial(options.imu, mode);
    recording.inertial = std::move(imu.readings);
    recording.readings = options.imu.string();
    if (imu.dropped > 0) recording.readings += ", " + std::to_string(imu.dropped) + " bad rows dropped";
  } else {
    if (recording.truth.size() > 1) recording.inertial = simulate_inertial(recording.truth);
    recording.readings = "simulated along the recording below 10 Hz: 500 Hz, noise 0.005 rad/s and 0.01 m/s2 a reading";
  }
  check_overlap(recording.inertial, recording.truth, options);
  std::printf("inertial readings: %s\n", recording.readings.c_str());
  recording.poses =
      options.pose_hz > 0.0 && recording.truth.size() > 1 ? thinned(recording.truth, options.pose_hz) : recording.truth;
  if (options.pose_hz > 0.0)
    std::printf("measured: every so many-th pose, %.4g a second (asked for %g)\n", recording.poses_hz(),
                options.pose_hz);
  return recording;
}

/// Nothing when the recording is too short for the interval.
std::optional<ResultJson> evaluated(const Recording& recording, double interval_ms, const PredictOptions& options) {
  EvaluationSettings settings;
  settings.interval = from_milliseconds(interval_ms);
  settings.filter.noise = options.noise;
  settings.inertial = recording.inertial;
  const PredictorEvaluation evaluation = evaluate_predictors(recording.poses, recording.truth, settings);
  if (evaluation.rows.empty() || evaluation.rows.front().errors.empty()) return std::nullopt;
  ResultJson json = block_json(interval_ms, evaluation, options.noise, recording.readings);
  json["poses_hz"] = recording.poses_hz();
  return json;
}

/// For the charts: intervals up to 200 ms, as in 001's figure 7.
std::vector<ResultJson> swept(const Recording& recording, const PredictOptions& options) {
  constexpr std::array intervals_ms{10.0, 20.0, 30.0, 40.0, 60.0, 80.0, 100.0, 125.0, 150.0, 175.0, 200.0};
  Progress progress("predict", intervals_ms.size());
  std::vector<ResultJson> sweep;
  for (std::size_t i = 0; i < intervals_ms.size(); ++i) {
    progress.show(i, text_of("%g ms ahead", intervals_ms[i]));
    if (auto block = evaluated(recording, intervals_ms[i], options)) sweep.push_back(std::move(*block));
  }
  return sweep;
}

/// The sweep as the JSON has it: without the spectra.
ResultJson sweep_json(std::vector<ResultJson> sweep) {
  ResultJson json = ResultJson::array();
  for (ResultJson& block : sweep) {
    for (const char* rows : {"rows", "further_rows"}) {
      for (ResultJson& row : block[rows]) row.erase("spectrum_arcmin2_per_hz");
    }
    json.push_back(
        {{"interval_ms", block["interval_ms"]}, {"rows", block["rows"]}, {"further_rows", block["further_rows"]}});
  }
  return json;
}

}  // namespace

int predict(const PredictOptions& options) {
  const std::filesystem::path json_file = checked_json_file(options.json);
  std::optional<OutputFolder> folder;
  if (!options.out.empty()) folder.emplace(options.out, predict_output());
  const Recording recording = recording_of(options);
  std::vector<ResultJson> blocks;
  for (const double interval_ms : options.intervals_ms) {
    auto block = evaluated(recording, interval_ms, options);
    if (!block) {
      throw io::InputError({.file = options.trajectory.string(),
                            .problem = "too short, or too full of gaps, to predict over " +
                                       std::to_string(std::lround(interval_ms)) + " ms",
                            .expected = "a recording that lasts longer than the interval"});
    }
    blocks.push_back(std::move(*block));
    print_block(blocks.back());
  }
  print_sensors(blocks.back()["inertial"]);
  std::printf("screen px: a point 1 m ahead, in a picture of 1280 pixels over 60 degrees\n");
  std::printf("kalman: takes the poses for noisy by %.3g mm and %.3g deg (--noise-mm, --noise-deg)\n",
              1e3 * options.noise.position_m, radians(options.noise.orientation_rad).degrees());
  // One interval: the contract's object. Several: the first one's, with all of them under "intervals".
  ResultJson json = blocks.front();
  if (blocks.size() > 1) json["intervals"] = blocks;
  if (folder) {
    const std::vector<ResultJson> sweep = swept(recording, options);
    const PredictPageFacts facts{options.trajectory.filename().string(), recording.readings, options.command};
    io::write_whole_file(folder->path() / "report.html", report_page(predict_page(facts, blocks.front(), sweep)));
    json["against_interval"] = sweep_json(sweep);
    io::write_whole_file(folder->path() / "predict.json", io::json_text(json));
    folder->commit();
    std::printf("report: %s\n", (folder->target() / "report.html").string().c_str());
  }
  if (!json_file.empty()) io::write_whole_file(json_file, io::json_text(json));
  return done;
}

}  // namespace swimlab
