/// Ctrl-C and the like during a long run: asked for between rows, so that the unfinished folder is removed on the way
/// out.
#pragma once

#include <csignal>
#include <cstddef>
#include <exception>

namespace swimlab {

/// Thrown when the run was interrupted.
class Interrupted : public std::exception {
 public:
  explicit Interrupted(int signal) : signal_(signal) {}
  [[nodiscard]] int exit_code() const { return 128 + signal_; }  ///< as shells have it
  [[nodiscard]] const char* what() const noexcept override { return "interrupted; nothing was written"; }

 private:
  int signal_;
};

/// While it lives, SIGINT, SIGTERM and SIGHUP are noted; a second one ends the program at once. Signals that the
/// caller ignores (nohup) stay ignored. One at a time.
class InterruptionWatch {
 public:
  InterruptionWatch() {
    noted_ = 0;
    for (std::size_t i = 0; i < count; ++i) {
      sigaction(signals[i], nullptr, &before_[i]);
      if (before_[i].sa_handler == SIG_IGN) continue;
      struct sigaction note {};
      note.sa_handler = [](int signal) { noted_ = signal; };
      note.sa_flags = static_cast<int>(SA_RESETHAND) | SA_RESTART;
      sigaction(signals[i], &note, nullptr);
    }
  }
  InterruptionWatch(const InterruptionWatch&) = delete;
  InterruptionWatch& operator=(const InterruptionWatch&) = delete;
  ~InterruptionWatch() {
    for (std::size_t i = 0; i < count; ++i) sigaction(signals[i], &before_[i], nullptr);
  }

  /// Throws Interrupted when a signal came.
  void check() const {
    if (noted_ != 0) throw Interrupted(noted_);
  }

 private:
  static constexpr std::size_t count = 3;
  static constexpr int signals[count] = {SIGINT, SIGTERM, SIGHUP};
  static inline volatile std::sig_atomic_t noted_ = 0;
  struct sigaction before_[count] = {};
};

}  // namespace swimlab
