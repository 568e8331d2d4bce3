/// One frame of the CPU warp, cut into tiles that threads draw independently.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include <holdfast/deflection/composed_warp.hpp>
#include <holdfast/deflection/detail/lens_cells.hpp>
#include <holdfast/deflection/detail/scan_lines.hpp>
#include <holdfast/deflection/detail/warp_kernels.hpp>
#include <holdfast/deflection/picture_span.hpp>
#include <holdfast/deflection/warp_lattice.hpp>

namespace holdfast::detail {

/// Pixels of one row of the target.
struct TargetPixels {
  int x = 0;  ///< of the first, a multiple of cell_pixels
  int y = 0;
  int count = 0;  ///< at most run_pixels
};

/// Positions in the source of a run of target pixels.
inline void locate(const WarpLattice& lattice, const ScanLines& lines, const PositionKernels& kernels, Color color,
                   const TargetPixels& pixels, WarpRun& run) {
  const LineMatrix line = lines.at_row(pixels.y);
  const float y = static_cast<float>(pixels.y) + 0.5F;
  if (lattice.is_linear()) {
    kernels.linear(line, y, {pixels.x, pixels.count, run.x, run.y});
    return;
  }
  const LensCells& cells = lattice.cells(color);
  for (int i = 0; i < pixels.count; i += cell_pixels) {
    const WarpPiece piece{pixels.x + i, std::min(cell_pixels, pixels.count - i), run.x + i, run.y + i};
    const LensCell& cell = cells.at(piece.x, pixels.y);
    const float* numbers = cells.numbers.data() + cell.offset;
    if (cell.kind == LensCellKind::cubic) {
      const float from_centre = static_cast<float>(piece.x) + 0.5F - cell_centre(piece.x);
      kernels.cubic(line, numbers, from_centre, y - cell_centre(pixels.y), piece);
    } else if (cell.kind == LensCellKind::dense) {
      const float* t_x = numbers + static_cast<std::ptrdiff_t>(2 * cell_pixels) * (pixels.y % cell_pixels);
      kernels.dense(line, t_x, t_x + cell_pixels, piece);
    } else {
      std::fill(piece.out_x, piece.out_x + cell_pixels, std::numeric_limits<float>::quiet_NaN());
      std::fill(piece.out_y, piece.out_y + cell_pixels, std::numeric_limits<float>::quiet_NaN());
    }
  }
}

/// The same by depth: each pixel is searched, as ComposedWarp defines it.
inline void search(const ComposedWarp& warp, Color color, const TargetPixels& pixels, WarpRun& run) {
  for (int i = 0; i < run_pixels; ++i) {
    run.x[i] = run.y[i] = std::numeric_limits<float>::quiet_NaN();
    if (i >= pixels.count) continue;  // vectors read the run to its end
    const SourceSample found = warp.sample(Vector2(pixels.x + i + 0.5, pixels.y + 0.5), color);
    if (found.state != SourceState::covered && found.state != SourceState::disoccluded) continue;
    run.x[i] = static_cast<float>(found.pixel.x() - 0.5);  // texels count from their centres
    run.y[i] = static_cast<float>(found.pixel.y() - 0.5);
  }
}

template <typename Channel>
struct WarpFrame {
  static constexpr int tile_rows = 32;  ///< of run_pixels columns: source and target stay in the nearest cache

  const WarpLattice* lattice = nullptr;
  const ScanLines* lines = nullptr;
  const ComposedWarp* by_depth = nullptr;  ///< set: places are searched in its depth, and the lines not used
  WarpSource<Channel> source;
  PictureSpan<Channel> target;
  PositionKernels positions;
  SampleKernel<Channel> sample = nullptr;
  SampleColorsKernel<Channel> sample_colors = nullptr;
  void (*finish)() = nullptr;
  bool stream = false;

  [[nodiscard]] int tile_columns() const { return (target.width + run_pixels - 1) / run_pixels; }
  [[nodiscard]] int tiles() const { return tile_columns() * ((target.height + tile_rows - 1) / tile_rows); }

  void draw_tile(int tile) const {
    const int x = tile % tile_columns() * run_pixels;
    const int y = tile / tile_columns() * tile_rows;
    for (int row = y; row < std::min(y + tile_rows, target.height); ++row) draw_row(x, row);
    finish();
  }

 private:
  void draw_row(int x, int y) const {
    const WarpRow<Channel> row{target.pixel(x, y), std::min(run_pixels, target.width - x), stream};
    if (lattice->per_color()) {
      draw_colors(x, y, row);
    } else {
      WarpRun run;
      find(Color::green, {x, y, row.count}, run);
      sample(source, run, row);
    }
  }

  void find(Color color, const TargetPixels& pixels, WarpRun& run) const {
    if (by_depth != nullptr) return search(*by_depth, color, pixels, run);
    locate(*lattice, *lines, positions, color, pixels, run);
  }

  /// Every colour from its own place.
  void draw_colors(int x, int y, const WarpRow<Channel>& row) const {
    ColorRuns runs;
    for (int c = 0; c < 3; ++c) {
      find(static_cast<Color>(c), {x, y, row.count}, runs.of[c]);
    }
    if (sample_colors != nullptr) {
      sample_colors(source, runs, row);
      return;
    }
    cover_together(source, runs, row.count);
    alignas(32) Channel red[4 * run_pixels];
    alignas(32) Channel blue[4 * run_pixels];
    sample(source, runs.of[0], {red, row.count, false});
    sample(source, runs.of[1], {row.pixels, row.count, false});
    sample(source, runs.of[2], {blue, row.count, false});
    for (int i = 0; i < 4 * row.count; i += 4) {
      row.pixels[i] = red[i];
      row.pixels[i + 2] = blue[i + 2];
    }
  }
};

}  // namespace holdfast::detail
