/// The page of `swimlab track hiball`: what each method's errors were, and how they went in time and frequency.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <holdfast/io/result_json.hpp>

#include "track_scenarios.hpp"

namespace swimlab {

struct TrackPageFacts {
  TrackScenario scenario = TrackScenario::typical;
  std::string motion;
  double seconds = 0.0;
  std::string command;  ///< as it may be typed again
};

/// What report.js draws: {page: {...}}. Rows have their curves.
[[nodiscard]] holdfast::io::ResultJson track_page(const TrackPageFacts& facts, const std::vector<TrackCaseRow>& rows);

}  // namespace swimlab
