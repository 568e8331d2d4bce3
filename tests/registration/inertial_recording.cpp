#include <filesystem>
#include <memory>
#include <random>

#include <doctest/doctest.h>

#include <holdfast/geometry/cholesky.hpp>
#include <holdfast/motion/low_pass.hpp>
#include <holdfast/motion/spline_trajectory.hpp>
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
  CHECK(5.0 * bad.rows.back().position_mm.mean < bad.rows[0].position_mm.mean);
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

namespace {

/// % of predictions over `interval` inside the region that should hold 95 %, of the error against the exact truth.
double inside_exactly(const Motion& truth, double gyro_noise, const PoseNoise& noise, Duration late,
                      Duration interval) {
  InertialUnit unit = recorded_head_unit();
  unit.gyro.noise_density = gyro_noise;
  const auto readings = inertial_stream(truth, unit);
  const auto head = std::make_unique<InertialPredictor>();
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const auto three = [&] { return Vector3(normal(random), normal(random), normal(random)); };
  std::size_t next = 0;
  int inside = 0, count = 0;
  for (HostTime t = truth.begin() + late; t + interval < truth.end(); t += std::chrono::microseconds(11111)) {
    for (; next < readings.size() && readings[next].t <= t; ++next) head->update(readings[next]);
    const Rigid X = truth.at(t - late).X_WB;
    const Quaternion q = X.q() * so3::exp<double>(noise.orientation_rad * three());
    head->update(TimedPose{t - late, Rigid(q, X.p() + noise.position_m * three())});
    if (t < truth.begin() + std::chrono::seconds(4)) continue;
    const InertialPrediction said = head->predict(t + interval);
    const Rigid is = truth.at(t + interval).X_WB;
    Vector6 error;
    error << is.p() - said.X_WB.p(), so3::log<double>(said.X_WB.q().conjugate() * is.q());
    Matrix6 L;
    inside += cholesky<6>(said.covariance, L) && squared_distance<6>(L, error) < 12.592 ? 1 : 0;
    ++count;
  }
  return 100.0 * inside / count;
}

}  // namespace

TEST_CASE("against the exact truth no covariance is too sure, whatever the noise and the poses' delay") {
  auto samples = head_recording();
  if (samples.empty()) {
    MESSAGE("skipped: no recordings at " << HOLDFAST_RECORDINGS);
    return;
  }
  samples.resize(std::min<std::size_t>(samples.size(), 3000));
  const SplineTrajectory truth(zero_phase_low_pass(samples, 10.0));
  for (const double gyro_noise : {5e-4, 1.5e-3}) {  // what the filter is told, and three times that
    for (const PoseNoise& noise : {PoseNoise{1e-4, 4e-4}, PoseNoise{1e-3, 2e-3}, PoseNoise{3e-3, 5e-3}}) {
      for (const int late_ms : {0, 40}) {
        for (const int ms : {20, 60}) {
          const double inside = inside_exactly(truth, gyro_noise, noise, std::chrono::milliseconds(late_ms),
                                               std::chrono::milliseconds(ms));
          MESSAGE("gyro " << gyro_noise << ", poses " << 1e3 * noise.position_m << " mm, " << late_ms << " ms late, "
                          << ms << " ms ahead: " << inside << " % inside");
          CHECK(inside > 90.0);
          CHECK(inside < 99.5);  // noise that is twenty times the error hides how large that is
        }
      }
    }
  }
}
