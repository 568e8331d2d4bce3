#include <algorithm>
#include <cmath>
#include <limits>

#include <doctest/doctest.h>

#include <holdfast/motion/head_motions.hpp>
#include <holdfast/simulation/inertial_sensor.hpp>
#include <holdfast/tracking/azuma_bishop_filter.hpp>
#include <holdfast/tracking/consistency.hpp>

#include "allocation_counter.hpp"

using namespace holdfast;
using namespace std::chrono_literals;

namespace {

using Ekf = AzumaBishopOrientation;

/// Three independent normal numbers.
Vector3 normal3(KeyedNumbers& numbers) {
  const Vector2 a = numbers.normal_pair(), b = numbers.normal_pair();
  return Vector3(a.x(), a.y(), b.x());
}

Ekf::State some_state(std::uint64_t seed) {
  KeyedNumbers numbers(seed, {});
  Ekf::State X;
  const Vector3 turn = 2.0 * normal3(numbers);
  const Quaternion q = so3::exp<double>(turn);
  X << q.w(), q.x(), q.y(), q.z(), 3.0 * normal3(numbers), 20.0 * normal3(numbers);
  return X;
}

/// A filter that has seen a turning head and so has a full covariance.
Ekf warm_filter() {
  Ekf filter;
  const auto swing = make_swing(1, 1s);
  for (HostTime t = swing->begin(); t < swing->end(); t += 10ms) {
    const MotionState s = swing->at(t);
    filter.update(t, s.X_WB.q(), s.w_WB_B);
  }
  return filter;
}

/// Greatest element of J less the central differences of f.
template <int Rows, int Columns, typename Function>
double jacobian_error(const Function& f, const VectorOf<double, Columns>& x, const MatrixOf<double, Rows, Columns>& J) {
  constexpr double step = 1e-4;
  double worst = 0.0;
  for (int j = 0; j < Columns; ++j) {
    VectorOf<double, Columns> up = x, down = x;
    up[j] += step;
    down[j] -= step;
    const VectorOf<double, Rows> difference = f(up) - f(down);
    for (int i = 0; i < Rows; ++i) worst = std::max(worst, std::abs(difference[i] / (2.0 * step) - J(i, j)));
  }
  return worst;
}

}  // namespace

TEST_CASE("001 eq. 1: Jacobians against central differences") {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Ekf::State X = some_state(seed);
    CHECK(jacobian_error<10, 10>(Ekf::derivative, X, Ekf::derivative_jacobian(X)) < 1e-9);  // quadratic: rounding alone
    const Vector4 Q = 1.1 * X.head<4>();
    const auto normalize = [](const Vector4& q) { return Vector4(q.normalized()); };
    CHECK(jacobian_error<4, 4>(normalize, Q, Ekf::normalize_jacobian(Q)) < 1e-7);  // steps of 1e-4 squared
  }
}

TEST_CASE("001 eq. 1: the quaternion follows d/dt R = R hat(w), and Runge-Kutta's steps agree with far smaller ones") {
  const Ekf::State X = some_state(3), rate = Ekf::derivative(X);
  const Quaternion q(X[0], X[1], X[2], X[3]), q_rate(rate[0], rate[1], rate[2], rate[3]);
  const Quaternion turning = q.conjugate() * q_rate;
  CHECK(std::abs(turning.w()) < 1e-15);
  CHECK((2.0 * turning.vec() - X.segment<3>(4)).norm() < 1e-14);

  Ekf coarse = warm_filter(), fine = coarse;
  const Ekf before = coarse;
  coarse.time_update(0.02);
  for (int i = 0; i < 100; ++i) fine.time_update(0.0002);
  CHECK((coarse.X() - fine.X()).cwiseAbs().maxCoeff() < 1e-8);  // (|w| dt / 2)^5 / 120 of a radian a second
  const Ekf::Covariance P_error = coarse.P() - fine.P();
  // What RK4 leaves out of the acceleration's noise is of the fifth order: dt^5 / 120 and less of 351 in all.
  CHECK(P_error.cwiseAbs().maxCoeff() < 1e-6 * fine.P().cwiseAbs().maxCoeff());
  CHECK((fine.P() - before.P()).cwiseAbs().maxCoeff() > 0.1);
}

