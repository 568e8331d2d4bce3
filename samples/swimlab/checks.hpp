/// The values that theory demands (evaluation.md), measured anew in every run by small experiments of their own.
#pragma once

#include <string>
#include <vector>

#include <holdfast/io/results.hpp>

#include "studio.hpp"

namespace swimlab {

struct Check {
  int value = 0;  ///< its number in evaluation.md
  std::string what;
  std::string unit;  ///< empty: a ratio
  double expected = 0.0, tolerance = 0.0, measured = 0.0;
  bool at_most = false;     ///< `expected` is the most allowed, `tolerance` is not used
  bool only_warns = false;  ///< a miss is no failure

  [[nodiscard]] bool holds() const;
};

/// Values 1 to 13. Draws a few pictures for 5, 7, 8 and 9.
[[nodiscard]] std::vector<Check> run_checks(Studio& studio, const holdfast::RegistrationScene& scene);

[[nodiscard]] holdfast::io::ResultJson checks_json(const std::vector<Check>& checks);

}  // namespace swimlab
