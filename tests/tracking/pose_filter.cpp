#include <cmath>
#include <limits>
#include <random>

#include <doctest/doctest.h>

#include <holdfast/motion/generators.hpp>
#include <holdfast/tracking/pose_filter.hpp>
#include <holdfast/tracking/pose_measurement.hpp>
#include <holdfast/tracking/scaat_filter.hpp>

#include "allocation_counter.hpp"
#include "tracking/random_values.hpp"

using namespace holdfast;
using test::random_vector;

namespace {

using Random = std::mt19937;

Rigid noisy(const Rigid& X, const PoseNoise& noise, Random& random) {
  return Rigid(X.q() * so3::exp<double>(random_vector<3>(random, noise.orientation_rad)),
               X.p() + random_vector<3>(random, noise.position_m));
}

template <int Order>
ProcessModel<Order> uniform_model(double intensity, double decay = 0.0) {
  ProcessModel<Order> model;
  model.intensity.setConstant(intensity);
  model.decay.setConstant(decay);
  return model;
}

/// The true state after dt, pushed by the model's noise: drawn from each chain's Q.
template <int Order>
void move(TargetState<Order>& truth, const ProcessModel<Order>& model, Duration dt, Random& random) {
  REQUIRE(advance(truth, model, truth.t + dt));
  typename TargetState<Order>::Error d;
  for (int axis = 0; axis < 6; ++axis) {
    const ChainStep<Order> step = chain_step<Order>(model.intensity[axis], model.decay[axis], to_seconds(dt));
    const MatrixOf<double, Order> L = step.Q.llt().matrixL();
    const VectorOf<double, Order> drawn = L * random_vector<Order>(random);
    for (int i = 0; i < Order; ++i) d[axis + 6 * i] = drawn[i];
  }
  truth.add(d);
}

/// A filter that follows exact poses of a motion, every 5 ms until t.
template <int Order>
PoseFilter<Order> followed(const Motion& motion, const ProcessModel<Order>& model, HostTime t) {
  PoseFilter<Order> filter(model);
  for (HostTime at = motion.begin(); at <= t; at += std::chrono::milliseconds(5))
    filter.update({at, motion.at(at).X_WB});
  return filter;
}

/// p = a t^2 / 2 + v t, and a turn about a fixed axis alike.
class Accelerated : public Motion {
 public:
  Vector3 v{0.3, -0.1, 0.2}, a{0.5, 1.0, -2.0};
  Vector3 axis = Vector3(1.0, 2.0, -0.5).normalized();
  double w = 0.4, alpha = 1.5;

  [[nodiscard]] MotionState at(HostTime t) const override {
    const double s = to_seconds(t - begin());
    MotionState state;
    state.t = t;
    state.X_WB = Rigid(so3::exp<double>((w * s + 0.5 * alpha * s * s) * axis), v * s + 0.5 * s * s * a);
    state.v_WB = v + s * a;
    state.w_WB_B = (w + alpha * s) * axis;
    return state;
  }
  [[nodiscard]] HostTime begin() const override { return time_at(0.0); }
  [[nodiscard]] HostTime end() const override { return time_at(10.0); }
};

}  // namespace

TEST_CASE("PV in the steady state has the covariance that theory gives") {
  // Dense measurements of noise density r = s^2 dt and intensity q (the stationary Riccati equation of a double
  // integrator): P_pp = sqrt(2) q^(1/4) r^(3/4), P_pv = sqrt(q r), P_vv = sqrt(2) q^(3/4) r^(1/4).
  const double q = 2.0, s = 0.1, dt = 1e-4;
  PoseFilterSettings settings;
  settings.noise = {s, s};
  PoseFilter<2> filter(uniform_model<2>(q), settings);
  for (int i = 0; i < 10000; ++i) filter.update({time_at(i * dt), Rigid()});
  const double r = s * s * dt;
  // A step of dt is (q / r)^(1/4) dt = 0.4 % of the filter's time constant.
  const TargetState<2>& state = filter.state();
  for (int i = 0; i < 6; ++i) {
    CHECK(state.P(i, i) == doctest::Approx(std::sqrt(2.0) * std::pow(q, 0.25) * std::pow(r, 0.75)).epsilon(0.01));
    CHECK(state.P(i, i + 6) == doctest::Approx(std::sqrt(q * r)).epsilon(0.01));
    CHECK(state.P(i + 6, i + 6) ==
          doctest::Approx(std::sqrt(2.0) * std::pow(q, 0.75) * std::pow(r, 0.25)).epsilon(0.01));
  }
  CHECK(state.P == state.P.transpose());
}