TEST_CASE("001 eq. 2: number by number is the same as the matrix formula, with and without gyros") {
  const Ekf warm = warm_filter();
  for (const bool gyros : {true, false}) {
    Ekf filter = warm;
    filter.time_update(0.015);
    const Quaternion q_m = (filter.q_WB() * so3::exp<double>(Vector3(0.02, -0.03, 0.01))).normalized();
    const Vector3 w_m = filter.w_WB_B() + Vector3(0.1, -0.2, 0.05);
    MatrixOf<double, 7, 10> H = MatrixOf<double, 7, 10>::Zero(), weighted;  // R^-1 H: without gyros three rows of zeros
    H.topLeftCorner<4, 4>() = Ekf::normalize_jacobian(Vector4(filter.X().head<4>()));
    H.block<3, 3>(4, 4).setIdentity();
    for (int i = 0; i < 7; ++i) weighted.row(i) = H.row(i) * (i < 4 ? 1.0 / 1e-4 : (gyros ? 1.0 / 0.005921 : 0.0));
    VectorOf<double, 7> innovation;
    innovation << Vector4(q_m.w(), q_m.x(), q_m.y(), q_m.z()) - Vector4(filter.X().head<4>().normalized()),
        w_m - filter.w_WB_B();
    const Ekf before = filter;
    const double nan = std::numeric_limits<double>::quiet_NaN();
    CHECK(filter.measurement_update(q_m, gyros ? w_m : Vector3(nan, nan, nan)));
    // The same without an inverse: P_after (I + H^T R^-1 H P) = P,  K = P_after H^T R^-1.
    const Ekf::Covariance information = H.transpose().lazyProduct(weighted), P = before.P(), P_after = filter.P();
    const Ekf::Covariance remaining = Ekf::Covariance::Identity() + information.lazyProduct(P);
    const Ekf::Covariance P_again = P_after.lazyProduct(remaining);
    CHECK((P_again - P).norm() < 1e-8 * P.norm());  // rounding_floor times R^-1
    const Ekf::State weighted_innovation = weighted.transpose().lazyProduct(innovation);
    Ekf::State X = before.X() + P_after.lazyProduct(weighted_innovation);
    X.head<4>().normalize();
    CHECK((filter.X() - X).norm() < 1e-8);
  }
}

TEST_CASE("orientation: the covariance is right where motion and noise are as the filter believes") {
  AzumaBishopOrientationNoise noise;
  noise.quaternion = 1e-6;
  noise.rate = 1e-4;
  noise.quaternion_drift = 1e-9;  // next to none: no head turns without a rate
  noise.rate_drift = 1e-9;
  noise.initial_quaternion = 1e-6;
  noise.initial_rate = 4.0;
  for (const bool gyros : {true, false}) {
    double nees = 0.0;
    int count = 0;
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
      KeyedNumbers numbers(seed, {gyros ? 1 : 0});
      Vector3 w = 2.0 * normal3(numbers), alpha = 2.0 * normal3(numbers);
      Quaternion q = so3::exp<double>(normal3(numbers));
      Ekf filter(noise);
      const auto measured_q = [&] {
        const Vector3 turn = 2e-3 * normal3(numbers);  // 2 sqrt(R): a quaternion has half angles
        return q * so3::exp<double>(turn);
      };
      filter.update(time_at(0.0), measured_q());
      for (int i = 1; i <= 100; ++i) {
        for (int k = 0; k < 10; ++k) {  // 1 ms steps of a random walk of alpha
          const Vector3 turn = 1e-3 * (w + 0.5e-3 * alpha);
          q = (q * so3::exp<double>(turn)).normalized();
          w += 1e-3 * alpha;
          alpha += std::sqrt(351.0 * 1e-3) * normal3(numbers);
        }
        const Vector3 said = w + 0.01 * normal3(numbers);
        const Quaternion q_m = measured_q();
        gyros ? filter.update(time_at(0.01 * i), q_m, said) : filter.update(time_at(0.01 * i), q_m);
        if (i < 30 || i % 10 != 0) continue;
        VectorOf<double, 9> error;
        error << so3::log<double>(filter.q_WB().conjugate() * q), w - filter.w_WB_B(), alpha - filter.alpha_WB_B();
        nees += normalised_square<9>(error, filter.error_covariance()).value();
        ++count;
      }
    }
    // 320 errors of 9 numbers, 8 of a run in part dependent: four deviations of the mean of 40 runs' worth, 18 / 40.
    CHECK(nees / count > 9.0 - 4.0 * std::sqrt(18.0 / 40.0));
    CHECK(nees / count < 9.0 + 4.0 * std::sqrt(18.0 / 40.0));
  }
}

