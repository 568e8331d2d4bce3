/// Coverage and disocclusion: the parts of the view for which the source picture has no pixel, or only a guess.
///
/// The view is what the eye sees (its ideal pixels), looked up through the true lens in a composed warp. Missing is
/// what lies outside the source picture, or is not seen at all; disoccluded is what a depth deflection reveals. A
/// picture deflected by an angle uncovers about angle / field of view at one side, unless it was rendered larger
/// (overfill). As numbers, and as a mask of states. Both on a grid of directions, by default 128 x 72, so to about
/// 0.01 %; the caller gives the mask's memory, and nothing is allocated. Source: evaluation.md "Metrics".
/// Bad input: a grid without cells has no coverage: asserted.
#pragma once

#include <cstddef>
#include <span>

#include <holdfast/assert.hpp>
#include <holdfast/deflection/composed_warp.hpp>
#include <holdfast/deflection/source_state.hpp>

namespace holdfast {

struct Coverage {
  std::size_t directions = 0;   ///< looked up
  std::size_t covered = 0;      ///< the picture shows them
  std::size_t disoccluded = 0;  ///< revealed: their colour is a guess
  std::size_t outside = 0;      ///< beyond the picture's edges
  std::size_t not_seen = 0;     ///< outside the lens's domain or the panel, or not ahead of the source eye

  [[nodiscard]] double missing_pct() const { return percent(outside + not_seen); }
  [[nodiscard]] double disocclusion_pct() const { return percent(disoccluded); }

  void count(SourceState state) {
    ++directions;
    covered += state == SourceState::covered ? 1 : 0;
    disoccluded += state == SourceState::disoccluded ? 1 : 0;
    outside += state == SourceState::outside ? 1 : 0;
    not_seen += state == SourceState::not_seen ? 1 : 0;
  }

 private:
  [[nodiscard]] double percent(std::size_t n) const {
    return directions == 0 ? 0.0 : 100.0 * static_cast<double>(n) / static_cast<double>(directions);
  }
};

/// Looks up the middles of grid.width x grid.height equal cells of the view. `mask` is empty, or takes the state of
/// each cell, row by row from the bottom.
inline Coverage coverage(const ComposedWarp& warp, const PixelSize& grid = {128, 72}, std::span<SourceState> mask = {},
                         Color color = Color::green) {
  HOLDFAST_ASSERT(grid.width > 0 && grid.height > 0, "a grid without cells");
  HOLDFAST_ASSERT(mask.empty() || mask.size() == std::size_t(grid.width) * std::size_t(grid.height),
                  "the mask does not fit the grid");
  const Vector2 cell(double(warp.eye().resolution.width) / grid.width,
                     double(warp.eye().resolution.height) / grid.height);
  Coverage result;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const SourceState state = warp.sample_seen(Vector2((x + 0.5) * cell.x(), (y + 0.5) * cell.y()), color).state;
      if (!mask.empty()) mask[result.directions] = state;
      result.count(state);
    }
  }
  return result;
}

}  // namespace holdfast
