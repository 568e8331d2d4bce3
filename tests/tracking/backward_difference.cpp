#include <random>

#include <doctest/doctest.h>

#include <holdfast/motion/generators.hpp>
#include <holdfast/tracking/backward_difference.hpp>

using namespace holdfast;

TEST_CASE("the twist carries the older pose into the newer") {
  const Rigid a(so3::exp<double>(Vector3(0.3, -0.8, 0.1)), Vector3(1, 2, 3));
  const Vector3 w(0.5, 1.0, -2.0), v(0.1, -0.2, 0.3);
  const double dt = 0.02;
  const Vector3 phi = w * dt;
  const Rigid b(a.q() * so3::exp<double>(phi), a.p() + v * dt);
  const PoseEstimate estimate = backward_difference({time_at(1.0), a}, {time_at(1.0 + dt), b});
  REQUIRE(estimate.velocity.has_value());
  CHECK(estimate.t == time_at(1.02));
  CHECK((estimate.velocity->v_WB - v).norm() < 1e-12);
  CHECK((estimate.velocity->w_WB_B - w).norm() < 1e-12);
}

TEST_CASE("it lags the true velocity by half the interval") {
  const auto motion = make_motion("M2", 1);
  const HostTime now = time_at(0.1);
  const Duration dt = std::chrono::microseconds(16700);
  const PoseEstimate estimate = backward_difference({now - dt, motion->at(now - dt).X_WB}, {now, motion->at(now).X_WB});
  // Second order: (dt^2 / 24) * third derivative = 1.2e-5 * 65 rad/s^3.
  CHECK((estimate.velocity->w_WB_B - motion->at(now - dt / 2).w_WB_B).norm() < 1e-3);
  CHECK((estimate.velocity->w_WB_B - motion->at(now).w_WB_B).norm() > 0.02);
}

TEST_CASE("times that do not increase give no velocity") {
  const TimedPose a{time_at(1.0), Rigid()}, b{time_at(1.0), Rigid::translation(Vector3(1, 0, 0))};
  CHECK_FALSE(backward_difference(a, b).velocity.has_value());
  CHECK_FALSE(backward_difference({time_at(2.0), Rigid()}, b).velocity.has_value());
}

TEST_CASE("the covariance is that of the differences' noise, cross terms included") {
  const PoseNoise noise{0.002, 0.003};
  const double dt = 0.0167;
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  const auto noisy = [&](const Rigid& X) {
    const Vector3 phi(noise.orientation_rad * normal(random), noise.orientation_rad * normal(random),
                      noise.orientation_rad * normal(random));
    const Vector3 p(noise.position_m * normal(random), noise.position_m * normal(random),
                    noise.position_m * normal(random));
    return Rigid(X.q() * so3::exp<double>(phi), X.p() + p);
  };
  const Rigid X_older, X_newer(so3::exp<double>(Vector3(0.01, 0.02, 0.0)), Vector3(0.01, 0, 0));
  const PoseEstimate truth = backward_difference({time_at(0), X_older}, {time_at(dt), X_newer}, noise, no_dynamics);
  Matrix12 sum = Matrix12::Zero();
  const int n = 20000;
  for (int i = 0; i < n; ++i) {
    const PoseEstimate e = backward_difference({time_at(0), noisy(X_older)}, {time_at(dt), noisy(X_newer)}, noise);
    VectorOf<double, 12> d;
    d << e.X_WB.p() - truth.X_WB.p(), so3::log<double>(truth.X_WB.q().conjugate() * e.X_WB.q()),
        e.velocity->v_WB - truth.velocity->v_WB, e.velocity->w_WB_B - truth.velocity->w_WB_B;
    sum += d * d.transpose();
  }
  sum /= n;
  for (int i = 0; i < 12; ++i) {
    for (int j = 0; j < 12; ++j) {
      const double scale = std::sqrt(truth.covariance(i, i) * truth.covariance(j, j));
      // Statistical error sqrt(2/n) = 1 %, four times; small rotations couple axes by about |phi| = 2 %.
      CHECK(std::abs(sum(i, j) - truth.covariance(i, j)) < 0.05 * scale);
    }
  }
}

TEST_CASE("a velocity's age counts as uncertainty: half the interval times the usual acceleration") {
  HeadDynamics head;
  head.acceleration_m_s2 = 2.0;
  const Matrix12 covariance = backward_difference({time_at(0), Rigid()}, {time_at(0.02), Rigid()}, {}, head).covariance;
  CHECK(covariance(6, 6) == doctest::Approx(0.02 * 0.02).epsilon(1e-12));
  CHECK(covariance.topLeftCorner<6, 6>().norm() == 0.0);
}
