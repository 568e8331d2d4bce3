/// Source positions of a run of target pixels: the lens's cells, then the line's matrix. The portable form.
///
/// Each function writes the positions of `count` neighbouring pixels of one row, the first at column x, to out_x and
/// out_y. A direction that is not ahead of the source eye (w <= 0), or without a tangent, becomes NaN.
#pragma once

#include <limits>

#include <holdfast/deflection/detail/scan_lines.hpp>

namespace holdfast::detail {

/// Where the positions of one piece of a row go.
struct WarpPiece {
  int x = 0;      ///< column of the first pixel
  int count = 0;  ///< pixels; whole vectors are written
  float* out_x = nullptr;
  float* out_y = nullptr;
};

inline void project(const LineMatrix& m, const WarpPiece& piece, int i, float a, float b) {
  const auto element = [&](int k) { return m.pitch == 0 ? m.elements[k] : m.elements[m.pitch * k + piece.x + i]; };
  const auto line = [&](int k) { return element(k) * a + (element(k + 1) * b + element(k + 2)); };
  const float w = line(6);
  const float scale = w > 0.0F ? 1.0F / w : std::numeric_limits<float>::quiet_NaN();
  piece.out_x[i] = line(0) * scale;
  piece.out_y[i] = line(3) * scale;
}

/// Without a lens: the matrix takes pixels.
inline void positions_linear(const LineMatrix& m, float y, const WarpPiece& piece) {
  for (int i = 0; i < piece.count; ++i) project(m, piece, i, static_cast<float>(piece.x + i) + 0.5F, y);
}

/// From a cell's cubic (LensCellKind::cubic); dx, dy: of the first pixel from the cell's centre.
inline void positions_cubic(const LineMatrix& m, const float* cubic, float dx, float dy, const WarpPiece& piece) {
  float c[8];
  for (int k = 0; k < 8; ++k) c[k] = cubic[k] + dy * (cubic[k + 8] + dy * (cubic[k + 16] + dy * cubic[k + 24]));
  for (int i = 0; i < piece.count; ++i) {
    const float d = dx + static_cast<float>(i);
    project(m, piece, i, c[0] + d * (c[1] + d * (c[2] + d * c[3])), c[4] + d * (c[5] + d * (c[6] + d * c[7])));
  }
}

/// From exact tangents (LensCellKind::dense).
inline void positions_dense(const LineMatrix& m, const float* t_x, const float* t_y, const WarpPiece& piece) {
  for (int i = 0; i < piece.count; ++i) project(m, piece, i, t_x[i], t_y[i]);
}

}  // namespace holdfast::detail
