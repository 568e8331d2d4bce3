/// swimlab track: how well trackers do, on sightings of a simulated HiBall and on recorded ranges.
#pragma once

#include <CLI/CLI.hpp>

namespace swimlab {

void add_track_command(CLI::App& app, int& exit_code);

/// `swimlab track hiball`.
void add_track_hiball_command(CLI::App& track_app, int& exit_code);

/// `swimlab track ranges`.
void add_track_ranges_command(CLI::App& track_app, int& exit_code);

/// `swimlab track constellation`.
void add_track_constellation_command(CLI::App& track_app, int& exit_code);

/// `swimlab track tune`; there when holdfast::calibration is.
void add_track_tune_command(CLI::App& track_app, int& exit_code);

}  // namespace swimlab
