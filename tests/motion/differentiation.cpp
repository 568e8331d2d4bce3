#include <algorithm>

#include <doctest/doctest.h>

#include <holdfast/motion/differentiation.hpp>
#include <holdfast/motion/generators.hpp>
#include <holdfast/motion/sampled_trajectory.hpp>

using namespace holdfast;

TEST_CASE("derivatives of samples approach the truth with the square of the interval") {
  const auto motion = make_motion("M6", 4);
  const auto worst = [&](Duration interval) {
    double v = 0, a = 0, w = 0, alpha = 0;
    const auto states = differentiate(sample(*motion, interval));
    for (std::size_t i = 1; i + 1 < states.size(); ++i) {
      const MotionState truth = motion->at(states[i].t);
      v = std::max(v, (states[i].v_WB - truth.v_WB).norm());
      a = std::max(a, (states[i].a_WB - truth.a_WB).norm());
      w = std::max(w, (states[i].w_WB_B - truth.w_WB_B).norm());
      alpha = std::max(alpha, (states[i].alpha_WB_B - truth.alpha_WB_B).norm());
    }
    return std::array{v, a, w, alpha};
  };
  const auto coarse = worst(std::chrono::milliseconds(20)), fine = worst(std::chrono::milliseconds(10));
  for (std::size_t i = 0; i < 4; ++i) CHECK(coarse[i] / fine[i] == doctest::Approx(4.0).epsilon(0.1));
  CHECK(fine[0] < 1e-3);  // h^2/6 of a third derivative of about 20 m/s^3
  CHECK(fine[2] < 1e-2);
}

TEST_CASE("a parabola and a constant rate are exact, also with uneven times and at the ends") {
  std::vector<TimedPose> poses;
  const Vector3 w(0.3, -1.2, 0.5), a(1, 2, -3);
  for (const double t : {0.0, 0.01, 0.025, 0.031, 0.05}) {
    const Vector3 phi = w * t;
    poses.push_back({time_at(t), Rigid(so3::exp<double>(phi), 0.5 * t * t * a)});
  }
  for (const MotionState& s : differentiate(poses)) {
    CHECK((s.v_WB - to_seconds(s.t.time_since_epoch()) * a).norm() < 1e-12);
    CHECK((s.a_WB - a).norm() < 1e-9);  // rounding 1e-16 / (1e-2)^2
    CHECK((s.w_WB_B - w).norm() < 1e-12);
    CHECK(s.alpha_WB_B.norm() < 1e-9);
  }
}

TEST_CASE("fewer than three samples have no acceleration") {
  const std::vector<TimedPose> two{{time_at(0), Rigid()}, {time_at(2), Rigid::translation(Vector3(1, 0, 0))}};
  CHECK((differentiate(two)[1].v_WB - Vector3(0.5, 0, 0)).norm() < 1e-15);
  CHECK(differentiate(two)[1].a_WB.norm() == 0.0);
  CHECK(differentiate(std::span(two).first(1))[0].v_WB.norm() == 0.0);
  CHECK(differentiate({}).empty());
}
