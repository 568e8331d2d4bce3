/// swimlab calibrate: what sensors do not tell about themselves, found from a recording.
#pragma once

#include <CLI/CLI.hpp>

namespace swimlab {

/// `swimlab calibrate inertial`.
void add_calibrate_command(CLI::App& app, int& exit_code);

}  // namespace swimlab
