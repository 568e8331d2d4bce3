/// swimlab lens: what a headset's lenses do, and the mesh that undoes it.
#pragma once

#include <CLI/CLI.hpp>

namespace swimlab {

void add_lens_command(CLI::App& app, int& exit_code);

}  // namespace swimlab
