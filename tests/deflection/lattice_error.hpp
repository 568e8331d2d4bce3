// How far a WarpLattice is from the lens it stands for, measured through the loops that the CPU warp runs.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <holdfast/deflection/composed_warp.hpp>
#include <holdfast/deflection/detail/scan_lines.hpp>
#include <holdfast/deflection/detail/warp_frame.hpp>
#include <holdfast/deflection/warp_lattice.hpp>

namespace holdfast::test {

struct LatticeError {
  double worst_px = 0.0;    // |source pixel - ComposedWarp::source_pixel|, the source being as dense as the panel
  int undefined = 0;        // pixels outside the lens's domain
  int wrongly_defined = 0;  // pixels where only one of the two has a source
};

// Every `step`-th pixel of every `step`-th row.
inline LatticeError lattice_error(const WarpLattice& lattice, const EyeModel& eye, int step) {
  const RenderedView view{Rigid(), panel_tangents(eye), eye.resolution, {}};
  const ComposedWarp warp(eye, lattice.mode(), {}, view, {});
  detail::ScanLines lines;
  LatticeError error;
  if (!lines.prepare(warp, lattice.is_linear())) return {1e9, 0, 0};
  const detail::PositionKernels kernels = detail::position_kernels(detail::has_avx2());
  for (const Color color : {Color::red, Color::green, Color::blue}) {
    for (int y = step / 2; y < lattice.size().height; y += step) {
      for (int x0 = 0; x0 < lattice.size().width; x0 += detail::run_pixels) {
        detail::WarpRun run;
        const int count = std::min(detail::run_pixels, lattice.size().width - x0);
        detail::locate(lattice, lines, kernels, color, {x0, y, count}, run);
        for (int i = step / 2; i < count; i += step) {
          const auto exact = warp.source_pixel(Vector2(x0 + i + 0.5, y + 0.5), color);
          const Vector2 found(static_cast<double>(run.x[i]) + 0.5, static_cast<double>(run.y[i]) + 0.5);
          error.undefined += !exact;
          error.wrongly_defined += exact.has_value() != found.allFinite();
          if (exact && found.allFinite()) error.worst_px = std::max(error.worst_px, (found - *exact).norm());
        }
      }
    }
  }
  return error;
}

}  // namespace holdfast::test
