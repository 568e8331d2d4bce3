/// Counts the mask that the warp passes leave in a picture's alpha: what is covered, what is filled, what is missing.
///
/// LateWarpPass writes 1 (covered) or 0 (the rendered picture has no such place). DepthWarpPass writes besides 1/2:
/// disoccluded, a place that the rendered picture's eye could not see, filled from what lies behind it.
#pragma once

#include <cstddef>
#include <cstdint>

#include <holdfast/assert.hpp>
#include <holdfast/io/image.hpp>

namespace holdfast::rendering {

struct CoverageMaskCount {
  double covered_pct = 0.0;
  double disoccluded_pct = 0.0;
  double missing_pct = 0.0;
};

enum class MaskValue { missing, disoccluded, covered };

[[nodiscard]] constexpr MaskValue mask_value(std::uint8_t alpha) {
  return alpha > 191 ? MaskValue::covered : alpha > 63 ? MaskValue::disoccluded : MaskValue::missing;
}

/// Precondition: the picture is not empty.
[[nodiscard]] inline CoverageMaskCount count_coverage_mask(const io::Image& warped) {
  HOLDFAST_ASSERT(!warped.empty(), "a picture has pixels");
  std::size_t counts[3] = {};
  for (std::size_t i = 3; i < warped.rgba.size(); i += 4)
    ++counts[static_cast<std::size_t>(mask_value(warped.rgba[i]))];
  const double percent = 400.0 / static_cast<double>(warped.rgba.size());
  return {percent * static_cast<double>(counts[2]), percent * static_cast<double>(counts[1]),
          percent * static_cast<double>(counts[0])};
}

}  // namespace holdfast::rendering
