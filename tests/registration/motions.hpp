// Motions and scenes changed as a whole: moved in the world, or mirrored.
#pragma once

#include <holdfast/motion/motion.hpp>
#include <holdfast/registration/scene_fiducials.hpp>

namespace holdfast {

/// A motion seen after the whole world has been moved.
class MovedMotion : public Motion {
 public:
  MovedMotion(const Motion& inner, const Rigid& X_VW) : inner_(inner), X_VW_(X_VW) {}
  [[nodiscard]] MotionState at(HostTime t) const override {
    MotionState state = inner_.at(t);
    state.X_WB = X_VW_ * state.X_WB;
    state.v_WB = X_VW_.q() * state.v_WB;
    state.a_WB = X_VW_.q() * state.a_WB;
    return state;
  }
  [[nodiscard]] HostTime begin() const override { return inner_.begin(); }
  [[nodiscard]] HostTime end() const override { return inner_.end(); }

 private:
  const Motion& inner_;
  Rigid X_VW_;
};

/// A motion in the mirror x -> -x.
class MirroredMotion : public Motion {
 public:
  explicit MirroredMotion(const Motion& inner) : inner_(inner) {}
  [[nodiscard]] MotionState at(HostTime t) const override {
    MotionState s = inner_.at(t);
    const Quaternion& q = s.X_WB.q();
    // Reflection keeps turns about x, and reverses those about y and z; vectors lose the sign of x.
    s.X_WB = Rigid(Quaternion(q.w(), q.x(), -q.y(), -q.z()), mirrored(s.X_WB.p()));
    s.v_WB = mirrored(s.v_WB);
    s.w_WB_B = -mirrored(s.w_WB_B);
    return s;
  }
  [[nodiscard]] HostTime begin() const override { return inner_.begin(); }
  [[nodiscard]] HostTime end() const override { return inner_.end(); }
  static Vector3 mirrored(const Vector3& v) { return {-v.x(), v.y(), v.z()}; }

 private:
  const Motion& inner_;
};

/// Discs and edge in the mirror; the corner and the board, which have hands, are left out.
[[nodiscard]] inline RegistrationScene mirrored(RegistrationScene scene) {
  for (Disc& disc : scene.discs) {
    disc.centre_W = MirroredMotion::mirrored(disc.centre_W);
    disc.normal_W = MirroredMotion::mirrored(disc.normal_W);
  }
  scene.edge.bottom_W = MirroredMotion::mirrored(scene.edge.bottom_W);
  scene.edge.top_W = MirroredMotion::mirrored(scene.edge.top_W);
  scene.edge.across_W = MirroredMotion::mirrored(scene.edge.across_W);
  scene.corner.length_m = 0.0;
  scene.board.columns = 0;
  return scene;
}

}  // namespace holdfast
