/// When a fault lasts: begin <= t < end.
#pragma once

#include <holdfast/timing/clock.hpp>

namespace holdfast {

struct TimeSpan {
  HostTime begin, end;

  [[nodiscard]] bool contains(HostTime t) const { return t >= begin && t < end; }
};

}  // namespace holdfast
