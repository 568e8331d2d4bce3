#include <doctest/doctest.h>

#include <holdfast/motion/generators.hpp>
#include <holdfast/motion/sampled_trajectory.hpp>

#include "motion/motion_checks.hpp"

using namespace holdfast;

TEST_CASE("between samples the path is straight and turns at a constant rate, and the rates say so") {
  const Rigid a(so3::exp<double>(Vector3(0.1, 0.2, -0.3)), Vector3(1, 0, 0));
  const Rigid step(so3::exp<double>(Vector3(0.0, 0.5, 0.1)), Vector3::Zero());
  const Rigid b(a.q() * step.q(), Vector3(1.5, 0, -1));
  const SampledTrajectory motion({{time_at(1.0), a}, {time_at(1.5), b}, {time_at(2.0), a}});
  const MotionState s = motion.at(time_at(1.25));
  CHECK((s.X_WB.p() - Vector3(1.25, 0, -0.5)).norm() < 1e-14);
  CHECK((s.v_WB - Vector3(1, 0, -2)).norm() < 1e-14);
  CHECK((s.w_WB_B - Vector3(0.0, 1.0, 0.2)).norm() < 1e-14);
  CHECK(s.a_WB.norm() == 0.0);
  CHECK(s.alpha_WB_B.norm() == 0.0);
  // Exact path, so only rounding of poses over 2 ms is left.
  check_derivatives(motion, time_at(1.3), std::chrono::milliseconds(1), 1e-11);
  CHECK((motion.at(time_at(1.75)).w_WB_B + motion.at(time_at(1.25)).w_WB_B).norm() < 1e-14);
}

TEST_CASE("samples are met exactly and times outside give the ends") {
  const auto m4 = make_motion("M4", 1);
  const SampledTrajectory motion(sample(*m4, std::chrono::milliseconds(50)));
  for (const TimedPose& pose : motion.samples()) {
    CHECK((motion.at(pose.t).X_WB.p() - pose.X_WB.p()).norm() < 1e-14);
    CHECK(so3::angle_between<double>(motion.at(pose.t).X_WB.q(), pose.X_WB.q()) < 1e-14);
  }
  CHECK(motion.at(time_at(-3)).t == motion.begin());
  CHECK(motion.at(time_at(1000)).X_WB.p() == motion.samples().back().X_WB.p());
  CHECK(motion.samples().size() == 201);  // 10 s at 50 ms, both ends
}

TEST_CASE("a single sample is a still head") {
  const SampledTrajectory motion({{time_at(2.0), Rigid::translation(Vector3(1, 2, 3))}});
  CHECK(motion.at(time_at(5.0)).X_WB.p() == Vector3(1, 2, 3));
  CHECK(motion.at(time_at(5.0)).v_WB.norm() == 0.0);
}

TEST_CASE("the median interval withstands gaps") {
  std::vector<TimedPose> poses;
  for (double t : {0.0, 0.01, 0.02, 3.0, 3.01, 3.02}) poses.push_back({time_at(t), Rigid()});
  CHECK(median_interval(poses) == std::chrono::milliseconds(10));
  CHECK(median_interval(std::span(poses).first(1)) == Duration(0));
}