TEST_CASE("position: the closed form solves 001's differential equation, and the update is the Kalman filter's") {
  const AzumaBishopPositionNoise noise;
  AzumaBishopPosition filter(0.3, noise);
  for (int i = 0; i < 5; ++i) {
    filter.advance(0.012);
    filter.correct(0.3 + 0.01 * i, 0.1 * i);
  }
  Vector3 X = filter.X();
  Matrix3 P = filter.P(), A;
  A << 0, 1, 0, 0, 0, 1, 0, 0, 0;
  const Matrix3 E = noise.drift.asDiagonal();
  const int steps = 2000;
  const double dt = 0.015 / steps;
  for (int i = 0; i < steps; ++i) {  // midpoint: errors of (dt / T)^2 = 2.5e-7
    const Vector3 x_middle = X + 0.5 * dt * (A * X);
    const Matrix3 p_middle = P + 0.5 * dt * (A * P + P * A.transpose() + E);
    X += dt * (A * x_middle);
    P += dt * (A * p_middle + p_middle * A.transpose() + E);
  }
  filter.advance(0.015);
  CHECK((filter.X() - X).norm() < 1e-9);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) CHECK(filter.P()(i, j) == doctest::Approx(P(i, j)).epsilon(1e-5));
  }

  // Of the update, without an inverse: P_after (I + H^T R^-1 H P) = P,  K = P_after H^T R^-1.
  const AzumaBishopPosition before = filter;
  filter.correct(0.4, -2.0);
  const Vector3 weights(1.0 / noise.position, 0.0, 1.0 / noise.acceleration);
  const Matrix3 remaining = Matrix3::Identity() + weights.asDiagonal() * before.P();
  CHECK((filter.P() * remaining - before.P()).norm() < 1e-5 * before.P().norm());  // rounding_floor times R^-1 P
  const Vector3 innovation = Vector3(0.4, 0.0, -2.0) - before.X();
  CHECK((filter.X() - before.X() - filter.P() * weights.cwiseProduct(innovation)).norm() < 1e-4);  // of 1; the same
}

TEST_CASE("position: the covariance is right where motion and noise are as the filter believes") {
  AzumaBishopPositionNoise noise;
  noise.drift = Vector3(1e-6, 1e-4, 10.0);
  noise.position = 1e-6;
  noise.acceleration = 0.01;
  noise.initial = Vector3(1e-6, 1.0, 1.0);
  for (const bool inertial : {true, false}) {
    double nees = 0.0;
    constexpr int runs = 200;
    for (std::uint64_t seed = 0; seed < runs; ++seed) {
      KeyedNumbers numbers(seed, {2});
      Vector3 truth = normal3(numbers);
      AzumaBishopPosition filter(truth[0] + 1e-3 * normal3(numbers)[0], noise);
      for (int i = 0; i < 50; ++i) {
        for (int k = 0; k < 10; ++k) {
          const Vector3 kick = std::sqrt(1e-3) * noise.drift.cwiseSqrt().cwiseProduct(normal3(numbers));
          truth = (Vector3(truth[0] + 1e-3 * truth[1] + 5e-7 * truth[2], truth[1] + 1e-3 * truth[2], truth[2]) + kick)
                      .eval();
        }
        const Vector3 errors = normal3(numbers);
        filter.advance(0.01);
        filter.correct(truth[0] + 1e-3 * errors[0],
                       inertial ? std::optional(truth[2] + 0.1 * errors[1]) : std::nullopt);
      }
      const Vector3 error = truth - filter.X();
      nees += normalised_square<3>(error, filter.P()).value();
    }
    CHECK(std::abs(nees / runs - 3.0) < 4.0 * std::sqrt(6.0 / runs));  // four deviations
  }
}

