/// What `swimlab track constellation` runs, and the page that shows it.
#pragma once

#include <string>
#include <vector>

#include <holdfast/io/results.hpp>
#include <holdfast/registration/constellation_experiment.hpp>
#include <holdfast/registration/latency_types.hpp>

namespace swimlab {

struct ConstellationTrack {
  struct Error {
    double t_s = 0.0, position_mm = 0.0;
  };
  holdfast::ConstellationRow row;
  holdfast::LatencyResult latency;
  std::vector<Error> errors;  ///< the largest of each 50 ms
  bool has_inertial = true;
  std::string gyro, accelerometer;  ///< the first faults that the tracker named; empty: none
};

/// A figure of the paper, and ours.
struct ConstellationFigure {
  std::string what, paper, ours;
};

struct ConstellationFacts {
  std::string scenario, motion, command;
  double seconds = 0.0;
};

/// What report.js draws: {page: {...}}.
[[nodiscard]] holdfast::io::ResultJson constellation_page(const ConstellationFacts& facts,
                                                          const std::vector<ConstellationTrack>& tracks,
                                                          const std::vector<ConstellationFigure>& figures);

}  // namespace swimlab
