/// Whether what an accelerometer feels can be gravity: a body that stays in a room feels, on average, its opposite, within 0.2 s
/// roughly, within 2 s rather well. Units in g, a sign, or a wrong axis show so.
///
/// Running means of the force, turned into the world: off by 4 m/s^2 over 0.2 s or by 1.5 over 2 s, gravity is wrong, until
/// both are below half of that. World frame W, m/s^2.
/// Bad input: a force that is not finite makes the means so; keep it out.
#pragma once

#include <algorithm>

#include <holdfast/geometry/types.hpp>

namespace holdfast {

class FeltGravity {
 public:
  explicit FeltGravity(const Vector3& gravity_W) : gravity_W_(gravity_W) { restart(); }

  /// As if it had felt gravity for long.
  void restart() { felt_W_ = felt_slowly_W_ = -gravity_W_; }

  /// Call with each force, dt seconds after the one before. True when it just turned out to be wrong.
  bool feel(const Vector3& felt_W, double dt) {
    constexpr double fast_s = 0.2, slow_s = 2.0, fast_limit = 4.0, slow_limit = 1.5;
    felt_W_ += std::min(1.0, dt / fast_s) * (felt_W - felt_W_);
    felt_slowly_W_ += std::min(1.0, dt / slow_s) * (felt_W - felt_slowly_W_);
    const double fast = (felt_W_ + gravity_W_).norm(), slow = (felt_slowly_W_ + gravity_W_).norm();
    const bool was_wrong = is_wrong_;
    const double share = was_wrong ? 0.5 : 1.0;
    is_wrong_ = fast > share * fast_limit || slow > share * slow_limit;
    return is_wrong_ && !was_wrong;
  }
  [[nodiscard]] bool is_wrong() const { return is_wrong_; }

 private:
  Vector3 gravity_W_, felt_W_ = Vector3::Zero(), felt_slowly_W_ = Vector3::Zero();
  bool is_wrong_ = false;
};

}  // namespace holdfast