TEST_CASE("the whole tracker: exact data, separate accelerometers askew; poses and readings once 10 ms") {
  const auto motion = make_rotation(2, 4s);
  InertialUnit unit;
  unit.X_BS = Rigid(so3::exp<double>(Vector3(0.3, -0.8, 0.5)), Vector3(0.06, 0.11, -0.04));
  unit.accelerometers_S = {Vector3(0.05, 0.01, -0.02), Vector3(-0.03, 0.04, 0.01), Vector3(0.02, -0.06, 0.03)};
  unit.gyro.bias = Vector3(0.1, -0.2, 0.3);
  unit.accelerometer.scale = Vector3(1.1, 0.9, 1.05);
  AzumaBishopSettings settings;
  settings.X_BS = unit.X_BS;
  settings.accelerometers_S = unit.accelerometers_S;
  settings.rate_bias = unit.gyro.bias;
  settings.force_scale = unit.accelerometer.scale;
  AzumaBishopFilter with(settings), without;
  double w_error = 0.0, w_error_without = 0.0, a_error = 0.0, a_error_without = 0.0;
  std::vector<double> alpha_true, alpha_said;
  for (HostTime t = motion->begin(); t <= motion->end(); t += 10ms) {
    const MotionState truth = motion->at(t);
    InertialReading reading = ideal_inertial_reading(truth, unit);
    reading.rate_B += unit.gyro.bias;
    with.update({t, truth.X_WB}, reading);
    without.update({t, truth.X_WB});
    alpha_true.push_back(truth.alpha_WB_B.y());
    alpha_said.push_back(with.orientation().alpha_WB_B().y());
    if (t < time_at(1.0)) continue;
    w_error = std::max(w_error, (with.state().velocity.w_WB_B - truth.w_WB_B).norm());
    w_error_without = std::max(w_error_without, (without.state().velocity.w_WB_B - truth.w_WB_B).norm());
    a_error = std::max(a_error, (with.state().acceleration.a_WB - truth.a_WB).norm());
    a_error_without = std::max(a_error_without, (without.state().acceleration.a_WB - truth.a_WB).norm());
    CHECK((with.state().X_WB.p() - truth.X_WB.p()).norm() < 1e-3);
    CHECK(so3::angle_between<double>(with.state().X_WB.q(), truth.X_WB.q()) < 5e-3);
  }
  CHECK(w_error < 0.02);                   // a tenth of a head's usual rate, and less
  CHECK(w_error < 0.2 * w_error_without);  // which have to guess it
  CHECK(a_error < 0.6 * a_error_without);  // w' lags, and its error times the lever remains (appendix A's end)
  // "the estimated derivative of W lags behind the true derivative by about 20 ms" (appendix A): the shift that matches best.
  std::size_t best = 0;
  double least = 1e300;
  for (std::size_t lag = 0; lag < 20; ++lag) {
    double squares = 0.0;
    for (std::size_t i = 100; i < alpha_true.size(); ++i) {
      squares += (alpha_said[i] - alpha_true[i - lag]) * (alpha_said[i] - alpha_true[i - lag]);
    }
    if (squares < least) best = lag;
    least = std::min(least, squares);
  }
  MESSAGE("the estimated angular acceleration lags by " << 10 * best << " ms (001: 20 ms)");
  CHECK(best >= 1);
  CHECK(best <= 5);
}

