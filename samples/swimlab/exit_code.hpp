/// What the command answers to the shell.
#pragma once

namespace swimlab {

enum ExitCode {
  done = 0,
  check_failed = 1,  ///< it ran, and something is not as theory demands
  wrong_use = 2,     ///< bad option, unreadable input, no place to write, no OpenGL
};

}  // namespace swimlab