TEST_CASE("a motion that the model knows is followed without error: constant velocity by PV, acceleration by PVA") {
  Accelerated motion;
  motion.alpha = 0.0;
  motion.a.setZero();
  const HostTime t = time_at(3.0);
  const TargetState<2> pv = followed(motion, uniform_model<2>(10.0), t).state();
  const MotionState steady = motion.at(t);
  // What the start did not know has died out long since: what is left is rounding of steps of 5 ms.
  CHECK((pv.X_WB.p() - steady.X_WB.p()).norm() < 1e-12);
  CHECK(so3::angle_between<double>(pv.X_WB.q(), steady.X_WB.q()) < 1e-12);
  CHECK((pv.velocity.v_WB - steady.v_WB).norm() < 1e-9);
  CHECK((pv.velocity.w_WB_B - steady.w_WB_B).norm() < 1e-9);

  const Accelerated accelerated;
  const TargetState<3> pva = followed(accelerated, uniform_model<3>(100.0), t).state();
  const MotionState truth = accelerated.at(t);
  CHECK((pva.X_WB.p() - truth.X_WB.p()).norm() < 1e-11);
  CHECK((pva.velocity.v_WB - truth.v_WB).norm() < 1e-8);
  CHECK((pva.acceleration.a_WB - accelerated.a).norm() < 1e-6);
  CHECK(so3::angle_between<double>(pva.X_WB.q(), truth.X_WB.q()) < 1e-11);
  CHECK((pva.acceleration.alpha_WB_B - accelerated.alpha * accelerated.axis).norm() < 1e-6);
}

TEST_CASE("on motions as the model has them, the errors are those that the covariance says") {
  const PvaModel model = uniform_model<3>(20.0, 5.0);
  PoseFilterSettings settings;
  settings.noise = {1e-3, 1e-3};
  settings.start = {0.5, 0.5, 1.0, 1.0};
  Random random(5);
  constexpr int runs = 400;
  double sum = 0.0;
  for (int run = 0; run < runs; ++run) {
    TargetState<3> truth;
    truth.t = time_at(0.0);
    truth.X_WB = Rigid(so3::exp<double>(random_vector<3>(random, 1.0)), random_vector<3>(random, 1.0));
    truth.velocity = {random_vector<3>(random, settings.start.speed_m_s),
                      random_vector<3>(random, settings.start.angular_speed_rad_s)};
    truth.acceleration = {random_vector<3>(random, settings.start.acceleration_m_s2),
                          random_vector<3>(random, settings.start.angular_acceleration_rad_s2)};
    PoseFilter<3> filter(model, settings);
    filter.update({truth.t, noisy(truth.X_WB, settings.noise, random)});
    for (int i = 0; i < 60; ++i) {
      move(truth, model, std::chrono::milliseconds(8), random);
      REQUIRE(filter.update({truth.t, noisy(truth.X_WB, settings.noise, random)}) == PoseFilterStatus::updated);
    }
    const TargetState<3>::Error d = filter.state().error_of(truth);
    const TargetState<3>::Covariance P = filter.state().P;
    const TargetState<3>::Error weighted = P.ldlt().solve(d);
    sum += d.dot(weighted);
  }
  // The mean of 400 chi-squared numbers of 18 degrees of freedom: 18 +- 0.6 (95 %: 0.59).
  CHECK(sum / runs == doctest::Approx(18.0).epsilon(0.59 / 18.0));
}

TEST_CASE("it is the filter of whole pose measurements, without what couples the axes") {
  PvModel model = uniform_model<2>(0.5, 1.0);
  PoseFilterSettings settings;
  settings.noise = {2e-3, 1e-3};
  const auto motion = make_walk_around(3, std::chrono::seconds(4));
  PoseFilter<2> filter(model, settings);
  filter.start({motion->begin(), motion->at(motion->begin()).X_WB});
  ScaatSettings ungated;
  ungated.gate.probability = 1.0;
  ScaatFilter<2> full(filter.state(), model, ungated);
  PoseMeasurement measurement;
  for (int i = 0; i < 6; ++i) measurement.covariance(i, i) = i < 3 ? 4e-6 : 1e-6;
  Random random(1);
  for (int i = 1; i < 400; ++i) {
    const HostTime t = motion->begin() + i * std::chrono::milliseconds(8);
    measurement.X_WB = noisy(motion->at(t).X_WB, settings.noise, random);
    filter.update({t, measurement.X_WB});
    REQUIRE(full.update(t, measurement) == UpdateStatus::updated);
    const TargetState<2>::Error d = filter.state().error_of(full.state());
    // Positions: the same numbers but for rounding. Orientations: a turn of 8 ms, 0.01 rad, mixes 1 % of the axes'
    // covariances, which here differ little; gains and so states differ by less.
    CHECK(d.head<3>().norm() < 1e-12);
    CHECK(d.segment<3>(6).norm() < 1e-10);
    CHECK(d.segment<3>(3).norm() < 0.02 * settings.noise.orientation_rad);
  }
  for (int i = 0; i < 12; ++i) CHECK(filter.state().P(i, i) == doctest::Approx(full.state().P(i, i)).epsilon(0.01));
}

