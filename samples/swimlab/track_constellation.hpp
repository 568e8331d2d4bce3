/// What `swimlab track constellation` runs, and the page that shows it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <holdfast/io/results.hpp>
#include <holdfast/registration/constellation_experiment.hpp>
#include <holdfast/registration/latency_types.hpp>

#include "interruption.hpp"

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

struct StudyOptions {
  std::uint64_t seed = 1;
  int trials = 0;  ///< installations, tries of each seed, or rooms
  double seconds = 120.0;
  int rate_hz = 500;
};

/// What simulated installations showed, in which no given motion is tracked.
struct ConstellationStudy {
  struct Column {
    std::string name, unit;  ///< no unit: text
    int width = 9, digits = 2;
  };
  std::string title, about;  ///< of the page, and the terminal's first line
  std::vector<std::string> paragraphs;
  std::vector<Column> columns;
  std::vector<std::vector<holdfast::io::ResultJson>> cells;  ///< a line for each row
  holdfast::io::ResultJson rows = holdfast::io::ResultJson::array();
  holdfast::io::ResultJson charts = holdfast::io::ResultJson::array();
  std::vector<ConstellationFigure> figures;
};

/// 003's figure 6: what each source of errors does to a position, by height.
[[nodiscard]] ConstellationStudy study_sensitivity(const StudyOptions& o, const InterruptionWatch& interruption);
/// Poses from nothing but ranges, under hundreds of beacons whose codes repeat.
[[nodiscard]] ConstellationStudy study_acquisition(const StudyOptions& o, const InterruptionWatch& interruption);
/// Beacons that are found by walking about (003 section 5).
[[nodiscard]] ConstellationStudy study_mapping(const StudyOptions& o, const InterruptionWatch& interruption);

/// What report.js draws: {page: {...}}.
[[nodiscard]] holdfast::io::ResultJson constellation_page(const ConstellationFacts& facts,
                                                          const std::vector<ConstellationTrack>& tracks,
                                                          const std::vector<ConstellationFigure>& figures);
[[nodiscard]] holdfast::io::ResultJson constellation_page(const ConstellationFacts& facts,
                                                          const ConstellationStudy& study);

}  // namespace swimlab
