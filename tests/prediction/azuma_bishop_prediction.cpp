#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <numbers>

#include <doctest/doctest.h>

#include <holdfast/motion/test_signals.hpp>
#include <holdfast/prediction/azuma_bishop_prediction.hpp>
#include <holdfast/prediction/prediction_distance.hpp>
#include <holdfast/prediction/predictor_theory.hpp>
#include <holdfast/prediction/state_prediction.hpp>
#include <holdfast/simulation/inertial_sensor.hpp>
#include <holdfast/tracking/azuma_bishop_filter.hpp>

using namespace holdfast;
using namespace std::chrono_literals;

namespace {

TargetState<3> some_state() {
  TargetState<3> state;
  state.t = time_at(3.0);
  state.X_WB = Rigid(so3::exp<double>(Vector3(0.4, -1.2, 0.3)), Vector3(1.0, 2.0, 3.0));
  state.velocity = {Vector3(0.5, -0.2, 0.1), Vector3(1.0, 2.0, -1.5)};
  state.acceleration = {Vector3(2.0, -1.0, 3.0), Vector3(10.0, -20.0, 5.0)};
  state.P = 1e-4 * TargetState<3>::Covariance::Identity();
  return state;
}

}  // namespace

TEST_CASE("001's closed form is what predict_state makes of an undamped PVA model") {
  const TargetState<3> state = some_state();
  PvaModel model;
  model.intensity << 2e6, 2e6, 2e6, 351.0, 351.0, 351.0;
  for (const Duration interval : {Duration(0), Duration(1us), Duration(20ms), Duration(60ms), Duration(100ms)}) {
    const Rigid printed = azuma_bishop_pose(state, to_seconds(interval));
    const Rigid ours = predict_state(state, model, state.t + interval).X_WB;
    CHECK((printed.p() - ours.p()).norm() < 1e-14);
    CHECK(so3::angle_between<double>(printed.q(), ours.q()) < 1e-14);
  }
}

TEST_CASE("001's closed form solves Q' = Q (0, w) / 2 for a fixed axis, and leaves out T^3 |w x w'| / 12 otherwise") {
  TargetState<3> state = some_state();
  for (const bool one_axis : {true, false}) {
    if (one_axis) state.acceleration.alpha_WB_B = 8.0 * state.velocity.w_WB_B;
    if (!one_axis) state.acceleration.alpha_WB_B = Vector3(10.0, -20.0, 5.0);
    const double T = 0.06;
    Quaternion q = state.X_WB.q();
    constexpr int steps = 6000;
    for (int i = 0; i < steps; ++i) {  // midpoint
      const double t = T * (i + 0.5) / steps;
      const Vector3 turn = T / steps * (state.velocity.w_WB_B + t * state.acceleration.alpha_WB_B);
      q = (q * so3::exp<double>(turn)).normalized();
    }
    const double error = so3::angle_between<double>(q, azuma_bishop_pose(state, T).q());
    const double magnus = T * T * T * state.velocity.w_WB_B.cross(state.acceleration.alpha_WB_B).norm() / 12.0;
    CHECK(std::abs(error - magnus) < 0.05 * magnus + 1e-9);  // the next terms are T |w| of it
    if (!one_axis) CHECK(magnus > 1e-4);
  }
}

// evaluation.md, value 3: what extrapolation at constant acceleration makes of a sinusoid, from exact derivatives.
TEST_CASE("constant acceleration: gains within 1 % of theory, and worse than none above 6.1 Hz at 60 ms") {
  const double T = 0.06;
  for (const double hz : {0.2, 1.0, 2.0, 4.0, 5.5, 6.0, 6.2, 7.0, 10.0}) {
    const auto motion = make_yaw_sine(hz, degrees(2.0), from_seconds(10.0 / hz));
    // The predicted yaw's part at this frequency, over whole periods, and its mean square error and that of none.
    std::complex<double> predicted = 0.0, present = 0.0;
    double error = 0.0, held = 0.0;
    constexpr int count = 900;
    for (int i = 0; i < count; ++i) {
      const double t = (i + 0.5) / count * 9.0 / hz;
      const MotionState s = motion->at(time_at(t));
      const auto yaw_of = [](const Quaternion& q) { return so3::log<double>(q).y(); };
      const double yaw = yaw_of(azuma_bishop_orientation(s.X_WB.q(), s.w_WB_B, s.alpha_WB_B, T));
      const double truth = degrees(2.0).radians() * std::sin(2.0 * std::numbers::pi * hz * (t + T));
      const std::complex<double> wave = std::polar(1.0, -2.0 * std::numbers::pi * hz * t);
      predicted += yaw * wave;
      present += yaw_of(s.X_WB.q()) * wave;
      error += (yaw - truth) * (yaw - truth);
      held += (yaw_of(s.X_WB.q()) - truth) * (yaw_of(s.X_WB.q()) - truth);
    }
    const double gain = std::abs(predicted) / std::abs(present);
    CHECK(gain == doctest::Approx(theory::gain(theory::Order::constant_acceleration, hz, T)).epsilon(0.01));
    CHECK((error > held) == (hz > 6.1));  // f T = 0.365
  }
}

TEST_CASE("the page's example of Azuma and Bishop's filters") {
  const InertialUnit unit = azuma_bishop_inertial_unit();
  const TimedPose pose{time_at(1.0), Rigid()};
  InertialReading reading;
  reading.t = pose.t;
  reading.force_B = standard_gravity * Vector3::UnitY();

  AzumaBishopSettings settings;
  settings.accelerometers_S = unit.accelerometers_S;  // where the accelerometers sit; biases and scales too
  AzumaBishopFilter filter(settings);
  filter.update(pose, reading);                           // or filter.update(pose): without inertial sensors
  Rigid X_WH = azuma_bishop_pose(filter.state(), 0.060);  // 60 ms ahead, in closed form
  CHECK(X_WH.p().norm() < 1e-12);
}

TEST_CASE("the page's example of the prediction distance") {
  FramePlanSettings settings;
  const HostTime measured = time_at(1.0), now = time_at(1.005), scan_out_start = time_at(1.1);
  const Duration took = 3ms;
  const auto draw = [&](HostTime t) { CHECK(t > now); };
  PredictionDistance distance(settings);  // FramePlanSettings: the display, and a first guess
  if (const auto plan = distance.plan(measured, now)) {
    draw(plan->middle_of_scan_out);  // predict for that
    distance.computed(took);
    distance.shown(*plan, scan_out_start);  // once it is known
  }
  CHECK(distance.errors().wrong_share() == 1.0);
  if (distance.errors().wrong_share() > 0.05) std::puts("one distance in twenty is wrong by a refresh");
}
