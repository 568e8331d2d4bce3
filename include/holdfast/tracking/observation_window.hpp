/// The observations of which a multiple-constraint estimate is made: N at a time, or the newest N after each.
///
/// 002 section E.3.3, figure E.1: a fixed window forgets its observations once they are used, so an estimate comes with
/// every Nth; a moving window keeps the newest N, so one comes with each. Oldest first; nothing here allocates.
/// Bad input: precondition 1 <= size <= Capacity.
#pragma once

#include <algorithm>
#include <array>
#include <span>

#include <holdfast/assert.hpp>

namespace holdfast {

struct WindowShape {
  int size = 10;        ///< observations an estimate is made of
  bool moving = false;  ///< an estimate with every observation, of the newest `size`
};

template <typename Observation, int Capacity>
class ObservationWindow {
 public:
  explicit ObservationWindow(const WindowShape& shape) : shape_(shape) {
    HOLDFAST_ASSERT(shape.size >= 1 && shape.size <= Capacity, "a window holds 1 to Capacity observations");
  }

  /// True when the window is full: `observations` are then due for an estimate.
  [[nodiscard]] bool add(const Observation& observation) {
    if (count_ == shape_.size) {
      if (shape_.moving) {
        std::move(observations_.begin() + 1, observations_.begin() + count_, observations_.begin());
        --count_;
      } else {
        count_ = 0;
      }
    }
    observations_[static_cast<std::size_t>(count_++)] = observation;
    return count_ == shape_.size;
  }

  /// Those of now, oldest first.
  [[nodiscard]] std::span<const Observation> observations() const {
    return std::span(observations_).first(static_cast<std::size_t>(count_));
  }

  void clear() { count_ = 0; }

 private:
  WindowShape shape_;
  int count_ = 0;
  std::array<Observation, Capacity> observations_{};
};

}  // namespace holdfast
