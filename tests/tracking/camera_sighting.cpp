#include <random>

#include <doctest/doctest.h>

#include <holdfast/geometry/numeric_jacobian.hpp>
#include <holdfast/tracking/advance.hpp>
#include <holdfast/tracking/camera_sighting.hpp>
#include <holdfast/tracking/innovation.hpp>

#include "random_values.hpp"

using namespace holdfast;
using namespace holdfast::test;

TEST_CASE("camera sighting: Jacobians by state and beacon are central differences") {
  std::mt19937 random(1);
  for (int trial = 0; trial < 50; ++trial) {
    const Rigid X_BC(so3::exp<double>(random_vector(random, 1.0)), random_vector(random, 0.03));
    const CameraView camera{view_matrix(X_BC, 0.037)};
    TargetState<2> state;
    state.X_WB = Rigid(so3::exp<double>(random_vector(random, 1.0)), random_vector(random, 1.0));
    const Vector3 beacon = state.X_WB * (X_BC * Vector3(0.05, -0.08, -2.0));
    CameraSighting sighting{Vector2(1e-3, -2e-3), &camera, 1e-12};
    Linearization<CameraSighting> linear;
    REQUIRE(sighting.linearize(state, beacon, {}, linear));
    const auto residual_after = [&](const VectorOf<double, 9>& d) {
      TargetState<2> moved = state;
      TargetState<2>::Error error = TargetState<2>::Error::Zero();
      error.head<6>() = d.head<6>();
      moved.add(error);
      Linearization<CameraSighting> l;
      REQUIRE(sighting.linearize(moved, beacon + d.tail<3>(), {}, l));
      return l.residual;
    };
    const MatrixOf<double, 2, 9> J = numeric_jacobian(residual_after, VectorOf<double, 9>(VectorOf<double, 9>::Zero()));
    // Elements are about focal / distance, 0.02; differences of them are good to 1e-10.
    CHECK((J.leftCols<6>() + linear.H).cwiseAbs().maxCoeff() < 1e-9);
    CHECK((J.rightCols<3>() + linear.H_source).cwiseAbs().maxCoeff() < 1e-9);
  }
}

TEST_CASE("a filter that takes one sighting at a time finds the pose") {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> place(-1.0, 1.0);
  const CameraView camera{view_matrix(Rigid(), 0.037)};
  const Rigid X_WB(so3::exp<double>(Vector3(0.1, -0.2, 0.3)), Vector3(0.2, 0.1, 0.4));
  TargetState<2> state;
  state.X_WB = Rigid(so3::exp<double>(Vector3(0.1005, -0.2005, 0.2995)), Vector3(0.2005, 0.0995, 0.4005));
  state.P *= 1e-6;
  ProcessModel<2> model;
  model.intensity.setConstant(1e-6);
  for (int i = 0; i < 300; ++i) {
    advance(state, model, time_at(0.001 * i));
    DeviceEstimate<3> beacon;
    beacon.x = X_WB * Vector3(0.8 * place(random), 0.8 * place(random), -2.0 + 0.5 * place(random));
    const CameraSighting sighting{*camera.project(X_WB.inverse() * beacon.x), &camera, 1e-12};
    const auto innovation = extended_innovation(state, sighting, beacon);
    REQUIRE(innovation);
    NoDevice none;
    beacon.locked = true;
    correct(state, *innovation, beacon, none);
  }
  // The sightings are exact; one's stated deviation is 54 micrometres at 2 m, and hundreds of them pull from all sides.
  CHECK((state.X_WB.p() - X_WB.p()).norm() < 2e-5);
  CHECK(so3::angle_between(state.X_WB.q(), X_WB.q()) < 2e-5);
}
