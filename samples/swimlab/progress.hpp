/// A progress bar on the terminal; silent when standard error is not one.
#pragma once

#include <chrono>
#include <cstddef>
#include <string>

namespace swimlab {

class Progress {
 public:
  Progress(std::string label, std::size_t steps);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress() { finish(); }

  /// Says what is being done and how much is behind; redraws at most ten times a second.
  void show(std::size_t step, const std::string& what);
  void finish();  ///< clears the line

 private:
  std::string label_;
  std::size_t steps_;
  bool on_terminal_;
  bool drawn_ = false;
  std::chrono::steady_clock::time_point last_{};
};

}  // namespace swimlab
