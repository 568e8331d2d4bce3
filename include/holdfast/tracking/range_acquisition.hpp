/// Acquisition by ranges: pose from nothing but the ranges to coded beacons (003 section 2.2).
///
/// Codes are ordered by how near they are; 4-tuples of them are tried, the nearest first. Every place in the constellation that
/// has this combination of beacons suggests poses (range_hypotheses.hpp); every other range is asked, and the pose that most
/// agree with wins (range_verdict.hpp). A rival with as many, or nearly, means ambiguous. A tuple with wrong ranges (an echo, an
/// early pulse) finds no such pose, and the next one has its turn.
/// Four codes are needed: each receiver is placed by itself, and three spheres nearly always meet in two points, so that
/// three ranges to it contradict nothing; the fourth tells a wrong place, or a wrong range, from the right one. (Three receivers
/// together and the vertical would contradict too, enough for three beacons with codes of their own; that is not done.)
/// Orientation needs three receivers that are not in one line, or two and the vertical, or one with vertical and heading.
/// A code counts as heard from the nearest beacon that has it. So pass the beacons of one room: behind a wall a nearer one would
/// make the range that was really heard count as wrong, and with many of those there is no pose.
/// Codes that no beacon of the constellation has are left out. Ranges count as simultaneous; `sigma_m` must cover motion,
/// and systematic errors. Allocates: for once, not for every frame.
/// Bad input: RangeAcquisitionStatus names why there is no pose.
#pragma once

#include <holdfast/tracking/range_hypotheses.hpp>

namespace holdfast {

/// The body's pose in the beacons' world W from `ranges` to `constellation`, heard by `receivers` of the body B, all of one moment.
/// `directions`: what inertial sensors and a compass know, for fewer than three receivers. Metres, radians.
/// Bad input: the answer's status names it, and its pose then means nothing.
[[nodiscard]] inline RangeAcquisition acquire_by_ranges(std::span<const CodedBeacon> constellation,
                                                        std::span<const RangeReceiver> receivers,
                                                        std::span<const CodedRange> ranges,
                                                        std::span<const SeenDirection> directions = {},
                                                        const RangeAcquisitionSettings& settings = {}) {
  RangeAcquisition nothing;
  detail::HeardCodes heard(constellation, receivers, ranges, directions, settings);
  if (const auto problem = heard.take()) {
    nothing.status = *problem;
    return nothing;
  }
  const detail::RangeHypotheses hypotheses(heard);
  if (!hypotheses.can_be_oriented()) {
    nothing.status = RangeAcquisitionStatus::no_orientation;
    return nothing;
  }
  detail::RangeVerdict verdict(heard);
  int tried = 0;
  const auto is_over = [&] { return tried >= settings.tuples || (tried > 0 && verdict.is_settled()); };
  // The nearest four first, then those with the fifth, and so on.
  const int count = static_cast<int>(heard.codes().size());
  for (int d = 3; d < count; ++d) {
    for (int c = 2; c < d; ++c) {
      for (int b = 1; b < c; ++b) {
        for (int a = 0; a < b && !is_over(); ++a, ++tried) hypotheses.try_codes({a, b, c, d}, verdict);
      }
    }
  }
  RangeAcquisition result = verdict.result();
  result.tuples_tried = tried;
  return result;
}

}  // namespace holdfast
