/// A motion written as a formula of time: three angles and a position, with exact derivatives.
///
/// R_WB = R_y(yaw) R_x(pitch) R_z(roll): yaw about the world's up, then pitch about the head's right, then roll about
/// the head's back (+Z). Angles in radians, position in metres in W; all zero looks along -Z. The angular velocity
/// follows from the angles' rates, joint by joint: w_WB_B = R_z^T (R_x^T yaw' e_y + pitch' e_x) + roll' e_z, and
/// alpha_WB_B by differentiating that. Bad input: a formula that yields a non-finite number is the author's error.
#pragma once

#include <functional>
#include <utility>

#include <holdfast/assert.hpp>
#include <holdfast/motion/jet.hpp>
#include <holdfast/motion/motion.hpp>

namespace holdfast {

struct HeadCurve {
  Jet yaw, pitch, roll;
  Jet x, y, z;
};

namespace detail {

/// Adds one joint of angle q about a unit axis to the chain: the rates so far, seen from behind the joint, and the
/// joint's own.
inline void append_joint(const Jet& angle, const Vector3& axis, Quaternion& q, Vector3& w, Vector3& alpha) {
  const Vector3 rotation = axis * angle.value;
  const Quaternion joint = so3::exp<double>(rotation);
  const Vector3 w_in = joint.conjugate() * w;
  const Vector3 alpha_in = joint.conjugate() * alpha;
  q = q * joint;
  w = w_in + axis * angle.rate;
  alpha = alpha_in + axis * angle.acceleration - angle.rate * axis.cross(w_in);
}

}  // namespace detail

[[nodiscard]] inline MotionState state_of(HostTime t, const HeadCurve& curve) {
  Quaternion q = Quaternion::Identity();
  MotionState state;
  state.t = t;
  detail::append_joint(curve.yaw, Vector3::UnitY(), q, state.w_WB_B, state.alpha_WB_B);
  detail::append_joint(curve.pitch, Vector3::UnitX(), q, state.w_WB_B, state.alpha_WB_B);
  detail::append_joint(curve.roll, Vector3::UnitZ(), q, state.w_WB_B, state.alpha_WB_B);
  state.X_WB = Rigid(q, Vector3(curve.x.value, curve.y.value, curve.z.value));
  state.v_WB = Vector3(curve.x.rate, curve.y.rate, curve.z.rate);
  state.a_WB = Vector3(curve.x.acceleration, curve.y.acceleration, curve.z.acceleration);
  return state;
}

/// The motion of a formula, from time zero of the host's clock for `duration`.
class CurveMotion : public Motion {
 public:
  using Formula = std::function<HeadCurve(const Jet& time)>;

  CurveMotion(Duration duration, Formula formula) : end_(duration), formula_(std::move(formula)) {
    HOLDFAST_ASSERT(duration >= Duration(0), "a motion's duration is negative");
    HOLDFAST_ASSERT(formula_ != nullptr, "a motion needs a formula");
  }

  [[nodiscard]] MotionState at(HostTime t) const override {
    const HostTime answered = clamped(t);
    return state_of(answered, formula_(Jet::time(to_seconds(answered.time_since_epoch()))));
  }
  [[nodiscard]] HostTime begin() const override { return HostTime(Duration(0)); }
  [[nodiscard]] HostTime end() const override { return HostTime(end_); }

 private:
  Duration end_;
  Formula formula_;
};

}  // namespace holdfast
