/// Signs that a recording's units or quaternion order are not what its format says: reported, never repaired.
///
///   time      a median interval above 0.9 s or below 10 us is no tracker's; the unit that would make it 1 ms to 1 s is
///   named length    a head does not move at 15 m/s on average, nor live 100 m from the origin of its room rotation  a
///   head turns at up to about 1000 deg/s; half of all steps beyond that is an order mistake, single ones are jumps
#pragma once

#include <algorithm>
#include <cmath>
#include <locale>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include <holdfast/geometry/angle.hpp>
#include <holdfast/motion/sampled_trajectory.hpp>

namespace holdfast::io::detail {

template <typename... Parts>
[[nodiscard]] std::string sentence(const Parts&... parts) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(4);
  (text << ... << parts);
  return text.str();
}

inline void suspect_time(Duration median, std::vector<std::string>& suspicions) {
  const double s = to_seconds(median);
  if (s > 0.9) {
    const char* const unit = s > 9e5 ? "nanoseconds" : s > 9e2 ? "microseconds" : "milliseconds";
    suspicions.push_back(sentence("the usual interval is ", s, " s: are the times in ", unit, "?"));
  } else if (s < 1e-5) {
    const char* const unit = s >= 1e-6 ? "milliseconds" : s >= 0.9e-6 ? "microseconds" : "seconds or milliseconds";
    suspicions.push_back(sentence("the usual interval is ", s * 1e9, " ns: are the times in ", unit, "?"));
  }
}

inline void suspect_length(std::span<const TimedPose> samples, std::vector<std::string>& suspicions) {
  double path = 0.0, farthest = 0.0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    farthest = std::max(farthest, samples[i].X_WB.p().norm());
    if (i > 0) path += (samples[i].X_WB.p() - samples[i - 1].X_WB.p()).norm();
  }
  const double speed = path / to_seconds(samples.back().t - samples.front().t);
  if (speed > 15.0 || farthest > 100.0) {
    suspicions.push_back(sentence("positions lie up to ", farthest, " m from the origin and move at ", speed,
                                  " m/s on average: are they in millimetres?"));
  }
}

inline void suspect_rotation(std::span<const TimedPose> samples, std::vector<std::string>& suspicions) {
  const double fast = degrees(1000.0).radians(), jump_rate = degrees(2000.0).radians(), jump = degrees(5.0).radians();
  std::size_t fast_steps = 0, jumps = 0;
  double first_jump = 0.0;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const double angle = so3::angle_between<double>(samples[i - 1].X_WB.q(), samples[i].X_WB.q());
    const double rate = angle / to_seconds(samples[i].t - samples[i - 1].t);
    if (rate > fast && angle > jump) ++fast_steps;
    if (rate > jump_rate && angle > jump && jumps++ == 0) first_jump = to_seconds(samples[i].t - samples.front().t);
  }
  if (2 * fast_steps > samples.size()) {
    suspicions.push_back(
        "most steps turn faster than 1000 deg/s: is the quaternion's order right (x y z w against w x y z), "
        "and the unit of time?");
  } else if (jumps > 0) {
    suspicions.push_back(sentence(jumps, " jumps in orientation (above 2000 deg/s and 5 deg), the first ", first_jump,
                                  " s after the start"));
  }
}

/// Precondition: at least two samples with increasing times.
[[nodiscard]] inline std::vector<std::string> find_suspicions(std::span<const TimedPose> samples, Duration median) {
  std::vector<std::string> suspicions;
  suspect_time(median, suspicions);
  suspect_length(samples, suspicions);
  suspect_rotation(samples, suspicions);
  return suspicions;
}

}  // namespace holdfast::io::detail
