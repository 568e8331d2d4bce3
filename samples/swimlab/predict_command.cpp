/// swimlab predict: how far predictors are off on a recording (001's figure 6).
#include <cstdio>

#include <holdfast/io/input_error.hpp>
#include <holdfast/io/results.hpp>
#include <holdfast/io/trajectory.hpp>
#include <holdfast/optics/hmd.hpp>
#include <holdfast/prediction/evaluation.hpp>

#include "exit_code.hpp"
#include "options.hpp"
#include "output_folder.hpp"

namespace swimlab {

using namespace holdfast;
using io::ResultJson;

namespace {

constexpr std::array later_predictors{"constant_acceleration", "gyro", "kalman_inertial"};

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

ResultJson block_json(double interval_ms, const PredictorEvaluation& evaluation, const PoseNoise& noise) {
  ResultJson json;
  json["schema"] = "holdfast/predict/1";
  json["interval_ms"] = interval_ms;
  json["rows"] = ResultJson::array();
  for (const PredictorRow& row : evaluation.rows) {
    json["rows"].push_back({{"predictor", row.predictor},
                            {"angle_deg", summary_json(row.angle_deg)},
                            {"position_mm", summary_json(row.position_mm)},
                            {"screen_px", summary_json(screen_error(row))},
                            {"jitter_arcmin", io::number_or_null(row.jitter_arcmin)}});
  }
  json["samples"] = evaluation.rows.empty() ? 0 : evaluation.rows.front().errors.size();
  json["skipped"] = evaluation.skipped;
  json["kalman_noise"] = {{"position_mm", 1e3 * noise.position_m},
                          {"orientation_deg", radians(noise.orientation_rad).degrees()}};
  json["not_available_yet"] = later_predictors;
  return json;
}

void print_block(const ResultJson& block) {
  std::printf("\n%g ms ahead, %zu predictions (%zu samples skipped)\n", block["interval_ms"].get<double>(),
              block["samples"].get<std::size_t>(), block["skipped"].get<std::size_t>());
  std::printf("  %-18s %27s %27s %27s %8s\n", "", "angle deg", "position mm", "screen px", "jitter");
  std::printf("  %-18s %9s%9s%9s %9s%9s%9s %9s%9s%9s %8s\n", "predictor", "mean", "p95", "peak", "mean", "p95", "peak",
              "mean", "p95", "peak", "arcmin");
  for (const ResultJson& row : block["rows"]) {
    std::printf("  %-18s", row["predictor"].get<std::string>().c_str());
    for (const char* key : {"angle_deg", "position_mm", "screen_px"}) {
      std::printf(" ");
      for (const char* of : {"mean", "p95", "peak"}) std::printf(" %8.3f", row[key][of].get<double>());
    }
    const ResultJson& jitter = row["jitter_arcmin"];
    if (jitter.is_null()) {
      std::printf(" %8s\n", "-");
    } else {
      std::printf(" %8.2f\n", jitter.get<double>());
    }
  }
}

}  // namespace

int predict(const PredictOptions& options) {
  if (!options.imu.empty()) {
    throw io::InputError({.key = "--imu",
                          .problem = "inertial predictors are not available yet",
                          .value = options.imu.string(),
                          .expected = "no --imu: none, constant_velocity and kalman need poses alone"});
  }
  const std::filesystem::path json_file = checked_json_file(options.json);
  const io::TrajectoryFile recording =
      io::read_trajectory(options.trajectory, options.lenient ? io::ReadMode::lenient : io::ReadMode::strict);
  std::printf("%s: %s", options.trajectory.string().c_str(), io::describe(recording.report).c_str());
  std::vector<ResultJson> blocks;
  for (const double interval_ms : options.intervals_ms) {
    EvaluationSettings settings;
    settings.interval = from_milliseconds(interval_ms);
    settings.filter.noise = options.noise;
    const PredictorEvaluation evaluation = evaluate_predictors(recording.samples, settings);
    if (evaluation.rows.empty() || evaluation.rows.front().errors.empty()) {
      throw io::InputError({.file = options.trajectory.string(),
                            .problem = "too short, or too full of gaps, to predict over " +
                                       std::to_string(std::lround(interval_ms)) + " ms",
                            .expected = "a recording that lasts longer than the interval"});
    }
    blocks.push_back(block_json(interval_ms, evaluation, settings.filter.noise));
    print_block(blocks.back());
  }
  std::printf("\nnot available yet:");
  for (const char* name : later_predictors) std::printf(" %s", name);
  std::printf("\nscreen px: a point 1 m ahead, in a picture of 1280 pixels over 60 degrees\n");
  std::printf("kalman: takes the poses for noisy by %.3g mm and %.3g deg (--noise-mm, --noise-deg)\n",
              1e3 * options.noise.position_m, radians(options.noise.orientation_rad).degrees());
  if (json_file.empty()) return done;
  // One interval: the contract's object. Several: the first one's, with all of them under "intervals".
  ResultJson json = blocks.front();
  if (blocks.size() > 1) json["intervals"] = blocks;
  io::write_whole_file(json_file, io::json_text(json));
  return done;
}

}  // namespace swimlab
