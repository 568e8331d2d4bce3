#include <algorithm>
#include <random>

#include <doctest/doctest.h>

#include <holdfast/motion/generators.hpp>
#include <holdfast/motion/spline_trajectory.hpp>

#include "motion/motion_checks.hpp"

using namespace holdfast;

namespace {

/// Samples of a motion at uneven times: `interval` with up to +-40 % of jitter.
std::vector<TimedPose> uneven_samples(const Motion& motion, double interval, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<TimedPose> poses;
  const double end = to_seconds(motion.duration());
  for (double t = 0.0; t < end; t += interval * (0.6 + 0.8 * static_cast<double>(random() >> 11) * 0x1p-53)) {
    poses.push_back({time_at(t), motion.at(time_at(t)).X_WB});
  }
  return poses;
}

struct Errors {
  double p = 0, v = 0, a = 0, q = 0, w = 0, alpha = 0;
};

Errors worst_errors(const Motion& truth, const Motion& spline) {
  Errors e;
  for (HostTime t = spline.begin(); t <= spline.end(); t += std::chrono::microseconds(3700)) {
    const MotionState a = truth.at(t), b = spline.at(t);
    e.p = std::max(e.p, (a.X_WB.p() - b.X_WB.p()).norm());
    e.v = std::max(e.v, (a.v_WB - b.v_WB).norm());
    e.a = std::max(e.a, (a.a_WB - b.a_WB).norm());
    e.q = std::max(e.q, so3::angle_between<double>(a.X_WB.q(), b.X_WB.q()));
    e.w = std::max(e.w, (a.w_WB_B - b.w_WB_B).norm());
    e.alpha = std::max(e.alpha, (a.alpha_WB_B - b.alpha_WB_B).norm());
  }
  return e;
}

}  // namespace

TEST_CASE("the spline meets its samples") {
  const auto poses = uneven_samples(*make_motion("M6", 1), 0.03, 5);
  const SplineTrajectory spline(poses);
  for (const TimedPose& pose : poses) {
    CHECK((spline.at(pose.t).X_WB.p() - pose.X_WB.p()).norm() < 1e-14);
    CHECK(so3::angle_between<double>(spline.at(pose.t).X_WB.q(), pose.X_WB.q()) < 1e-14);
  }
}

TEST_CASE("its derivatives are exact: they agree with central differences between knots") {
  const SplineTrajectory spline(uneven_samples(*make_motion("M6", 2), 0.05, 6));
  std::mt19937_64 random(3);
  for (int i = 0; i < 200; ++i) {
    const double t = 0.1 + 9.5 * static_cast<double>(random() >> 11) * 0x1p-53;
    CAPTURE(t);
    // Truncation is h^2/6 of the third derivative, which jumps at knots (there h/2 of the jump): below 1e-5 s * 100
    // rad/s^3.
    check_derivatives(spline, time_at(t), std::chrono::microseconds(20), 1.5e-3);
  }
}

TEST_CASE("it is twice continuously differentiable across knots, in position and orientation") {
  const auto poses = uneven_samples(*make_motion("M5", 2), 0.05, 7);
  const SplineTrajectory spline(poses);
  for (std::size_t i = 1; i + 1 < poses.size(); ++i) {
    const MotionState a = spline.at(poses[i].t - Duration(1000)), b = spline.at(poses[i].t + Duration(1000));
    // 2 us of third derivatives below 500 / s^3.
    CHECK((a.a_WB - b.a_WB).norm() < 1e-3);
    CHECK((a.alpha_WB_B - b.alpha_WB_B).norm() < 1e-3);
    CHECK((a.w_WB_B - b.w_WB_B).norm() < 1e-4);
  }
}

