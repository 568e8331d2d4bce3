// Filters that are as sure as they may be: matched simulations, with Jacobians and without.
#include <array>
#include <cmath>
#include <random>
#include <string>

#include <doctest/doctest.h>

#include <holdfast/tracking/advance.hpp>
#include <holdfast/tracking/camera_sighting.hpp>
#include <holdfast/tracking/consistency.hpp>
#include <holdfast/tracking/inertial_measurement.hpp>
#include <holdfast/tracking/pinhole_sighting.hpp>
#include <holdfast/tracking/pose_measurement.hpp>
#include <holdfast/tracking/range.hpp>
#include <holdfast/tracking/unscented_innovation.hpp>

#include "random_values.hpp"

using namespace holdfast;
using namespace holdfast::test;
using doctest::Approx;

namespace {

using Random = std::mt19937;

}  // namespace

TEST_CASE("consistency mean: bounds are quantiles of chi-square") {
  ConsistencyMean mean(6);
  CHECK_FALSE(mean.consistent());
  for (int i = 0; i < 50; ++i) mean.add(i % 2 ? 5.0 : 7.0);
  mean.add(std::nan(""));
  mean.add(std::nullopt);
  CHECK(mean.count() == 50);
  CHECK(mean.mean() == Approx(6.0));
  // Chi-square of 300 degrees: 253.912 and 349.874 (tables).
  CHECK(mean.bounds().low == Approx(253.912 / 50).epsilon(1e-5));
  CHECK(mean.bounds().high == Approx(349.874 / 50).epsilon(1e-5));
  CHECK(mean.consistent());
  for (int i = 0; i < 50; ++i) mean.add(9.0);
  CHECK_FALSE(mean.consistent());

  Matrix2 P;
  P << 4.0, 1.0, 1.0, 1.0;  // inverse: (1, -1; -1, 4) / 3
  CHECK(normalised_square<2>(Vector2(1.0, 2.0), P).value() == Approx((1.0 - 4.0 + 16.0) / 3.0).epsilon(1e-14));
  P(0, 1) = P(1, 0) = 3.0;
  CHECK_FALSE(normalised_square<2>(Vector2(1.0, 2.0), P));  // no covariance
}

namespace {

/// A sensor measures the truth with its noise, and hands `take` what `innovate` makes of that and of the source.
struct PoseSensor {
  double position_m = 1e-3;
  double orientation_rad = 1e-3;

  template <int Order, typename Innovate, typename Take>
  void measure(const TargetState<Order>& truth, Random& random, const Innovate& innovate, const Take& take) const {
    Vector6 deviation;
    deviation << Vector3::Constant(position_m), Vector3::Constant(orientation_rad);
    const Vector6 noise = deviation.cwiseProduct(random_vector<6>(random));
    PoseMeasurement pose;
    pose.X_WB = Rigid(truth.X_WB.q() * so3::exp<double>(Vector3(noise.tail<3>())), truth.X_WB.p() + noise.head<3>());
    pose.covariance.diagonal() = deviation.cwiseAbs2();
    NoDevice none;
    take(innovate(pose, none), none);
  }
};

/// Three cameras that look ahead, left and up, and one known beacon a time, anywhere in view of one of them.
struct SightingSensor {
  std::array<CameraView, 3> cameras;
  std::array<Rigid, 3> X_BC;
  double deviation_m = 2e-5;

  SightingSensor() {
    X_BC = {Rigid(), Rigid::rotation(so3::exp<double>(Vector3(0, 1.2, 0))),
            Rigid::rotation(so3::exp<double>(Vector3(1.2, 0, 0)))};
    for (std::size_t i = 0; i < cameras.size(); ++i) cameras[i].V = view_matrix(X_BC[i], 0.037);
  }

