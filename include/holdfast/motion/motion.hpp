/// The interface of every motion whose truth is known at any time: recordings, splines and generators.
///
/// Frames: W is the world (right-handed, +Y up), B the moving body. v_WB and a_WB are velocity and acceleration of B's
/// origin in W, expressed in W (m/s, m/s^2). w_WB_B and alpha_WB_B are B's angular velocity and angular acceleration
/// against W, expressed in B (rad/s, rad/s^2): d/dt R_WB = R_WB hat(w_WB_B) and alpha_WB_B = d/dt w_WB_B.
#pragma once

#include <algorithm>

#include <holdfast/geometry/rigid.hpp>
#include <holdfast/timing/clock.hpp>

namespace holdfast {

struct MotionState {
  HostTime t;
  Rigid X_WB;
  Vector3 v_WB = Vector3::Zero();
  Vector3 a_WB = Vector3::Zero();
  Vector3 w_WB_B = Vector3::Zero();
  Vector3 alpha_WB_B = Vector3::Zero();
};

class Motion {
 public:
  virtual ~Motion() = default;

  /// State at time t. Outside [begin(), end()] the state is the nearer end's; its `t` says which time was answered.
  [[nodiscard]] virtual MotionState at(HostTime t) const = 0;
  [[nodiscard]] virtual HostTime begin() const = 0;
  [[nodiscard]] virtual HostTime end() const = 0;

  [[nodiscard]] Duration duration() const { return end() - begin(); }

 protected:
  [[nodiscard]] HostTime clamped(HostTime t) const { return std::clamp(t, begin(), end()); }
};

}  // namespace holdfast
