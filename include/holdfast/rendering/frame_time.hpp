/// How long drawing takes, by the CPU's clock round glFinish (software Mesa's timer queries read nonsense).
#pragma once

#include <algorithm>
#include <chrono>
#include <utility>
#include <vector>

#include <holdfast/assert.hpp>
#include <holdfast/rendering/context.hpp>

namespace holdfast::rendering {

/// Milliseconds that draw() and everything it asked of the GPU take.
template <typename Draw>
[[nodiscard]] double frame_ms(Context& context, Draw&& draw) {
  context.make_current();
  context.gl().Finish();
  const auto begin = std::chrono::steady_clock::now();
  draw();
  context.gl().Finish();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

/// Median of `frames` calls of draw(frame), after `warm_up` that do not count (shaders are compiled at first use).
template <typename Draw>
[[nodiscard]] double median_frame_ms(Context& context, int frames, Draw&& draw, int warm_up = 2) {
  HOLDFAST_ASSERT(frames >= 1, "a median needs at least one frame");
  std::vector<double> times;
  for (int i = -warm_up; i < frames; ++i) {
    const double ms = frame_ms(context, [&] { draw(std::max(i, 0)); });
    if (i >= 0) times.push_back(ms);
  }
  const auto middle = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
  std::nth_element(times.begin(), middle, times.end());
  return *middle;
}

}  // namespace holdfast::rendering
