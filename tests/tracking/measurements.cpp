// Every kind of measurement: Jacobians against central differences, a turned world, values known in closed form, refusals.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include <holdfast/geometry/angle.hpp>
#include <holdfast/geometry/numeric_jacobian.hpp>
#include <holdfast/tracking/bearing.hpp>
#include <holdfast/tracking/camera_sighting.hpp>
#include <holdfast/tracking/dipole_field.hpp>
#include <holdfast/tracking/inertial_measurement.hpp>
#include <holdfast/tracking/innovation.hpp>
#include <holdfast/tracking/joint_angles.hpp>
#include <holdfast/tracking/phase_range.hpp>
#include <holdfast/tracking/pinhole_sighting.hpp>
#include <holdfast/tracking/pose_measurement.hpp>
#include <holdfast/tracking/range.hpp>

#include "random_values.hpp"

using namespace holdfast;
using namespace holdfast::test;
using doctest::Approx;

namespace {

constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();

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

PoseState state_at(const Rigid& X_WB) {
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

void check_jacobians(const ErringScene& scene, int size) {
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

void turn_blocks(const Quaternion& q, const std::vector<int>& blocks, double* numbers) {
  for (const int block : blocks) {
    Eigen::Map<Vector3> v(numbers + 3 * block);
    v = q * Vector3(v);
  }
}

/// Identity, with R in those blocks, from number `first` on.
void put_blocks(const Matrix3& R, const std::vector<int>& blocks, int first, Matrix& turn) {
  for (const int block : blocks) turn.block<3, 3>(first + 3 * block, first + 3 * block) = R;
}

/// In the turned world the residual is the same, and the Jacobians are but for the columns and rows of W's vectors.
void check_turned(const AnyLinearization& before, const AnyLinearization& after, const Matrix& columns,
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

const auto turn_nothing = [](auto&, const Quaternion&) {};

double uniform(std::mt19937& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

}  // namespace

TEST_CASE("range: Jacobians, turned world, refusals") {
  const auto make = [](std::mt19937& random) {
    return scene_of(Range{uniform(random, 0.5, 5.0), random_vector(random, 0.2), 1e-4}, random_state(random),
                    random_vector(random, 3.0));
  };
  check_measurement(1, {{0}, {}, {}}, make, turn_nothing, [](Range& range) { range.range_m = nan_value; });
  const Scene<Range> scene = scene_of(Range{2.0}, PoseState(), Vector3(0, 0, 1));
  CHECK(scene.has_innovation());
  auto bad = scene;
  bad.measurement.range_m = -2.0;
  CHECK_FALSE(bad.has_innovation());
  bad = scene;
  bad.measurement.range_m = std::numeric_limits<double>::infinity();
  CHECK_FALSE(bad.has_innovation());
  bad = scene;
  bad.source.setZero();  // on the antenna itself
  CHECK_FALSE(bad.has_innovation());
  bad.source.setConstant(nan_value);
  CHECK_FALSE(bad.has_innovation());
}

TEST_CASE("range: a quarter turn swings the antenna out") {
  const Quaternion quarter = so3::exp<double>(Vector3(0, 0, std::numbers::pi / 2));
  const PoseState state = state_at(Rigid(quarter, Vector3(1, 1, 0)));
  // The antenna, 2 m ahead on B's x, is at (1, 3, 0): 3, 4, 5 from an anchor at (4, 3, 4).
  const Linearization<Range> linear =
      scene_of(Range{5.25, Vector3(2, 0, 0), 0.01}, state, Vector3(4, 3, 4)).linearized();
  CHECK(linear.residual[0] == Approx(0.25).epsilon(1e-14));
  CHECK((linear.H.leftCols<3>() - Vector3(-0.6, 0, -0.8).transpose()).norm() < 1e-15);
  // Turning about z moves the antenna by 2 m/rad towards -x of W, away from the anchor: +1.2 m/rad.
  CHECK(linear.H(0, 5) == Approx(1.2).epsilon(1e-14));
  CHECK(linear.R(0, 0) == 0.01);
}

TEST_CASE("range with bias: the link's bias is taken off and can be learnt") {
  const auto make = [](std::mt19937& random) {
    return scene_of(RangeWithBias{{uniform(random, 0.5, 5.0), random_vector(random, 0.2), 1e-4}}, random_state(random),
                    random_vector(random, 3.0), VectorOf<double, 1>(uniform(random, -0.3, 0.3)));
  };
  check_measurement(2, {{0}, {}, {}}, make, turn_nothing,
                    [](RangeWithBias& biased) { biased.range.range_m = nan_value; });

  // A body held exactly in place, an anchor 3 m away whose ranges come 0.4 m long.
  PoseState state;
  state.P *= 1e-12;
  DeviceEstimate<3> anchor;
  anchor.x = Vector3(0, 3, 0);
  DeviceEstimate<1> bias;
  bias.P(0, 0) = 1.0;
  for (int i = 0; i < 10; ++i) {
    const auto innovation = extended_innovation(state, RangeWithBias{{3.4, Vector3::Zero(), 0.01}}, anchor, bias);
    REQUIRE(innovation);
    correct(state, *innovation, anchor, bias);
  }
  // Ten measurements of variance 0.01 against a prior of variance 1: 0.4 * 1000 / 1001.
  CHECK(bias.x[0] == Approx(0.4 * 1000.0 / 1001.0).epsilon(1e-8));
  CHECK(bias.P(0, 0) == Approx(1.0 / 1001.0).epsilon(1e-8));
}

TEST_CASE("range difference: Jacobians, turned world; none across the middle") {
  const auto make = [](std::mt19937& random) {
    return scene_of(RangeDifference{uniform(random, -2.0, 2.0), random_vector(random, 0.2), 1e-4}, random_state(random),
                    random_vector(random, 3.0), random_vector(random, 3.0));
  };
  check_measurement(3, {{0}, {0}, {}}, make, turn_nothing,
                    [](RangeDifference& difference) { difference.difference_m = nan_value; });
  const PoseState state = state_at(Rigid::translation(Vector3(0, 2, -7)));
  const Linearization<RangeDifference> linear =
      scene_of(RangeDifference{0.1, Vector3::Zero(), 1.0}, state, Vector3(3, 0, 0), Vector3(-3, 0, 0)).linearized();
  CHECK(linear.residual[0] == Approx(0.1).epsilon(1e-13));
  // Both anchors are sqrt(62) m away, and 3 m aside.
  CHECK((linear.H.leftCols<3>() - Vector3(-6 / std::sqrt(62.0), 0, 0).transpose()).norm() < 1e-15);
}

TEST_CASE("phase range: the nearest cycle is taken, and told") {
  const auto make = [](std::mt19937& random) {
    PhaseRange phase{0.0, 0.1, random_vector(random, 0.2), 1e-6};
    Scene<PhaseRange> scene = scene_of(phase, random_state(random), random_vector(random, 3.0));
    const double distance = (scene.state.X_WB * phase.antenna_B - scene.source).norm();
    // Off by at most 0.4 of a cycle: differences must not take the next one.
    scene.measurement.phase_m = std::fmod(distance + uniform(random, -0.04, 0.04), 0.1);
    return scene;
  };
  check_measurement(4, {{0}, {}, {}}, make, turn_nothing, [](PhaseRange& phase) { phase.phase_m = nan_value; });

  const Vector3 anchor(0, 0, 0);
  const PhaseRange phase{0.034, 0.1, Vector3::Zero(), 1e-6};
  for (const double distance : {1.234, 1.19, 1.28, 1.2841}) {
    CAPTURE(distance);
    const PoseState state = state_at(Rigid::translation(Vector3(0, 0, distance)));
    const double cycles = distance > 1.284 ? 13.0 : 12.0;
    CHECK(phase.cycles(state, anchor).value() == cycles);
    CHECK(scene_of(phase, state, anchor).linearized().residual[0] ==
          Approx(0.034 + 0.1 * cycles - distance).epsilon(1e-12));
  }
  PoseState vague = state_at(Rigid::translation(Vector3(0, 0, 1.234)));
  vague.P(2, 2) = 0.0166 * 0.0166;
  CHECK(scene_of(phase, vague, anchor).has_innovation());
  vague.P(2, 2) = 0.0167 * 0.0167;  // a sixth of 0.1 m lies between
  CHECK_FALSE(scene_of(phase, vague, anchor).has_innovation());
  auto reckless = phase;
  reckless.largest_deviation = std::numeric_limits<double>::infinity();
  CHECK(scene_of(reckless, vague, anchor).has_innovation());
  CHECK_FALSE(scene_of(PhaseRange{0.0, 0.0}, vague, Vector3(1, 0, 0)).has_innovation());
  CHECK_FALSE(phase.cycles(state_at(Rigid::translation(Vector3(0, 0, nan_value))), anchor));
}

TEST_CASE_TEMPLATE("bearing: Jacobians and turned world, from the body and from the room", Mount, SensorOnBody,
                   SensorInRoom) {
  constexpr bool on_body = std::is_same_v<Mount, SensorOnBody>;
  const auto make = [](std::mt19937& random) {
    Scene<Bearing<Mount>> scene{{}, random_state(random), random_vector(random, on_body ? 3.0 : 0.2)};
    scene.measurement.sensor = Mount{random_pose(random)};
    scene.measurement.variance = 1e-4;
    const Vector3 seen = scene.measurement.sensor.see(scene.state, scene.source).p_S;
    // The measured direction is off by nothing, little, much or nearly half a turn.
    const double offs[] = {0.0, 1e-6, 1e-3, 0.5, 2.0, 3.0};
    const Vector3 axis = detail::across(seen.normalized()) * Vector2(0.6, 0.8);
    scene.measurement.direction_S = so3::exp<double>(offs[random() % 6] * axis) * seen;
    return scene;
  };
  const auto turn = [](Bearing<Mount>& bearing, const Quaternion& q) {
    if constexpr (!on_body) bearing.sensor.X_WS = Rigid::rotation(q) * bearing.sensor.X_WS;
  };
  const WorldBlocks blocks = on_body ? WorldBlocks{{0}, {}, {}} : WorldBlocks{{}, {}, {}};
  check_measurement(5, blocks, make, turn, [](Bearing<Mount>& bearing) { bearing.direction_S.x() = nan_value; });
}

TEST_CASE("bearing: the residual is the angle, whatever the direction") {
  const Vector3 beacon(0, 0, -2);
  for (const double off : {0.0, 1e-9, 1e-5, 10.0, 90.0, 170.0, 179.9}) {
    CAPTURE(off);
    const Vector3 direction = so3::exp<double>(Vector3(0, degrees(off).radians(), 0)) * Vector3(0, 0, -5);
    const Linearization<Bearing<>> linear = scene_of(Bearing<>{direction, {}, 1e-6}, PoseState(), beacon).linearized();
    // The angle of a sine that differs from its argument by rounding; near half a turn its slope is steep.
    CHECK(linear.residual.norm() == Approx(degrees(off).radians()).epsilon(1e-10));
    CHECK(linear.R.isApprox(1e-6 * Matrix2::Identity()));
  }
  // Straight up is a direction like any other: no pole.
  CHECK(scene_of(Bearing<>{Vector3(0, 1, 0), {}, 1e-6}, PoseState(), Vector3(0, 3, 0)).linearized().residual.norm() ==
        0.0);
  CHECK_FALSE(scene_of(Bearing<>{Vector3(0, 0, 1), {}, 1e-6}, PoseState(), beacon).has_innovation());  // the opposite
  CHECK_FALSE(scene_of(Bearing<>{Vector3::Zero(), {}, 1e-6}, PoseState(), beacon).has_innovation());
  CHECK_FALSE(scene_of(Bearing<>{Vector3(0, 0, -1), {}, 1e-6}, PoseState(), Vector3::Zero()).has_innovation());
}

TEST_CASE_TEMPLATE("plane sighting: Jacobians and turned world, from the body and from the room", Mount, SensorOnBody,
                   SensorInRoom) {
  constexpr bool on_body = std::is_same_v<Mount, SensorOnBody>;
  const auto make = [](std::mt19937& random) {
    Scene<PlaneSighting<Mount>> scene{{}, random_state(random), random_vector(random, on_body ? 3.0 : 0.2)};
    scene.measurement = {random_vector(random), Mount{random_pose(random)}, 1e-4};
    return scene;
  };
  const auto turn = [](PlaneSighting<Mount>& plane, const Quaternion& q) {
    if constexpr (!on_body) plane.sensor.X_WS = Rigid::rotation(q) * plane.sensor.X_WS;
  };
  const WorldBlocks blocks = on_body ? WorldBlocks{{0}, {}, {}} : WorldBlocks{{}, {}, {}};
  check_measurement(6, blocks, make, turn, [](PlaneSighting<Mount>& plane) { plane.normal_S.x() = nan_value; });
}

TEST_CASE("plane sighting: the residual is the angle under the plane") {
  // A linear CCD whose plane is upright and 20 degrees to the left of straight ahead; the beacon stands at 30 degrees.
  const auto to_the_left = [](double angle) { return Vector3(-sin(degrees(angle)), 0, -cos(degrees(angle))); };
  const Vector3 normal = to_the_left(20.0).cross(Vector3(0, 1, 0));  // points to the right
  const auto residual = [&](const Vector3& beacon) {
    return scene_of(PlaneSighting<>{normal, {}, 1e-6}, PoseState(), beacon).linearized().residual[0];
  };
  CHECK(residual(4.0 * to_the_left(30.0)) == Approx(degrees(10.0).radians()).epsilon(1e-13));
  CHECK(residual(4.0 * to_the_left(15.0)) == Approx(-degrees(5.0).radians()).epsilon(1e-13));
  CHECK(std::abs(residual(4.0 * to_the_left(20.0) + Vector3(0, 1.5, 0))) < 1e-15);  // as high as it likes
  CHECK_FALSE(scene_of(PlaneSighting<>{normal, {}, 1e-6}, PoseState(), Vector3(2.0 * normal)).has_innovation());
  CHECK_FALSE(scene_of(PlaneSighting<>{Vector3::Zero(), {}, 1e-6}, PoseState(), Vector3(1, 0, 0)).has_innovation());
}

TEST_CASE("pose, position, orientation: Jacobians and turned world") {
  const auto near = [](const Rigid& X, std::mt19937& random) {
    const Vector3 axis = random_vector(random).normalized();
    return Rigid(X.q() * so3::exp<double>(uniform(random, 0.0, 2.5) * axis), X.p() + random_vector(random));
  };
  Matrix3 ball;  // alike in all directions: the world may turn it
  ball = 1e-4 * Matrix3::Identity();
  const auto turn_pose = [](PoseMeasurement& pose, const Quaternion& q) { pose.X_WB = Rigid::rotation(q) * pose.X_WB; };
  check_measurement(
      7, {{}, {}, {0}},
      [&](std::mt19937& random) {
        const PoseState state = random_state(random);
        return scene_of(PoseMeasurement{near(state.X_WB, random), 1e-4 * Matrix6::Identity()}, state);
      },
      turn_pose, [](PoseMeasurement& pose) { pose.X_WB = Rigid(pose.X_WB.q(), Vector3(0, nan_value, 0)); });
  check_measurement(
      8, {{}, {}, {0}},
      [&](std::mt19937& random) {
        const PoseState state = random_state(random);
        return scene_of(PositionMeasurement{near(state.X_WB, random).p(), random_vector(random, 0.2), ball}, state);
      },
      [](PositionMeasurement& position, const Quaternion& q) { position.p_W = q * position.p_W; },
      [](PositionMeasurement& position) { position.p_W.x() = nan_value; });
  check_measurement(
      9, {{}, {}, {}},
      [&](std::mt19937& random) {
        const PoseState state = random_state(random);
        return scene_of(OrientationMeasurement{near(state.X_WB, random).q(), ball}, state);
      },
      [](OrientationMeasurement& orientation, const Quaternion& q) { orientation.q_WB = q * orientation.q_WB; },
      [](OrientationMeasurement& orientation) { orientation.q_WB.x() = nan_value; });
}

TEST_CASE("pose: the residual is the error of the state, by the shorter way round") {
  std::mt19937 random(10);
  for (int trial = 0; trial < 20; ++trial) {
    PoseState state = random_state(random);
    PoseState truth = state;
    PoseState::Error d = PoseState::Error::Zero();
    d.head<6>() << random_vector(random), random_vector(random, 0.8);
    truth.add(d);
    Quaternion flipped = truth.X_WB.q();
    flipped.coeffs() *= -1.0;  // the same orientation
    const Rigid measured = trial % 2 ? truth.X_WB : Rigid(flipped, truth.X_WB.p());
    const Vector6 residual = scene_of(PoseMeasurement{measured, Matrix6::Identity()}, state).linearized().residual;
    if (d.segment<3>(3).norm() > 3.1) continue;  // beyond half a turn the other way is shorter
    CHECK((residual - d.head<6>()).cwiseAbs().maxCoeff() < 1e-13);
  }
}

TEST_CASE("angular rate: Jacobians, turned world, axes and bias") {
  const auto make = [](std::mt19937& random) {
    return scene_of(AngularRate{random_vector(random), so3::exp<double>(random_vector(random)), 1e-4},
                    random_state<2>(random), {}, random_vector(random, 0.1));
  };
  check_measurement(11, {{}, {}, {}}, make, turn_nothing, [](AngularRate& rate) { rate.rate_S.z() = nan_value; });
  // The sensor's x points along B's y: it feels there what B's turn about y is.
  TargetState<2> state;
  state.velocity.w_WB_B = Vector3(0.1, 0.2, 0.3);
  const Quaternion q_BS = so3::exp<double>(Vector3(0, 0, std::numbers::pi / 2));
  const Linearization<AngularRate> linear =
      scene_of(AngularRate{Vector3(0.25, -0.1, 0.3), q_BS, 1.0}, state, {}, Vector3(0.04, 0, 0)).linearized();
  CHECK((linear.residual - Vector3(0.01, 0, 0)).norm() < 1e-15);
}

TEST_CASE("specific force: Jacobians, turned world, gravity and swing") {
  const auto make = [](std::mt19937& random) {
    SpecificForce force{random_vector(random, 10.0), random_pose(random), random_vector(random, 6.0), 1e-2};
    return scene_of(force, random_state<3>(random), {}, random_vector(random, 0.1));
  };
  check_measurement(
      12, {{}, {}, {}}, make, [](SpecificForce& force, const Quaternion& q) { force.gravity_W = q * force.gravity_W; },
      [](SpecificForce& force) { force.force_S.y() = nan_value; });

  const auto felt = [](const TargetState<3>& state, const Rigid& X_BS) {
    return Vector3(-scene_of(SpecificForce{Vector3::Zero(), X_BS}, state).linearized().residual);
  };
  CHECK((felt({}, Rigid()) - Vector3(0, standard_gravity, 0)).norm() < 1e-15);  // at rest the floor pushes up
  TargetState<3> falling;
  falling.acceleration.a_WB = Vector3(0, -standard_gravity, 0);
  CHECK(felt(falling, Rigid()).norm() < 1e-15);
  // Rolled to the right by a quarter turn, up is to the left.
  TargetState<3> rolled;
  rolled.X_WB = Rigid::rotation(so3::exp<double>(Vector3(0, 0, -std::numbers::pi / 2)));
  CHECK((felt(rolled, Rigid()) - Vector3(-standard_gravity, 0, 0)).norm() < 1e-14);
  // 0.5 m out on a turntable of 2 rad/s that speeds up by 3 rad/s^2: 2 m/s^2 inwards, 1.5 m/s^2 along the turn.
  TargetState<3> turntable;
  turntable.velocity.w_WB_B = Vector3(0, 2, 0);
  turntable.acceleration.alpha_WB_B = Vector3(0, 3, 0);
  CHECK((felt(turntable, Rigid::translation(Vector3(0.5, 0, 0))) - Vector3(-2, standard_gravity, -1.5)).norm() < 1e-14);
}

TEST_CASE("dipole: Jacobians, turned world, the field of 000 section 3.1.3") {
  const auto make = [](std::mt19937& random) {
    DipoleSighting sighting{random_vector(random), random_pose(random), 1e-4};
    Vector6 coil;
    coil << random_vector(random, 0.3), random_vector(random, 5.0);
    Scene<DipoleSighting> scene = scene_of(sighting, random_state(random), coil);
    // Not nearer than half a metre, where differences of r^-4 are still good.
    const Vector3 receiver = scene.state.X_WB * sighting.X_BS.p();
    const Vector3 away = receiver - scene.source.head<3>();
    if (away.norm() < 0.5) scene.source.head<3>() = receiver - 0.5 * away.normalized();
    return scene;
  };
  check_measurement(13, {{0, 1}, {}, {}}, make, turn_nothing,
                    [](DipoleSighting& sighting) { sighting.field_S.x() = nan_value; });

  const double M = 2.5;
  const double d = 0.7;
  for (const double angle : {0.0, 30.0, 90.0, 144.0}) {
    CAPTURE(angle);
    const Vector3 radial(sin(degrees(angle)), 0, cos(degrees(angle)));
    const Vector3 tangential(cos(degrees(angle)), 0, -sin(degrees(angle)));
    const DipoleField field(d * radial, Vector3(0, 0, M));
    const double k = M / (4.0 * std::numbers::pi * d * d * d);
    CHECK((field.H - 2.0 * k * cos(degrees(angle)) * radial - k * sin(degrees(angle)) * tangential).norm() < 1e-15);
  }
  Vector6 coil = Vector6::Unit(5);
  CHECK(scene_of(DipoleSighting{}, state_at(Rigid::translation(Vector3(0, 0, 0.06))), coil).has_innovation());
  CHECK_FALSE(scene_of(DipoleSighting{}, state_at(Rigid::translation(Vector3(0, 0, 0.04))), coil).has_innovation());
}

TEST_CASE("dipole: three coils, one after the other, give the pose") {
  std::mt19937 random(14);
  const Rigid X_WB(so3::exp<double>(Vector3(0.3, -0.2, 0.5)), Vector3(0.6, 0.3, -0.4));
  PoseState state =
      state_at(Rigid(X_WB.q() * so3::exp<double>(Vector3(4e-3, -3e-3, 5e-3)), X_WB.p() + Vector3(2e-3, 1e-3, -2e-3)));
  state.P = 1e-5 * PoseState::Covariance::Identity();
  for (int i = 0; i < 60; ++i) {
    DeviceEstimate<6> coil;
    coil.x.tail<3>() = 10.0 * Vector3::Unit(i % 3);
    const Vector3 field = DipoleField(X_WB.p(), coil.x.tail<3>()).H;
    const DipoleSighting sighting{X_WB.q().conjugate() * field, Rigid(), 1e-6};
    const auto innovation = extended_innovation(state, sighting, coil);
    REQUIRE(innovation);
    NoDevice none;
    correct(state, *innovation, coil, none);
  }
  // The measurements are exact. What is left is the first steps' curvature, of 0.007 rad squared, spread over 60.
  CHECK((state.X_WB.p() - X_WB.p()).norm() < 1e-5);
  CHECK(so3::angle_between(state.X_WB.q(), X_WB.q()) < 2e-5);
}

TEST_CASE("joint angles: Jacobians and turned world of a six-jointed arm") {
  std::array<JointArm<6>, 40> arms;
  std::array<JointArm<6>, 40> turned_arms;
  int made = 0;
  const auto make = [&](std::mt19937& random) {
    JointArm<6>& arm = arms[made++];
    for (RevoluteJoint& joint : arm.joints) joint = {random_vector(random).normalized(), random_vector(random, 0.4)};
    arm.X_WB_at_zero = random_pose(random);
    JointAngles<6> angles;
    for (int i = 0; i < 6; ++i) angles.angles[i] = uniform(random, -2.0, 2.0);
    angles.arm = &arm;
    angles.variance = 1e-6;
    angles.flex = 1e-8 * Matrix6::Identity();
    PoseState state = random_state(random);
    const Vector3 off = uniform(random, 0.0, 2.0) * random_vector(random).normalized();
    state.X_WB = arm.end(angles.angles).X_WB * Rigid(so3::exp<double>(off), random_vector(random, 0.3));
    VectorOf<double, 6> offsets;
    for (int i = 0; i < 6; ++i) offsets[i] = uniform(random, -0.1, 0.1);
    return scene_of(angles, state, {}, offsets);
  };
  const auto turn = [&](JointAngles<6>& angles, const Quaternion& q) {
    JointArm<6>& turned = turned_arms[made - 1];
    turned = *angles.arm;
    for (RevoluteJoint& joint : turned.joints) joint = {q * joint.axis_W, q * joint.point_W};
    turned.X_WB_at_zero = Rigid::rotation(q) * angles.arm->X_WB_at_zero;
    angles.arm = &turned;
  };
  check_measurement(15, {{}, {}, {0}}, make, turn, [](JointAngles<6>& angles) { angles.angles[3] = nan_value; });
}

TEST_CASE("joint angles: two links in a plane") {
  // Upper link 0.3 m along x, lower link 0.2 m; both joints turn about z.
  JointArm<2> arm;
  arm.joints = {RevoluteJoint{Vector3(0, 0, 1), Vector3(0, 0, 0)}, RevoluteJoint{Vector3(0, 0, 1), Vector3(0.3, 0, 0)}};
  arm.X_WB_at_zero = Rigid::translation(Vector3(0.5, 0, 0));
  const double a = 0.7;
  const double b = -1.1;
  const Rigid end = arm.end(Vector2(a, b)).X_WB;
  const Vector3 expected(0.3 * std::cos(a) + 0.2 * std::cos(a + b), 0.3 * std::sin(a) + 0.2 * std::sin(a + b), 0);
  CHECK((end.p() - expected).norm() < 1e-15);
  CHECK((so3::log<double>(end.q()) - Vector3(0, 0, a + b)).norm() < 1e-15);

  // The second joint reads 0.1 rad too much; with that offset the arm ends where the body is.
  JointAngles<2> angles;
  angles.angles = Vector2(a, b + 0.1);
  angles.arm = &arm;
  angles.variance = 4e-6;
  angles.flex = 1e-10 * Matrix6::Identity();
  const Linearization<JointAngles<2>> linear = scene_of(angles, state_at(end), {}, Vector2(0.0, 0.1)).linearized();
  CHECK(linear.residual.norm() < 1e-15);
  // About z both angles count alike, across the plane only the links' flex does.
  CHECK(linear.R(5, 5) == Approx(8e-6 + 1e-10).epsilon(1e-12));
  CHECK(linear.R(2, 2) == Approx(1e-10).epsilon(1e-12));
}

TEST_CASE("pinhole sighting: Jacobians, turned world, refusals") {
  const auto make = [](std::mt19937& random) {
    PinholeSighting sighting{Vector2(1e-3, -2e-3), Rigid(), 0.037, 1e-10};
    sighting.X_BC = Rigid(so3::exp<double>(random_vector(random)), random_vector(random, 0.03));
    VectorOf<double, 7> c;
    c << 1e-3, random_vector(random, 0.01), random_vector(random, 0.2);
    const PoseState state = random_state(random);
    const Rigid X_BC_now(sighting.X_BC.q() * so3::exp<double>(Vector3(c.tail<3>())),
                         sighting.X_BC.p() + c.segment<3>(1));
    const Vector3 in_view(uniform(random, -0.4, 0.4), uniform(random, -0.4, 0.4), uniform(random, -3.0, -1.0));
    return scene_of(sighting, state, Vector3(state.X_WB * (X_BC_now * in_view)), c);
  };
  check_measurement(16, {{0}, {}, {}}, make, turn_nothing,
                    [](PinholeSighting& sighting) { sighting.uv.x() = nan_value; });
  const PinholeSighting sighting{Vector2::Zero(), Rigid(), 0.037, 1e-10};
  CHECK(scene_of(sighting, PoseState(), Vector3(0, 0, -1)).has_innovation());
  CHECK_FALSE(scene_of(sighting, PoseState(), Vector3(0, 0, 1)).has_innovation());  // behind
  VectorOf<double, 7> c = VectorOf<double, 7>::Zero();
  c[0] = -0.04;
  CHECK_FALSE(scene_of(sighting, PoseState(), Vector3(0, 0, -1), c).has_innovation());  // no focal distance is left
  c[0] = nan_value;
  CHECK_FALSE(scene_of(sighting, PoseState(), Vector3(0, 0, -1), c).has_innovation());
}

TEST_CASE("pinhole sighting: at its nominal values it is a camera sighting") {
  std::mt19937 random(17);
  for (int trial = 0; trial < 20; ++trial) {
    PinholeSighting pinhole{Vector2(1e-3, 2e-3), random_pose(random), 0.037, 1e-10};
    const PoseState state = random_state(random);
    const Vector3 beacon = state.X_WB * (pinhole.X_BC * Vector3(0.2, -0.3, -2));
    const CameraView camera = pinhole.camera(VectorOf<double, 7>::Zero());
    const auto expected = scene_of(CameraSighting{pinhole.uv, &camera, 1e-10}, state, beacon).linearized();
    const auto linear = scene_of(pinhole, state, beacon).linearized();
    CHECK((linear.residual - expected.residual).norm() < 1e-15);
    CHECK((linear.H - expected.H).norm() < 1e-15);
    CHECK((linear.H_source - expected.H_source).norm() < 1e-15);
  }
}

TEST_CASE("pinhole sighting: a camera's seven numbers are learnt from known beacons") {
  std::mt19937 random(18);
  VectorOf<double, 7> truth;
  truth << 4e-4, 2e-3, -1e-3, 1.5e-3, 0.01, -0.02, 0.015;
  PinholeSighting sighting{Vector2::Zero(), Rigid(), 0.037, 1e-12};
  const CameraView camera = sighting.camera(truth);
  PoseState state;
  state.P *= 1e-14;  // the body is held still where it is known
  DeviceEstimate<7> learnt;
  learnt.P.diagonal() << 1e-6, 1e-5, 1e-5, 1e-5, 1e-3, 1e-3, 1e-3;
  for (int i = 0; i < 400; ++i) {
    DeviceEstimate<3> beacon;
    const double depth = uniform(random, 0.4, 3.0);
    beacon.x = Vector3(depth * uniform(random, -0.5, 0.5), depth * uniform(random, -0.5, 0.5), -depth);
    sighting.uv = *camera.project(beacon.x);
    const auto innovation = extended_innovation(state, sighting, beacon, learnt);
    REQUIRE(innovation);
    beacon.locked = true;
    correct(state, *innovation, beacon, learnt);
  }
  // Sightings are exact; what remains is what the first steps' curvature left behind, far below one sighting's micrometre.
  CHECK((learnt.x - truth).head<4>().cwiseAbs().maxCoeff() < 1e-5);
  CHECK((learnt.x - truth).tail<3>().cwiseAbs().maxCoeff() < 1e-5);
  CHECK(std::sqrt(learnt.P(0, 0)) < 1e-6);
}