TEST_CASE("bad data: refused, or used in part, and named; the state stays finite") {
  const auto motion = make_swing(1, 2s);
  const InertialUnit unit;
  const auto nan = std::numeric_limits<double>::quiet_NaN();
  AzumaBishopFilter filter;
  CHECK(filter.update({time_at(0.0), motion->at(time_at(0.0)).X_WB}) == AzumaBishopStatus::started);
  for (int i = 1; i <= 100; ++i) {
    const MotionState truth = motion->at(time_at(0.01 * i));
    InertialReading reading = ideal_inertial_reading(truth, unit);
    if (i == 40) reading.rate_B.y() = nan;
    if (i == 41) reading.force_B.z() = nan;
    if (i == 42) reading.rate_B.setConstant(std::numeric_limits<double>::infinity());
    if (i == 43) reading.rate_B.x() = 1e200;
    if (i == 44) reading.force_B.y() = -1e200;
    const AzumaBishopStatus status = filter.update({truth.t, truth.X_WB}, reading);
    CHECK(status == (i >= 40 && i <= 44 ? AzumaBishopStatus::updated_in_part : AzumaBishopStatus::updated));
    CHECK(filter.state().is_finite());
  }
  const MotionState truth = motion->at(time_at(1.0));
  CHECK((filter.state().velocity.w_WB_B - truth.w_WB_B).norm() < 0.1);

  const TargetState<3> before = filter.state();
  const InertialReading reading = ideal_inertial_reading(truth, unit);
  CHECK(filter.update({time_at(1.0), truth.X_WB}, reading) == AzumaBishopStatus::refused);  // the same time again
  CHECK(filter.update({time_at(0.5), truth.X_WB}) == AzumaBishopStatus::refused);
  CHECK(filter.update({time_at(1.01), Rigid::translation(Vector3(nan, 0, 0))}) == AzumaBishopStatus::refused);
  CHECK(filter.update({time_at(1.01), Rigid::translation(Vector3(1e13, 0, 0))}) == AzumaBishopStatus::refused);
  CHECK((filter.state().P - before.P).norm() == 0.0);
  CHECK(filter.update({time_at(1.6), truth.X_WB}, reading) == AzumaBishopStatus::started);  // after a gap
  // -q is the same orientation.
  const Rigid turned(Quaternion(-truth.X_WB.q().coeffs()), truth.X_WB.p());
  CHECK(filter.update({time_at(1.61), turned}, reading) == AzumaBishopStatus::updated);
  CHECK(so3::angle_between<double>(filter.state().X_WB.q(), truth.X_WB.q()) < 0.02);
}

TEST_CASE("the covariance stays symmetric and positive definite, and nothing allocates") {
  const auto motion = make_swing(1, 10s);
  const InertialUnit unit;
  AzumaBishopFilter filter;
  std::size_t allocated = 0;
  for (int i = 0; i < 12000; ++i) {  // 200 s at 60 Hz
    const MotionState truth = motion->at(time_at(0.0167 * (i % 600)));
    const InertialReading reading = ideal_inertial_reading(truth, unit);
    const std::size_t before = test::allocations();
    filter.update({time_at(0.0167 * i), truth.X_WB}, reading);
    (void)filter.state();
    allocated += test::allocations() - before;
  }
  if (test::counts_allocations()) CHECK(allocated == 0);
  const Ekf::Covariance P = filter.orientation().P();
  CHECK(P == P.transpose());
  CHECK(normalised_square<10>(Ekf::State::Ones(), P).has_value());
  CHECK(normalised_square<18>(VectorOf<double, 18>::Ones(), filter.state().P).has_value());
}

TEST_CASE(
    "whatever finite data come, no number is lost: noise of a metre and a half turn, rates that are not the poses'") {
  AzumaBishopFilter filter;
  for (int i = 0; i < 3000; ++i) {
    KeyedNumbers numbers(9, {i});
    const Vector3 turn = 3.0 * normal3(numbers), place = normal3(numbers);
    InertialReading reading;
    reading.rate_B = 1e3 * normal3(numbers);
    reading.force_B = 1e5 * normal3(numbers);
    filter.update({time_at(0.001 * i * (1 + i % 50)), Rigid(so3::exp<double>(turn), place)}, reading);
    const TargetState<3> state = filter.state();
    CHECK(state.is_finite());
    CHECK(std::abs(state.X_WB.q().norm() - 1.0) < 1e-12);
  }
}
