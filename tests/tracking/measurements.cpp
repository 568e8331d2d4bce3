// Jacobians against central differences, a turned world, values known in closed form, refusals: ranges, bearings, planes, poses.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <doctest/doctest.h>
#include <tracking/measurement_checks.hpp>

#include <holdfast/geometry/angle.hpp>
#include <holdfast/tracking/bearing.hpp>
#include <holdfast/tracking/camera_sighting.hpp>
#include <holdfast/tracking/phase_range.hpp>
#include <holdfast/tracking/pose_measurement.hpp>
#include <holdfast/tracking/range.hpp>

#include "random_values.hpp"

using namespace holdfast;
using namespace holdfast::test;
using doctest::Approx;

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