TEST_CASE("turning the whole world turns state and nothing else") {
  const auto motion = make_swing(2, std::chrono::seconds(2));
  const Rigid X_VW(so3::exp<double>(Vector3(1.2, 0.3, -2.0)), Vector3(3, -1, 2));
  PoseFilter<3> filter(head_model()), turned(head_model());
  for (HostTime t = motion->begin(); t < motion->end(); t += std::chrono::milliseconds(10)) {
    const Rigid X_WB = motion->at(t).X_WB;
    filter.update({t, X_WB});
    turned.update({t, X_VW * X_WB});
  }
  const TargetState<3>&a = filter.state(), &b = turned.state();
  CHECK((X_VW * a.X_WB.p() - b.X_WB.p()).norm() < 1e-12);
  CHECK(so3::angle_between<double>(X_VW.q() * a.X_WB.q(), b.X_WB.q()) < 1e-12);
  CHECK((X_VW.q() * a.velocity.v_WB - b.velocity.v_WB).norm() < 1e-10);
  CHECK((a.velocity.w_WB_B - b.velocity.w_WB_B).norm() < 1e-10);
  CHECK((a.acceleration.alpha_WB_B - b.acceleration.alpha_WB_B).norm() < 1e-8);
}

TEST_CASE("what cannot be is refused and counted; after a gap it begins anew; nothing is allocated") {
  const std::size_t before = test::allocations();
  PoseFilter<3> filter(head_model());
  CHECK_FALSE(filter.is_started());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(filter.update({time_at(1.0), Rigid::translation(Vector3(0, nan, 0))}) == PoseFilterStatus::refused);
  CHECK_FALSE(filter.is_started());
  CHECK(filter.update({time_at(1.0), Rigid()}) == PoseFilterStatus::started);
  CHECK(filter.update({time_at(1.01), Rigid::translation(Vector3(0.01, 0, 0))}) == PoseFilterStatus::updated);
  const Vector3 v = filter.state().velocity.v_WB;
  CHECK(v.x() > 0.5);
  CHECK(filter.update({time_at(1.01), Rigid()}) == PoseFilterStatus::refused);
  CHECK(filter.update({time_at(0.5), Rigid()}) == PoseFilterStatus::refused);
  CHECK(filter.update({time_at(1.02), Rigid::translation(Vector3(1e200, 0, 0))}) == PoseFilterStatus::refused);
  CHECK(filter.refused() == 4);
  CHECK(filter.state().t == time_at(1.01));
  CHECK(filter.state().velocity.v_WB == v);
  const HostTime far{Duration(std::numeric_limits<std::int64_t>::max())};
  CHECK(filter.update({far, Rigid::translation(Vector3(0, 2, 0))}) == PoseFilterStatus::started);
  CHECK(filter.state().velocity.v_WB.norm() == 0.0);
  CHECK(test::allocations() == before);
}

TEST_CASE("whatever poses come, the state is finite and its covariance positive") {
  Random random(11);
  std::uniform_real_distribution<double> uniform;
  PoseFilter<3> filter(head_model());
  HostTime t = time_at(0.0);
  for (int i = 0; i < 20000; ++i) {
    t += Duration(static_cast<std::int64_t>(std::pow(10.0, 9.0 * uniform(random)) - 2.0));
    const double scale = std::pow(10.0, 24.0 * uniform(random) - 12.0);
    filter.update({t, Rigid(so3::exp<double>(random_vector<3>(random, 2.0)), random_vector<3>(random, scale))});
    REQUIRE(filter.state().is_finite());
    REQUIRE(filter.state().P.diagonal().minCoeff() > 0.0);
    REQUIRE(filter.state().P == filter.state().P.transpose());
    if (i % 100 == 0) {  // scaled to its variances, whose units and sizes differ
      const auto scales = filter.state().P.diagonal().cwiseSqrt().cwiseInverse().eval();
      const TargetState<3>::Covariance scaled = scales.asDiagonal() * filter.state().P * scales.asDiagonal();
      REQUIRE(scaled.llt().info() == Eigen::Success);
    }
  }
}
