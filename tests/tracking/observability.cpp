// Whether the measurements made tell everything.
#include <cmath>

#include <doctest/doctest.h>
#include <tracking/camera_ball.hpp>

#include <holdfast/tracking/camera_sighting.hpp>
#include <holdfast/tracking/observability.hpp>
#include <holdfast/tracking/pose_measurement.hpp>

using namespace holdfast;
using doctest::Approx;

namespace {

ProcessModel<1> p_model() {
  return {};
}

Linearization<CameraSighting> linearized(const TargetState<1>& state, const CameraView& camera,
                                         const Vector3& beacon_W) {
  Linearization<CameraSighting> linear;
  const CameraSighting sighting{Vector2::Zero(), &camera, 1e-12};
  REQUIRE(sighting.linearize(state, beacon_W, {}, linear));
  return linear;
}

}  // namespace

TEST_CASE("observability: one beacon again and again gives two constraints, several in two views all six") {
  const test::Ball ball;
  TargetState<1> state;
  ObservabilityWindow<1> window(p_model());
  const auto ahead = [&](std::size_t view, double right) {  // 2 m before a view's camera
    return Vector3(ball.X_BC[view] * Vector3(right, 0.3 * right, -2.0));
  };
  for (int i = 0; i < 20; ++i) {
    state.t = time_at(0.001 * i);
    REQUIRE(window.add(state, linearized(state, ball.views[0], ahead(0, 0.0))));
  }
  Observability<1> found = window.report();
  CHECK(found.rank == 2);
  CHECK(found.measurements == 20);
  CHECK_FALSE(found.complete());
  CHECK(std::isinf(found.condition()));
  CHECK(found.unobservable_part.sum() == Approx(4.0));
  CHECK(std::ranges::count(found.unobservable(), '\n') == 4);

  window.clear();
  for (const double right : {-0.1, 0.0, 0.1})
    REQUIRE(window.add(state, linearized(state, ball.views[0], ahead(0, right))));
  found = window.report();
  const double one_view = found.condition();
  // Three points of one narrow view in a line: what turns about that line is hidden.
  CHECK(found.rank == 5);
  window.clear();
  for (const std::size_t view : {std::size_t(0), std::size_t(5)}) {
    for (const double right : {-0.1, 0.0, 0.1}) {
      REQUIRE(window.add(state, linearized(state, ball.views[view], ahead(view, right))));
    }
  }
  found = window.report();
  CHECK(found.complete());
  CHECK(found.unobservable().empty());
  CHECK(found.condition() < one_view);
  MESSAGE("condition of two views: " << found.condition());
}

TEST_CASE("observability: directions are named, and the bounds are those of the sum") {
  ObservabilityWindow<1> window(p_model());
  TargetState<1> state;
  PositionMeasurement position;
  position.covariance = 0.01 * Matrix3::Identity();
  Linearization<PositionMeasurement> linear;
  REQUIRE(position.linearize(state, {}, {}, linear));
  for (int i = 0; i < 5; ++i) REQUIRE(window.add(state, linear));
  Observability<1> found = window.report();
  CHECK(found.rank == 3);
  CHECK(found.eigenvalues[5] == Approx(500.0));  // five of variance 0.01
  CHECK(found.eigenvalues[3] == Approx(500.0));
  CHECK((found.unobservable_part - (Vector6() << 0, 0, 0, 1, 1, 1).finished()).norm() < 1e-12);
  CHECK(found.unobservable().find("turn about x") != std::string::npos);
  CHECK(found.unobservable().find("position") == std::string::npos);

  // At the end of a lever along x, turns about x alone stay hidden.
  position.lever_B = Vector3(1.0, 0.0, 0.0);
  REQUIRE(position.linearize(state, {}, {}, linear));
  for (int i = 0; i < 5; ++i) REQUIRE(window.add(state, linear));
  found = window.report();
  CHECK(found.rank == 5);
  CHECK(found.describe(0) == "1.00 turn about x");

  linear.R(0, 0) = -1.0;
  CHECK_FALSE(window.add(state, linear));
  state.t = time_at(-1.0);
  linear.R(0, 0) = 0.01;
  CHECK_FALSE(window.add(state, linear));
  CHECK(window.report().measurements == 10);
}

TEST_CASE("observability: with time velocities are observable, and errors are carried back as eq. 5.3 says") {
  PvModel model;
  ObservabilityWindow<2> window(model);
  TargetState<2> state;
  state.velocity = {Vector3(0.1, 0.2, -0.3), Vector3(0.5, -0.4, 0.8)};
  PoseMeasurement pose;
  pose.covariance = 1e-6 * Matrix6::Identity();
  std::vector<TargetState<2>> states;
  std::vector<Linearization<PoseMeasurement>> linears;
  for (int i = 0; i < 10; ++i) {
    advance(state, model, time_at(0.01 * i));
    pose.X_WB = state.X_WB;
    Linearization<PoseMeasurement> linear;
    REQUIRE(pose.linearize(state, {}, {}, linear));
    REQUIRE(window.add(state, linear));
    states.push_back(state);
    linears.push_back(linear);
    if (i == 0) {
      const Observability<2> first = window.report();
      CHECK(first.rank == 6);
      CHECK(first.unobservable().find("velocity z") != std::string::npos);
      CHECK(first.unobservable().find("turning about x") != std::string::npos);
      CHECK(first.unobservable().find("position") == std::string::npos);
    }
  }
  const Observability<2> found = window.report();
  CHECK(found.rank == 12);
  CHECK(found.condition() < 1e3);  // scaled by the window's time: no small velocities against large positions
  Matrix12 sum = Matrix12::Zero();
  for (std::size_t i = 0; i < states.size(); ++i) {
    const Matrix12 back = state_transition(states[i], model, states.back().t).inverse();
    const MatrixOf<double, 6, 12> H = linears[i].H * back.topRows<6>();
    sum += H.transpose() * linears[i].R.inverse() * H;
  }
  CHECK((window.information() - sum).norm() < 1e-9 * sum.norm());
  CHECK(Observability<3>::error_name(13) == "acceleration y");
}