  template <int Order, typename Innovate, typename Take>
  void measure(const TargetState<Order>& truth, Random& random, const Innovate& innovate, const Take& take) const {
    std::uniform_real_distribution<double> place(-1.0, 1.0);
    const std::size_t i = random() % 3;
    const double depth = 2.0 + 0.8 * place(random);
    const double across = 0.3 * depth * place(random);
    const Vector3 p_C(across, 0.3 * depth * place(random), -depth);
    const Vector3 p_B = X_BC[i] * p_C;
    DeviceEstimate<3> beacon;
    beacon.x = truth.X_WB * p_B;
    const CameraSighting sighting{*cameras[i].project(p_B) + deviation_m * random_vector<2>(random), &cameras[i],
                                  deviation_m * deviation_m};
    take(innovate(sighting, beacon), beacon);
  }
};

struct Consistency {
  ConsistencyMean nees;
  ConsistencyMean nis;
};

template <int Order>
struct Matched {
  ProcessModel<Order> model;     ///< of the filter
  double truth_intensity = 1.0;  ///< of the simulated motion, over the filter's
  int steps = 60;
  int runs = 250;
};

/// Moves the truth as the process model says, with its noise.
template <int Order>
void move_truth(TargetState<Order>& truth, const ProcessModel<Order>& model, HostTime t, Random& random) {
  const double dt = to_seconds(t - truth.t);
  (void)advance(truth, model, t);
  typename TargetState<Order>::Error d;
  for (int axis = 0; axis < 6; ++axis) {
    const ChainStep<Order> step = chain_step<Order>(model.intensity[axis], model.decay[axis], dt);
    MatrixOf<double, Order> root;
    REQUIRE(cholesky<Order>(step.Q, root));
    const VectorOf<double, Order> kick = root * random_vector<Order>(random);
    for (int i = 0; i < Order; ++i) d[axis + 6 * i] = kick[i];
  }
  truth.P.setIdentity();
  truth.add(d);
}

/// Filters many simulated runs: NEES at the end of each, NIS of every measurement. Order of the noise: 2 mm and 2 mrad at
/// first, so that curvature is small against it.
template <int Order, typename Sensor>
Consistency simulate(const Matched<Order>& matched, const Sensor& sensor, bool unscented, unsigned seed) {
  using State = TargetState<Order>;
  Consistency result{
      ConsistencyMean(State::size),
      ConsistencyMean(std::is_same_v<Sensor, PoseSensor> ? PoseMeasurement::size : CameraSighting::size)};
  Random random(seed);
  ProcessModel<Order> truth_model = matched.model;
  truth_model.intensity *= matched.truth_intensity;
  typename State::Error deviation;
  deviation.template head<6>().setConstant(2e-3);
  if constexpr (Order >= 2) deviation.template segment<6>(6).setConstant(0.05);
  if constexpr (Order >= 3) deviation.template segment<6>(12).setConstant(0.5);
  for (int run = 0; run < matched.runs; ++run) {
    State estimate;
    const Vector3 turn = random_vector<3>(random);
    estimate.X_WB = Rigid(so3::exp<double>(turn), random_vector<3>(random));
    if constexpr (Order >= 2) estimate.velocity = {0.3 * random_vector<3>(random), 0.5 * random_vector<3>(random)};
    estimate.P = deviation.cwiseAbs2().asDiagonal();
    State truth = estimate;
    truth.add(deviation.cwiseProduct(random_vector<State::size>(random)));
    for (int step = 1; step <= matched.steps; ++step) {
      const HostTime t = time_at(0.01 * step);
      move_truth(truth, truth_model, t, random);
      (void)advance(estimate, matched.model, t);
      const auto innovate = [&](const auto& measurement, const auto& source) {
        return unscented ? unscented_innovation(estimate, measurement, source)
                         : extended_innovation(estimate, measurement, source);
      };
      const auto take = [&](const auto& innovation, auto& source) {
        REQUIRE(innovation);
        result.nis.add(innovation->nis());
        NoDevice none;
        (void)correct(estimate, *innovation, source, none);
      };
      sensor.measure(truth, random, innovate, take);
    }
    result.nees.add(nees(estimate, truth));
  }
  return result;
}

template <int Order>
Matched<Order> matched_model(double decay) {
  Matched<Order> matched;
  // As vigorous as a head: 1 m/s^2 and 4 rad/s^2 of 0.1 s each.
  const double base = Order == 2 ? 0.1 : 10.0;
  matched.model.intensity << Vector3::Constant(base), Vector3::Constant(16.0 * base);
  matched.model.decay.setConstant(decay);
  return matched;
}

// Sixteen means (NEES and NIS of four models and two sensors; both filters see the same noise) lie within their bounds
// together with a probability of 95 %.
constexpr double each_within = 1.0 - 0.05 / 16.0;

template <int Order>
void check_matched(const std::string& name, double decay) {
  const Matched<Order> matched = matched_model<Order>(decay);
  for (const bool unscented : {false, true}) {
    const auto check = [&](const std::string& sensor, const Consistency& result) {
      const auto bounds = result.nees.bounds(each_within);
      const auto nis_bounds = result.nis.bounds(each_within);
      const std::string filter = unscented ? " unscented" : " extended";
      INFO(name, " ", sensor, filter, ": NEES ", result.nees.mean(), " in [", bounds.low, ", ", bounds.high, "], NIS ",
           result.nis.mean(), " in [", nis_bounds.low, ", ", nis_bounds.high, "]");
      CHECK(result.nees.consistent(each_within));
      CHECK(result.nis.consistent(each_within));
    };
    check("pose", simulate(matched, PoseSensor(), unscented, 1));
    check("sightings", simulate(matched, SightingSensor(), unscented, 2));
  }
}

}  // namespace

// Each within 95 % bounds of its own: of 320 such means, over 40 seeds of 250 runs each, 18 lay outside, as 5 % may.
TEST_CASE("matched simulations: mean NEES and NIS lie within their joint 95 % bounds") {
  check_matched<2>("PV", 0.0);
  check_matched<2>("damped PV", 4.0);
  check_matched<3>("PVA", 0.0);
  check_matched<3>("Singer", 4.0);
}

TEST_CASE("a filter that expects too calm, or too lively, a motion is found out") {
  auto matched = matched_model<2>(0.0);
  matched.truth_intensity = 4.0;
  const Consistency too_calm = simulate(matched, SightingSensor(), false, 50);
  CHECK(too_calm.nees.mean() > too_calm.nees.bounds().high);
  CHECK(too_calm.nis.mean() > too_calm.nis.bounds().high);
  matched.truth_intensity = 0.25;
  const Consistency too_lively = simulate(matched, SightingSensor(), false, 51);
  CHECK(too_lively.nees.mean() < too_lively.nees.bounds().low);
  CHECK(too_lively.nis.mean() < too_lively.nis.bounds().low);
}
