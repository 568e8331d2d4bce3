/// Moving through a virtual world and moving things in it: flying, tilting, scaling and grabbing.
///
/// Source: Robinett & Holloway 1994, section 7.2 (course 11), after Robinett & Holloway 1992, *Implementation of
/// flying, scaling and grabbing in virtual worlds*. A user is where T_RW puts the world W in the user's room R; flying,
/// tilting and scaling are changes of T_RW alone, all of one kind: a similarity of the room's space applied to
/// everything virtual,
///   T_RW' = C T_RW.
/// Grabbing holds T_Hand_O constant while the hand moves:  T_WO' = T_W_Hand T_Hand_O.
/// Lengths and speeds in room units (metres as the user feels them), whatever the world's scale. Each function takes a
/// transform and returns the new one; `steer` applies it to the newest sample of a dynamic edge of a graph.
/// Preconditions (programmer errors): finite arguments, a positive scale factor, a rotation that is not zero.
#pragma once

#include <cmath>
#include <utility>

#include <holdfast/assert.hpp>
#include <holdfast/frames/graph.hpp>
#include <holdfast/geometry/vqs.hpp>

namespace holdfast {

/// C: turns by q and scales by `factor` about the point c, which stays where it is: C c = c.
[[nodiscard]] inline Vqs about_point(const Vector3& c, const Quaternion& q, double factor) {
  HOLDFAST_ASSERT(c.allFinite(), "the point is not finite");
  const Vector3 turned = q.normalized() * c;
  const Vector3 v = c - factor * turned;
  return Vqs(v, q, factor);
}

/// T_RW after the user has flown for dt with velocity v_R (m/s in the room, so a pointing direction times a speed): the
/// world slides by -v_R dt through the room, that is, the room by +v_R dt through the world.
[[nodiscard]] inline Vqs fly(const Vqs& T_RW, const Vector3& v_R, Duration dt) {
  HOLDFAST_ASSERT(v_R.allFinite(), "the velocity is not finite");
  const Vector3 step = v_R * to_seconds(dt);
  return Vqs(T_RW.v() - step, T_RW.q(), T_RW.s());
}

/// T_RW after the world was turned by q (in room axes) about the point c_R of the room, e.g. the user's head.
[[nodiscard]] inline Vqs tilt(const Vqs& T_RW, const Quaternion& q, const Vector3& c_R) {
  return about_point(c_R, q, 1.0) * T_RW;
}

/// T_RW after the world was made `factor` times as large about the point c_R of the room, e.g. the hand.
[[nodiscard]] inline Vqs scale_world(const Vqs& T_RW, double factor, const Vector3& c_R) {
  HOLDFAST_ASSERT(std::isfinite(factor) && factor > 0, "the scale factor is not a positive number");
  return about_point(c_R, Quaternion::Identity(), factor) * T_RW;
}

/// What a hand holds: T_Hand_O, taken when it closes and constant until it opens.
class Grab {
 public:
  /// Closes the hand: T_Hand_O = T_W_Hand^-1 T_WO.
  Grab(const Vqs& T_W_Hand, const Vqs& T_WO) : T_Hand_O_(T_W_Hand.inverse() * T_WO) {}

  [[nodiscard]] const Vqs& T_Hand_O() const { return T_Hand_O_; }
  /// T_WO while it is held, for the hand's pose of now.
  [[nodiscard]] Vqs T_WO(const Vqs& T_W_Hand) const { return T_W_Hand * T_Hand_O_; }

 private:
  Vqs T_Hand_O_;
};

/// The hand's hold on the world itself: while closed, the world moves with the hand. Both poses are in the room:
/// T_RW' = T_R_Hand T_Hand_W.
class WorldGrab {
 public:
  WorldGrab(const Vqs& T_R_Hand, const Vqs& T_RW) : T_Hand_W_(T_R_Hand.inverse() * T_RW) {}
  [[nodiscard]] const Vqs& T_Hand_W() const { return T_Hand_W_; }
  [[nodiscard]] Vqs T_RW(const Vqs& T_R_Hand) const { return T_R_Hand * T_Hand_W_; }

 private:
  Vqs T_Hand_W_;
};

/// Pushes operation(newest T_AB) as the sample of time t; `not_dynamic` when the edge is static, gone, or has no sample
/// yet. Example: steer(graph, R_W, now, [&](const Vqs& T_RW) { return fly(T_RW, v_R, dt); });
template <typename Operation>
PushStatus steer(FrameGraph& graph, EdgeId edge, HostTime t, Operation&& operation) {
  const FrameGraph::Edge* e = graph.edge(edge);
  if (!e || e->kind != EdgeKind::dynamic || e->history.empty()) return PushStatus::not_dynamic;
  return graph.push(edge, t, std::forward<Operation>(operation)(e->history.newest()));
}

}  // namespace holdfast
