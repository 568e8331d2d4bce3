#include <filesystem>
#include <random>

#include <doctest/doctest.h>

#include <holdfast/prediction/evaluation.hpp>
#include <holdfast/registration/inertial_recording.hpp>

#include "head_recording.hpp"

using namespace holdfast;
using test::head_recording;

namespace {

PredictorEvaluation evaluated(const std::vector<TimedPose>& poses, const std::vector<TimedPose>& truth,
                              const std::vector<InertialReading>& readings, const PoseNoise& noise, const char* what) {
  EvaluationSettings settings;  // 60 ms
  settings.filter.noise = noise;
  settings.truth_noise = PoseFilterSettings().noise;  // the recording's own
  settings.inertial = readings;
  const PredictorEvaluation e = evaluate_predictors(poses, truth, settings);
  for (const PredictorRow& row : e.rows) {
    MESSAGE(std::string(what) << std::string(row.predictor) << ": " << row.angle_deg.mean << " deg, "
                              << row.position_mm.mean << " mm, " << row.inside_95_pct.value_or(0.0) << " % inside");
  }
  return e;
}

}  // namespace

TEST_CASE("the head recording at 60 ms: inertial sensors help, most where poses are noisy and slow") {
  const auto samples = head_recording();
  if (samples.empty()) {
    MESSAGE("skipped: no recordings at " << HOLDFAST_RECORDINGS);
    return;
  }
  const auto readings = simulate_inertial(samples);
  const PredictorEvaluation good = evaluated(samples, samples, readings, PoseFilterSettings().noise, "");
  const PredictorRow &none = good.rows[0], &kalman = good.rows[2], &inertial = good.rows.back();
  CHECK(4.0 * inertial.angle_deg.mean < none.angle_deg.mean);
  CHECK(1.4 * inertial.angle_deg.mean < kalman.angle_deg.mean);
  CHECK(5.0 * inertial.position_mm.mean < none.position_mm.mean);
  CHECK(2.5 * inertial.position_mm.mean < kalman.position_mm.mean);
  CHECK(inertial.inside_95_pct.value() > 90.0);
  CHECK(inertial.inside_95_pct.value() < 98.0);
  // Biases of the unit are found without being told.
  CHECK((good.sensors.bias.rate_B - recorded_head_unit().gyro.bias).norm() < 3e-3);

  const PoseNoise noise{2e-3, degrees(0.1).radians()};
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  const auto three = [&] { return Vector3(normal(random), normal(random), normal(random)); };
  auto poses = thinned(samples, 62.5);
  for (TimedPose& pose : poses) {
    const Quaternion q = pose.X_WB.q() * so3::exp<double>(noise.orientation_rad * three());
    pose.X_WB = Rigid(q, pose.X_WB.p() + noise.position_m * three());
  }
  const PredictorEvaluation bad = evaluated(poses, samples, readings, noise, "noisy and slow: ");
  CHECK(4.0 * bad.rows.back().angle_deg.mean < bad.rows[0].angle_deg.mean);
  CHECK(2.0 * bad.rows.back().angle_deg.mean < bad.rows[2].angle_deg.mean);
  CHECK(2.5 * bad.rows.back().position_mm.mean < bad.rows[2].position_mm.mean);
  CHECK(bad.rows.back().inside_95_pct.value() > 90.0);
  CHECK(bad.rows.back().inside_95_pct.value() < 98.0);
}

TEST_CASE("predicted covariances are honest on slow and noisy recordings, too, at short intervals") {
  for (const char* name : {"head/quest2_traj1_robot_truth_30hz.tum", "head/quest2_traj1_headset_72hz.tum"}) {
    const std::filesystem::path file = std::filesystem::path(HOLDFAST_RECORDINGS) / name;
    if (!std::filesystem::exists(file)) {
      MESSAGE("skipped: no recording at " << file.string());
      continue;
    }
    const auto samples = io::read_trajectory(file).samples;
    const auto readings = simulate_inertial(samples);
    for (const int ms : {20, 40}) {
      EvaluationSettings settings;
      settings.interval = std::chrono::milliseconds(ms);
      settings.inertial = readings;
      const PredictorEvaluation e = evaluate_predictors(samples, settings);
      const double inside = e.rows.back().inside_95_pct.value();
      MESSAGE(std::string(name) << ", " << ms << " ms: " << inside << " % inside");
      CHECK(inside > 90.0);
      CHECK(inside < 98.0);
    }
  }
}
