// Jacobians against central differences, a turned world, values known in closed form, refusals: inertial, magnetic,
// mechanical and camera sensors.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <doctest/doctest.h>
#include <tracking/measurement_checks.hpp>

#include <holdfast/geometry/angle.hpp>
#include <holdfast/tracking/camera_sighting.hpp>
#include <holdfast/tracking/dipole_field.hpp>
#include <holdfast/tracking/inertial_measurement.hpp>
#include <holdfast/tracking/joint_angles.hpp>
#include <holdfast/tracking/pinhole_sighting.hpp>

#include "random_values.hpp"

using namespace holdfast;
using namespace holdfast::test;
using doctest::Approx;

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
