#include <algorithm>

#include <doctest/doctest.h>

#include <holdfast/motion/test_signals.hpp>
#include <holdfast/prediction/azuma_bishop_prediction.hpp>
#include <holdfast/prediction/state_prediction.hpp>

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
