// Checks that hold for every kind of measurement: Jacobians against central differences, a turned world, refusals.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <vector>

#include <doctest/doctest.h>
#include <tracking/random_values.hpp>

#include <holdfast/geometry/numeric_jacobian.hpp>
#include <holdfast/tracking/innovation.hpp>

namespace holdfast::test {

inline constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();

/// The state a measurement depends on, and no more.
template <typename M>
using StateOf = TargetState<M::state_size / 6>;
using PoseState = TargetState<1>;

template <int Order = 1>
TargetState<Order> random_state(std::mt19937& random) {
  TargetState<Order> state;
  state.X_WB = random_pose(random);
  state.velocity = {random_vector(random), random_vector(random)};
  state.acceleration = {random_vector(random), random_vector(random)};
  state.P *= 1e-6;
  return state;
}

inline PoseState state_at(const Rigid& X_WB) {
  PoseState state;
  state.X_WB = X_WB;
  state.P *= 1e-6;
  return state;
}

/// A measurement with the state and the devices that it is taken at.
template <typename M>
struct Scene {
  M measurement;
  StateOf<M> state;
  DeviceParameters<M::source_size> source = DeviceParameters<M::source_size>::Zero();
  DeviceParameters<M::sensor_size> sensor = DeviceParameters<M::sensor_size>::Zero();

