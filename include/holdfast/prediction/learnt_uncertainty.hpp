/// What comes to the covariance that was learnt while poses came, where they are missing.
///
/// Then, and for half a second after a start, what the filter's own covariance says beyond the usual comes to it
/// (inertial_spread.hpp), until it is no less than that. The usual is also the least that is learnt (error_spread.hpp).
/// Units: m^2, rad^2, s. Nothing here allocates. Bad input: precondition a filter that is started, h >= 0.
#pragma once

#include <algorithm>

#include <holdfast/tracking/inertial_filter.hpp>

namespace holdfast {

class LearntUncertainty {
 public:
  /// After each pose that the filter took.
  void update(const InertialFilter& filter, InertialPoseUpdate status) {
    const HostTime t = filter.state().t;
    if (status == InertialPoseUpdate::updated) {
      const double part = pose_interval_s_ > 0.0 ? 0.05 : 1.0;
      pose_interval_s_ += part * (to_seconds(t - newest_) - pose_interval_s_);
      delay_s_ += part * (to_seconds(filter.now().t - t) - delay_s_);
    } else {
      settled_ = t + std::chrono::milliseconds(500);
    }
    newest_ = t;
    spread_ = filter.spread();
    if (t < settled_) return;
    const double part = knows_usual_ ? 0.05 : 1.0;
    knows_usual_ = true;
    usual_.place += part * (spread_.place - usual_.place);
    usual_.turn += part * (spread_.turn - usual_.turn);
  }

  /// How uncertain the filter's pose is after a pose, of late.
  [[nodiscard]] const PoseSpread& usual() const { return usual_; }
  /// How old the newest pose is when the next comes, or when one is predicted from it: its delay, and half of the time between.
  [[nodiscard]] double usual_age_s() const { return delay_s_ + 0.5 * pose_interval_s_; }

  /// Of a prediction over h from the filter's newest state, at `now`.
  void complete(Matrix6& covariance, HostTime now, double h) const {
    const double unseen = to_seconds(now - newest_);
    if (unseen <= delay_s_ + 1.5 * pose_interval_s_ && newest_ >= settled_) return;
    const double usual = usual_age_s() + h, since = unseen + h;
    const auto add = [](auto&& variances, double usually, double now_said) {
      variances.array() += std::max({0.0, now_said - usually, now_said - variances.mean()});
    };
    add(covariance.diagonal().head<3>(), usual_.place_m2(usual), spread_.place_m2(since));
    add(covariance.diagonal().tail<3>(), usual_.turn_rad2(usual), spread_.turn_rad2(since));
  }

 private:
  PoseSpread spread_, usual_;                     ///< after the newest pose, and of late
  double pose_interval_s_ = 0.0, delay_s_ = 0.0;  ///< of poses, behind the newest reading when they come
  bool knows_usual_ = false;
  HostTime newest_, settled_;
};

}  // namespace holdfast
