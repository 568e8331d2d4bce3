// The unscented innovation against the extended one, and against Monte Carlo.
#include <cmath>
#include <random>

#include <doctest/doctest.h>

#include <holdfast/tracking/camera_sighting.hpp>
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

template <int Size>
MatrixOf<double, Size> random_covariance(Random& random, double sigma) {
  MatrixOf<double, Size> root;
  for (int j = 0; j < Size; ++j) root.col(j) = sigma / std::sqrt(double(Size)) * random_vector<Size>(random);
  return root * root.transpose();
}

template <int Order, typename M>
void check_equal(const Innovation<Order, M>& a, const Innovation<Order, M>& b, double tolerance) {
  CHECK((a.residual - b.residual).cwiseAbs().maxCoeff() < tolerance);
  CHECK((a.S - b.S).cwiseAbs().maxCoeff() < tolerance);
  CHECK((a.C - b.C).cwiseAbs().maxCoeff() < tolerance);
  if constexpr (M::source_size > 0) CHECK((a.C_source - b.C_source).cwiseAbs().maxCoeff() < tolerance);
  if constexpr (M::sensor_size > 0) CHECK((a.C_sensor - b.C_sensor).cwiseAbs().maxCoeff() < tolerance);
}

}  // namespace

TEST_CASE("unscented innovation: that of a linear measurement is the extended one") {
  Random random(1);
  for (int trial = 0; trial < 20; ++trial) {
    TargetState<2> state;
    state.P = random_covariance<12>(random, 0.3);
    state.velocity = {random_vector<3>(random), random_vector<3>(random)};
    DeviceEstimate<3> bias;
    bias.x = random_vector<3>(random);
    bias.P = random_covariance<3>(random, 0.1);
    bias.residual_variance = Vector3(0.0, 1e-3, 2e-3);
    bias.locked = trial % 2 == 0;  // which changes what `correct` does, not the innovation
    // Sums of numbers of order one: rounding.
    const AngularRate rate{random_vector<3>(random), so3::exp<double>(random_vector<3>(random)), 0.01};
    check_equal(*unscented_innovation(state, rate, {}, bias), *extended_innovation(state, rate, {}, bias), 1e-13);
    const PositionMeasurement position{random_vector<3>(random), Vector3::Zero(), 0.1 * Matrix3::Identity()};
    check_equal(*unscented_innovation(state, position, {}), *extended_innovation(state, position, {}), 1e-13);
  }
}

TEST_CASE("unscented innovation: of a curved one it is the extended one when all is nearly known") {
  Random random(2);
  PinholeSighting sighting{Vector2(1e-3, 2e-3), Rigid(), 0.037, 1e-12};
  TargetState<2> state;
  state.P = random_covariance<12>(random, 1e-5);
  DeviceEstimate<3> beacon;
  beacon.x = Vector3(0.2, 0.1, -2);
  beacon.P = random_covariance<3>(random, 1e-5);
  beacon.residual_variance.setConstant(1e-10);
  DeviceEstimate<7> camera;
  camera.P = random_covariance<7>(random, 1e-6);
  const auto unscented = unscented_innovation(state, sighting, beacon, camera);
  const auto extended = extended_innovation(state, sighting, beacon, camera);
  REQUIRE(unscented);
  REQUIRE(extended);
  CHECK((unscented->residual - extended->residual).norm() < 1e-10);
  // Deviations are a ten-thousandth of a millimetre on the image plane; curvature counts 1e-5 of that, to the first power.
  CHECK((unscented->S - extended->S).norm() < 1e-4 * extended->S.norm());
  CHECK((unscented->C - extended->C).norm() < 1e-4 * extended->C.norm());
  CHECK((unscented->C_source - extended->C_source).norm() < 1e-4 * extended->C_source.norm());
  CHECK((unscented->C_sensor - extended->C_sensor).norm() < 1e-4 * extended->C_sensor.norm());
}

TEST_CASE("unscented innovation: nearer to Monte Carlo for a range whose direction is hardly known") {
  // 2 m from the anchor, 0.8 m unsure across and 0.1 m along: the sphere's curvature lengthens the range by some 0.3 m.
  TargetState<1> state;
  state.X_WB = Rigid::translation(Vector3(0, 0, 2));
  state.P.diagonal() << 0.64, 0.64, 0.01, 0.01, 0.01, 0.01;
  const DeviceEstimate<3> anchor;
  const Range range{2.0, Vector3(0.1, 0, 0), 0.0025};
  const auto extended = extended_innovation(state, range, anchor);
  const auto unscented = unscented_innovation(state, range, anchor);
  REQUIRE(extended);
  REQUIRE(unscented);

  Random random(3);
  constexpr int draws = 200'000;
  double sum = 0.0;
  double squares = 0.0;
  Vector6 cross = Vector6::Zero();
  const Vector6 deviations = state.P.diagonal().cwiseSqrt();
  for (int i = 0; i < draws; ++i) {
    const Vector6 d = deviations.cwiseProduct(random_vector<6>(random));
    TargetState<1> drawn = state;
    drawn.add(d);
    const double expected = (drawn.X_WB * range.antenna_B).norm();
    sum += expected;
    squares += expected * expected;
    cross += d * expected;
  }
  const double mean = sum / draws;
  const double variance = squares / draws - mean * mean + range.variance;
  const Vector6 C = cross / draws;  // the errors have mean zero
  const auto mean_error = [&](const auto& innovation) {
    return std::abs(range.range_m - innovation.residual[0] - mean);
  };
  const auto variance_error = [&](const auto& innovation) { return std::abs(innovation.S(0, 0) - variance); };
  const auto cross_error = [&](const auto& innovation) { return (innovation.C - C).norm(); };
  INFO("mean ", mean, ": ", mean_error(*extended), " ", mean_error(*unscented), "; variance ", variance, ": ",
       variance_error(*extended), " ", variance_error(*unscented), "; cross: ", cross_error(*extended), " ",
       cross_error(*unscented));
  // Monte Carlo itself is good to 0.0007 m and 0.0005 m^2.
  CHECK(mean_error(*unscented) < 0.2 * mean_error(*extended));
  CHECK(variance_error(*unscented) < 0.5 * variance_error(*extended));
  CHECK(cross_error(*unscented) < cross_error(*extended) + 0.002);
  CHECK(mean_error(*extended) > 0.2);
}

TEST_CASE("unscented innovation: what is known exactly costs nothing, and what may be impossible is refused") {
  TargetState<1> state;
  state.P *= 1e-4;
  DeviceEstimate<3> beacon;  // known exactly
  beacon.x = Vector3(0, 0, -2);
  const CameraView camera{view_matrix(Rigid(), 0.037)};
  const CameraSighting sighting{Vector2::Zero(), &camera, 1e-10};
  const auto innovation = unscented_innovation(state, sighting, beacon);
  REQUIRE(innovation);
  CHECK(innovation->C_source.isZero(0.0));
  beacon.P = 4.0 * Matrix3::Identity();  // root 2 times 2 m reaches behind the camera
  CHECK_FALSE(unscented_innovation(state, sighting, beacon));
  CHECK(extended_innovation(state, sighting, beacon));  // which does not look there
  beacon.P(0, 0) = -1.0;
  CHECK_FALSE(unscented_innovation(state, sighting, beacon));
  beacon.P.setConstant(std::nan(""));
  CHECK_FALSE(unscented_innovation(state, sighting, beacon));
  beacon.P.setZero();
  state.P(2, 2) = std::nan("");
  CHECK_FALSE(unscented_innovation(state, sighting, beacon));
}