  [[nodiscard]] Linearization<M> linearized() const {
    Linearization<M> linear;
    REQUIRE(measurement.linearize(state, source, sensor, linear));
    return linear;
  }
  [[nodiscard]] bool has_innovation() const {
    DeviceEstimate<M::source_size> source_estimate;
    DeviceEstimate<M::sensor_size> sensor_estimate;
    source_estimate.x = source;
    sensor_estimate.x = sensor;
    return extended_innovation(state, measurement, source_estimate, sensor_estimate).has_value();
  }
};

template <typename M>
Scene<M> scene_of(const M& measurement, const StateOf<M>& state,
                  const DeviceParameters<M::source_size>& source = DeviceParameters<M::source_size>::Zero(),
                  const DeviceParameters<M::sensor_size>& sensor = DeviceParameters<M::sensor_size>::Zero()) {
  return Scene<M>{measurement, state, source, sensor};
}

// The checks themselves know no types: they are compiled once for all measurements.
using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

struct AnyLinearization {
  Vector residual;
  Matrix H;  ///< by state, source and sensor, side by side
  Matrix R;
};

/// A scene whose state, source and sensor err by d, laid end to end.
using ErringScene = std::function<AnyLinearization(const Vector& d)>;

template <typename M>
ErringScene erring(const Scene<M>& scene) {
  return [scene](const Vector& d) {
    Scene<M> moved = scene;
    typename StateOf<M>::Error error;
    for (int i = 0; i < M::state_size; ++i) error[i] = d[i];
    moved.state.add(error);
    for (int i = 0; i < M::source_size; ++i) moved.source[i] += d[M::state_size + i];
    for (int i = 0; i < M::sensor_size; ++i) moved.sensor[i] += d[M::state_size + M::source_size + i];
    const Linearization<M> linear = moved.linearized();
    AnyLinearization any{linear.residual, Matrix(M::size, d.size()), linear.R};
    any.H.leftCols(M::state_size) = linear.H;
    any.H.middleCols(M::state_size, M::source_size) = linear.H_source;
    any.H.rightCols(M::sensor_size) = linear.H_sensor;
    return any;
  };
}

inline void check_jacobians(const ErringScene& scene, int size) {
  const AnyLinearization linear = scene(Vector::Zero(size));
  const double h = central_difference_step<double>();
  // Central differences are good to 1e-10 for functions of ordinary curvature; 1e-7 leaves room for those of an r^-4.
  const double tolerance = 1e-7 * std::max(linear.H.cwiseAbs().maxCoeff(), linear.residual.cwiseAbs().maxCoeff());
  for (int j = 0; j < size; ++j) {
    CAPTURE(j);
    const Vector change = scene(h * Vector::Unit(size, j)).residual - scene(-h * Vector::Unit(size, j)).residual;
    CHECK((change / (2.0 * h) + linear.H.col(j)).cwiseAbs().maxCoeff() < tolerance);
  }
}

/// Which blocks of three numbers of its parameters and of its residual turn with the world.
struct WorldBlocks {
  std::vector<int> source, sensor, residual;
};

inline void turn_blocks(const Quaternion& q, const std::vector<int>& blocks, double* numbers) {
  for (const int block : blocks) {
    Eigen::Map<Vector3> v(numbers + 3 * block);
    v = q * Vector3(v);
  }
}

/// Identity, with R in those blocks, from number `first` on.
inline void put_blocks(const Matrix3& R, const std::vector<int>& blocks, int first, Matrix& turn) {
  for (const int block : blocks) turn.block<3, 3>(first + 3 * block, first + 3 * block) = R;
}

/// In the turned world the residual is the same, and the Jacobians are but for the columns and rows of W's vectors.
inline void check_turned(const AnyLinearization& before, const AnyLinearization& after, const Matrix& columns,
                         const Matrix& rows) {
  // Rounding of numbers of that size, of some tens of sums.
  const double tolerance = 1e-11 * (1.0 + before.H.cwiseAbs().maxCoeff() + before.residual.cwiseAbs().maxCoeff());
  CHECK((after.residual - rows * before.residual).cwiseAbs().maxCoeff() < tolerance);
  CHECK((after.H * columns - rows * before.H).cwiseAbs().maxCoeff() < tolerance);
  CHECK((after.R - rows * before.R * rows.transpose()).cwiseAbs().maxCoeff() < tolerance);
}

/// Random scenes of one kind: `make(random)` gives one, `turn` turns what of the measurement belongs to the world, `spoil`
/// puts something that is not a number into what was measured.
template <typename Make, typename Turn, typename Spoil>
void check_measurement(unsigned seed, const WorldBlocks& blocks, const Make& make, const Turn& turn,
                       const Spoil& spoil) {
  std::mt19937 random(seed);
  for (int trial = 0; trial < 40; ++trial) {
    CAPTURE(trial);
    auto scene = make(random);
    using M = decltype(scene.measurement);
    constexpr int size = M::state_size + M::source_size + M::sensor_size;
    const ErringScene before = erring(scene);
    check_jacobians(before, size);

    auto turned = scene;
    const Quaternion q = so3::exp<double>(random_vector(random, 2.0));
    turn(turned.measurement, q);
    turned.state.X_WB = Rigid::rotation(q) * scene.state.X_WB;
    turned.state.velocity.v_WB = q * scene.state.velocity.v_WB;
    turned.state.acceleration.a_WB = q * scene.state.acceleration.a_WB;
    turn_blocks(q, blocks.source, turned.source.data());
    turn_blocks(q, blocks.sensor, turned.sensor.data());
    Matrix columns = Matrix::Identity(size, size);
    Matrix rows = Matrix::Identity(M::size, M::size);
    const Matrix3 R = q.toRotationMatrix();
    for (int order = 0; order < M::state_size / 6; ++order) put_blocks(R, {2 * order}, 0, columns);
    put_blocks(R, blocks.source, M::state_size, columns);
    put_blocks(R, blocks.sensor, M::state_size + M::source_size, columns);
    put_blocks(R, blocks.residual, 0, rows);
    check_turned(before(Vector::Zero(size)), erring(turned)(Vector::Zero(size)), columns, rows);

    CHECK(scene.has_innovation());
    auto spoilt = scene;
    spoil(spoilt.measurement);
    CHECK_FALSE(spoilt.has_innovation());
    spoilt = scene;
    spoilt.state.P(0, 0) = spoilt.state.P(3, 3) = nan_value;
    if constexpr (M::state_size > 6) spoilt.state.P(9, 9) = nan_value;
    CHECK_FALSE(spoilt.has_innovation());
  }
}

inline const auto turn_nothing = [](auto&, const Quaternion&) {};

inline double uniform(std::mt19937& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

}  // namespace holdfast::test
