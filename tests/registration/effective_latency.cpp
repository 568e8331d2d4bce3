#include <filesystem>
#include <random>

#include <doctest/doctest.h>

#include <holdfast/io/trajectory.hpp>
#include <holdfast/motion/generators.hpp>
#include <holdfast/registration/effective_latency.hpp>

#include "head_recording.hpp"

using namespace holdfast;
using test::head_recording;

namespace {

/// What an observer in another world, with its origin elsewhere on the body, sees `lag` late at its own rate.
std::vector<TimedPose> observe(const Motion& motion, Duration lag, double rate_hz, const Rigid& X_OW,
                               const Rigid& X_BoB) {
  std::vector<TimedPose> samples;
  const Duration interval = from_seconds(1.0 / rate_hz);
  for (HostTime t = motion.begin() + std::max(lag, Duration{0}); t <= motion.end() + std::min(lag, Duration{0});
       t += interval) {
    samples.push_back({t, X_OW * motion.at(t - lag).X_WB * X_BoB.inverse()});
  }
  return samples;
}

const Rigid some_world(so3::exp<double>(Vector3(0.4, -1.9, 0.7)), Vector3(1.2, -0.5, 3.0));
const Rigid some_body(so3::exp<double>(Vector3(-0.3, 0.2, 1.1)), Vector3(0.05, 0.11, -0.08));

std::filesystem::path recording(const char* name) {
  return std::filesystem::path(HOLDFAST_RECORDINGS) / name;
}

}  // namespace

TEST_CASE(
    "latency injected from 0 to 100 ms is recovered within 0.1 ms, in other frames and at other rates (value 4)") {
  const auto motion = make_motion("M6", 3);
  const std::vector<TimedPose> reference = observe(*motion, Duration{0}, 60.0, Rigid(), Rigid());
  for (const double ms : {0.0, 5.0, 37.3, 62.5, 100.0}) {
    const auto observed = observe(*motion, from_milliseconds(ms), 90.0, some_world, some_body);
    const LatencyResult r = estimate_latency(reference, observed);
    CHECK(r.status == LatencyStatus::ok);
    CHECK(std::abs(r.effective_latency_ms - ms) < 0.1);
    CHECK(r.uncertainty_ms < 0.1);
    CHECK(r.angle_deg.rms < 1e-3);
    CHECK(r.position_mm.rms < 0.01);
    // The frames' relation is found: X_R_Br = X_RO X_O_Bo X_BoBr.
    CHECK(so3::angle_between<double>((some_world * r.X_RO).q(), Quaternion::Identity()) < 1e-4);
    CHECK((some_body.inverse() * r.X_BoBr).p().norm() < 1e-3);
    if (ms > 50.0) CHECK(r.unshifted_angle_deg_rms > 0.5);
  }
}

TEST_CASE("a display that leads has a negative effective latency, and exchanging the two changes the sign") {
  const auto motion = make_motion("M5", 2);
  const auto reference = observe(*motion, Duration{0}, 90.0, Rigid(), Rigid());
  const auto leading = observe(*motion, from_milliseconds(-18.4), 72.0, some_world, some_body);
  CHECK(std::abs(estimate_latency(reference, leading).effective_latency_ms + 18.4) < 0.1);
  CHECK(std::abs(estimate_latency(leading, reference).effective_latency_ms - 18.4) < 0.1);
}

TEST_CASE("gaps and outliers do not move the latency") {
  const auto motion = make_motion("M4", 5);
  const auto reference = observe(*motion, Duration{0}, 100.0, Rigid(), Rigid());
  auto observed = observe(*motion, from_milliseconds(23.7), 60.0, some_world, some_body);
  std::erase_if(observed, [](const TimedPose& p) {
    const double t = to_seconds(p.t.time_since_epoch());
    return (t > 2.0 && t < 2.9) || (t > 6.0 && t < 6.3);
  });
  for (std::size_t i = 10; i < observed.size(); i += 40) {
    observed[i].X_WB = observed[i].X_WB * Rigid(so3::exp<double>(Vector3(0.2, 0, 0)), Vector3(0, 0.1, 0));
  }
  const LatencyResult r = estimate_latency(reference, observed);
  CHECK(r.status == LatencyStatus::ok);
  // The spline rings near an outlier, so this is not exact; outliers of 11 deg on 2.5 % of the poses stay below 0.3 ms.
  CHECK(std::abs(r.effective_latency_ms - 23.7) < 0.3);
}

