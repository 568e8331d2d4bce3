#include "progress.hpp"

#include <algorithm>
#include <cstdio>
#include <utility>

#include <unistd.h>

namespace swimlab {

Progress::Progress(std::string label, std::size_t steps)
    : label_(std::move(label)), steps_(std::max<std::size_t>(1, steps)), on_terminal_(isatty(STDERR_FILENO) == 1) {}

void Progress::show(std::size_t step, const std::string& what) {
  if (!on_terminal_) return;
  const auto now = std::chrono::steady_clock::now();
  if (drawn_ && now - last_ < std::chrono::milliseconds(100)) return;
  last_ = now;
  drawn_ = true;
  constexpr std::size_t width = 28;
  const std::size_t full = std::min(width, width * step / steps_);
  const std::string bar = std::string(full, '#') + std::string(width - full, '.');
  std::fprintf(stderr, "\r\033[K%s [%s] %zu/%zu %s", label_.c_str(), bar.c_str(), step, steps_, what.c_str());
  std::fflush(stderr);
}

void Progress::finish() {
  if (drawn_) std::fprintf(stderr, "\r\033[K");
  drawn_ = false;
}

}  // namespace swimlab