TEST_CASE("halving the interval cuts the error by about 16, also at the ends and with uneven times") {
  const auto truth = make_motion("M6", 3);
  const auto even = [&](double interval) {
    return worst_errors(*truth, SplineTrajectory(sample(*truth, from_seconds(interval))));
  };
  const Errors coarse = even(0.04), fine = even(0.02);
  CHECK(coarse.p / fine.p > 10.0);  // 16 in the limit; the ends are a little worse than the middle
  CHECK(coarse.q / fine.q > 10.0);
  const Errors uneven = worst_errors(*truth, SplineTrajectory(uneven_samples(*truth, 0.01, 8)));
  MESSAGE("uneven 100 Hz samples of M6: p " << uneven.p << " m, v " << uneven.v << ", a " << uneven.a << ", q "
                                            << uneven.q << " rad, w " << uneven.w << ", alpha " << uneven.alpha);
  // h^4/384 of a fourth derivative of about 100 /s^4, times 5 for the ends; 2, 3 orders less for v and a.
  CHECK(uneven.p < 1e-7);
  CHECK(uneven.q < 1e-6);
  CHECK(uneven.w < 1e-3);
  CHECK(uneven.alpha < 0.1);
}

TEST_CASE("a constant velocity and rate is reproduced, whatever the quaternions' signs") {
  std::vector<TimedPose> poses;
  const Vector3 v(0.3, -0.1, 0.2), w(0.4, 1.9, -0.3);
  for (int i = 0; i <= 100; ++i) {
    const double t = 0.01 * i;
    const Vector3 phi = w * t;
    Quaternion q = so3::exp<double>(phi);
    if (i % 3 == 0) q.coeffs() = -q.coeffs();
    poses.push_back({time_at(t), Rigid(q, v * t)});
  }
  const SplineTrajectory spline(poses);
  for (double t = 0.0; t < 1.0; t += 0.0031) {
    const MotionState s = spline.at(time_at(t));
    CHECK((s.v_WB - v).norm() < 1e-12);
    CHECK((s.w_WB_B - w).norm() < 1e-6);  // (w/2)^4 h^3: 1e-6
    CHECK(s.alpha_WB_B.norm() < 2e-3);    // (w/2)^4 h^2
  }
}

TEST_CASE("few samples: still, constant rate, parabola-like") {
  const Rigid a = Rigid::translation(Vector3(1, 0, 0));
  const Rigid b(so3::exp<double>(Vector3(0, 0.2, 0)), Vector3(2, 0, 0));
  const std::vector<TimedPose> one{{time_at(0), a}}, two{{time_at(0), a}, {time_at(1), b}},
      three{{time_at(0), a}, {time_at(1), b}, {time_at(2), a}};
  CHECK(SplineTrajectory(one).at(time_at(9)).X_WB.p() == Vector3(1, 0, 0));
  CHECK((SplineTrajectory(two).at(time_at(0.5)).v_WB - Vector3(1, 0, 0)).norm() < 1e-14);
  CHECK(SplineTrajectory(three).at(time_at(1)).v_WB.norm() < 1e-14);  // by symmetry
}

TEST_CASE("a long gap is crossed straight, without swinging out") {
  // Leaves upward at 1 m/s and comes back downward 3 s later: an ordinary cubic would rise by 0.75 m.
  std::vector<TimedPose> poses;
  for (int i = 0; i <= 20; ++i) poses.push_back({time_at(0.01 * i), Rigid::translation(Vector3(0, 0.01 * i, 0))});
  for (int i = 0; i <= 20; ++i)
    poses.push_back({time_at(3.2 + 0.01 * i), Rigid::translation(Vector3(0, 0.2 - 0.01 * i, 0))});
  const SplineTrajectory spline(poses);
  for (double t = 0.2; t < 3.2; t += 0.004) {
    const double y = spline.at(time_at(t)).X_WB.p().y();
    CHECK(y > 0.19);
    CHECK(y < 0.22);  // the speed of 1 m/s fades within a knot interval of 50 ms: below 0.25 * 50 mm
  }
}

TEST_CASE("half a turn between two samples stays finite") {
  const std::vector<TimedPose> poses{{time_at(0), Rigid()},
                                     {time_at(1), Rigid::rotation(Quaternion(0, 0, 1, 0))},
                                     {time_at(2), Rigid()},
                                     {time_at(3), Rigid::rotation(Quaternion(0, 1, 0, 0))}};
  const SplineTrajectory spline(poses);
  for (double t = 0; t <= 3; t += 0.01) {
    const MotionState s = spline.at(time_at(t));
    CHECK(s.X_WB.is_finite());
    CHECK(s.w_WB_B.norm() < 10.0);  // pi rad/s on average
  }
}