TEST_CASE("the uncertainty is of the size of the error that noise makes") {
  const auto motion = make_motion("M4", 1);
  const auto reference = observe(*motion, Duration{0}, 60.0, Rigid(), Rigid());
  std::mt19937_64 random(4);
  std::normal_distribution<double> normal;
  double error_squares = 0.0, claimed_squares = 0.0;
  constexpr int runs = 8;
  for (int run = 0; run < runs; ++run) {
    auto observed = observe(*motion, from_milliseconds(40.0), 50.0, Rigid(), Rigid());
    for (TimedPose& pose : observed) {
      const auto noise = [&](double size) {
        return Vector3(size * normal(random), size * normal(random), size * normal(random));
      };
      pose.X_WB = Rigid(pose.X_WB.q() * so3::exp<double>(noise(0.01)), pose.X_WB.p() + noise(0.005));
    }
    LatencyOptions options;
    options.frames = FrameRelation::same;
    const LatencyResult r = estimate_latency(reference, observed, options);
    error_squares += std::pow(r.effective_latency_ms - 40.0, 2);
    claimed_squares += std::pow(r.uncertainty_ms, 2);
  }
  const double ratio = std::sqrt(error_squares / claimed_squares);
  // Eight runs know their RMS to 25 %, five blocks an uncertainty to 35 %: within a factor of 2.5.
  CHECK(ratio > 0.4);
  CHECK(ratio < 2.5);
}

TEST_CASE("what cannot be told is said") {
  const auto still = make_motion("M0", 1);
  const auto poses = observe(*still, Duration{0}, 60.0, Rigid(), Rigid());
  CHECK(estimate_latency(poses, poses).status == LatencyStatus::no_motion);
  CHECK(estimate_latency(std::span(poses).first(10), poses).status == LatencyStatus::too_few_samples);

  // Turning about one axis only leaves the frames undetermined: the poses are compared as they are.
  const auto yaw = make_motion("M1", 1);
  const auto reference = observe(*yaw, Duration{0}, 90.0, Rigid(), Rigid());
  const auto observed = observe(*yaw, from_milliseconds(20.0), 90.0, Rigid(), Rigid());
  const LatencyResult r = estimate_latency(reference, observed);
  CHECK(r.status == LatencyStatus::frames_undetermined);
  CHECK(std::abs(r.effective_latency_ms - 20.0) < 0.1);

  // No overlap in time.
  auto later = observed;
  for (TimedPose& pose : later) pose.t += std::chrono::seconds(100);
  CHECK_FALSE(estimate_latency(reference, later).has_latency());
}

TEST_CASE("a recording of a head shifted by 37.3 ms answers 37.3 ms") {
  const auto samples = head_recording();
  if (samples.empty()) {
    MESSAGE("skipped: recordings not present");
    return;
  }
  const SplineTrajectory head(samples);
  // Resampled at 72 Hz, so that no two samples of the two are the same.
  const auto observed = observe(head, from_milliseconds(37.3), 72.0, some_world, some_body);
  const LatencyResult r = estimate_latency(samples, observed);
  CHECK(r.status == LatencyStatus::ok);
  CHECK(std::abs(r.effective_latency_ms - 37.3) < 0.1);
  CHECK(r.angle_deg.rms < 0.02);
}

TEST_CASE("a headset against the robot that moved it: aligned as well as its publishers aligned it") {
  if (!std::filesystem::exists(recording("head/quest2_traj1_headset_72hz.tum"))) {
    MESSAGE("skipped: recordings not present");
    return;
  }
  const auto headset = io::read_trajectory(recording("head/quest2_traj1_headset_72hz.tum")).samples;
  const auto robot = io::read_trajectory(recording("head/quest2_traj1_robot_truth_30hz.tum")).samples;
  const LatencyResult r = estimate_latency(robot, headset);
  MESSAGE("effective latency " << r.effective_latency_ms << " +- " << r.uncertainty_ms << " ms, angle rms "
                               << r.angle_deg.rms << " p95 " << r.angle_deg.p95 << " peak " << r.angle_deg.peak
                               << " deg, position rms " << r.position_mm.rms << " p95 " << r.position_mm.p95 << " peak "
                               << r.position_mm.peak << " mm; unshifted " << r.unshifted_angle_deg_rms << " deg "
                               << r.unshifted_position_mm_rms << " mm; pairs " << r.pairs);
  CHECK(r.status == LatencyStatus::ok);
  CHECK(std::abs(r.effective_latency_ms) < 60.0);  // the headset predicts, so it is near zero and may be negative
  CHECK(r.uncertainty_ms < 2.0);
  CHECK(r.position_mm.rms < 2.6);  // the data's README says 2.3 mm after alignment
}
