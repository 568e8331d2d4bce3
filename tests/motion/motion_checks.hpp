/// What several tests of motions check.
#pragma once

#include <doctest/doctest.h>

#include <holdfast/motion/motion.hpp>

namespace holdfast {

/// Compares a motion's stated derivatives at t with central differences of its poses and rates over +-h.
inline void check_derivatives(const Motion& motion, HostTime t, Duration h, double tolerance) {
  const MotionState s = motion.at(t), before = motion.at(t - h), after = motion.at(t + h);
  const double span = to_seconds(after.t - before.t);
  const Vector3 v = (after.X_WB.p() - before.X_WB.p()) / span;
  const Vector3 a = (after.v_WB - before.v_WB) / span;
  const Vector3 w = so3::log<double>(before.X_WB.q().conjugate() * after.X_WB.q()) / span;
  const Vector3 alpha = (after.w_WB_B - before.w_WB_B) / span;
  CHECK((s.v_WB - v).norm() < tolerance);
  CHECK((s.a_WB - a).norm() < tolerance);
  CHECK((s.w_WB_B - w).norm() < tolerance);
  CHECK((s.alpha_WB_B - alpha).norm() < tolerance);
}

}  // namespace holdfast
