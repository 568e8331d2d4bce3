/// What was not as it should be in one frame, as a set: nothing that a frame loop had to make do with is silent.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include <holdfast/prediction/predictor.hpp>

namespace holdfast {

enum class FrameIssue : std::uint8_t {
  no_pose,            ///< the source has no measurement yet: the head stands at W's origin
  no_velocity,        ///< the measurement has no velocity: the pose was held
  clamped,            ///< the measurement is too old: predicted up to the limit, held from there
  backwards,          ///< the time asked lies before the measurement: the pose was held
  not_finite,         ///< the source answered a NaN or an infinity
  stale,              ///< the measurement is older than FrameLoopSettings::stale_after: the tracker has stopped
  clocks_mixed,       ///< the measurement's time lies after now: tracker and host clocks are not aligned
  missed_scan_out,    ///< the picture is shown later than it was planned and drawn for
  not_covered,        ///< the late pose needs tangents beyond the picture's overfill: an edge of the view has no source
  deflection_refused  ///< the deflection could not be computed (DeflectionResult says why): the picture is shown as drawn
};

inline constexpr std::array frame_issues{FrameIssue::no_pose,      FrameIssue::no_velocity,
                                         FrameIssue::clamped,      FrameIssue::backwards,
                                         FrameIssue::not_finite,   FrameIssue::stale,
                                         FrameIssue::clocks_mixed, FrameIssue::missed_scan_out,
                                         FrameIssue::not_covered,  FrameIssue::deflection_refused};

[[nodiscard]] constexpr std::string_view to_string(FrameIssue issue) {
  constexpr std::string_view names[] = {
      "no_pose", "no_velocity",  "clamped",         "backwards",   "not_finite",
      "stale",   "clocks_mixed", "missed_scan_out", "not_covered", "deflection_refused"};
  return names[static_cast<std::size_t>(issue)];
}

class FrameIssues {
 public:
  constexpr void add(FrameIssue issue) { bits_ |= bit(issue); }
  constexpr void add(FrameIssues others) { bits_ |= others.bits_; }
  constexpr void add(PredictionStatus status) {
    switch (status) {
      case PredictionStatus::ok:
        return;
      case PredictionStatus::no_velocity:
        return add(FrameIssue::no_velocity);
      case PredictionStatus::clamped:
        return add(FrameIssue::clamped);
      case PredictionStatus::backwards:
        return add(FrameIssue::backwards);
      case PredictionStatus::not_finite:
        return add(FrameIssue::not_finite);
    }
  }

  [[nodiscard]] constexpr bool has(FrameIssue issue) const { return (bits_ & bit(issue)) != 0; }
  [[nodiscard]] constexpr bool none() const { return bits_ == 0; }
  /// Bit i stands for the i-th of frame_issues.
  [[nodiscard]] constexpr std::uint32_t bits() const { return bits_; }

  friend constexpr bool operator==(const FrameIssues&, const FrameIssues&) = default;

 private:
  [[nodiscard]] static constexpr std::uint32_t bit(FrameIssue issue) {
    return std::uint32_t{1} << static_cast<unsigned>(issue);
  }
  std::uint32_t bits_ = 0;
};

}  // namespace holdfast
