/// The page of `swimlab track ranges`: error and height against time, and the path from above.
#pragma once

#include <string>
#include <vector>

#include <holdfast/io/result_json.hpp>
#include <holdfast/registration/range_types.hpp>

namespace swimlab {

/// A variant's row and where it took the body to be after each range, with the truth at the same time.
struct RangeTrack {
  struct Place {
    double t_s = 0.0;
    holdfast::Vector3 p_W, true_W;
  };
  holdfast::RangeRow row;
  std::vector<Place> places;
};

/// What report.js draws: {page: {...}}. `command` as it may be typed again.
[[nodiscard]] holdfast::io::ResultJson range_page(const std::vector<RangeTrack>& tracks, const holdfast::Vector3& up_W,
                                                  const std::string& motion, const std::string& command);

}  // namespace swimlab
