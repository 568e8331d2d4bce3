/// The page of `swimlab predict`: 001's figures 6 and 7 on a recording, and its appendix D's jitter.
#pragma once

#include <string>
#include <vector>

#include <holdfast/io/result_json.hpp>

namespace swimlab {

struct PredictPageFacts {
  std::string recording, readings;  ///< the file's name; where the inertial readings come from
  std::string command;              ///< as it may be typed again
};

/// What report.js draws: {page: {...}}. `asked` is the block (JSON, schema holdfast/predict/1) of the interval asked
/// for first, `sweep` those of intervals that increase.
[[nodiscard]] holdfast::io::ResultJson predict_page(const PredictPageFacts& facts,
                                                    const holdfast::io::ResultJson& asked,
                                                    const std::vector<holdfast::io::ResultJson>& sweep);

}  // namespace swimlab
