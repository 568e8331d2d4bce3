/// What a panel shows of the ideal picture, for one colour: cubics over cells of 32x32 pixels instead of a look-up per
/// pixel.
///
/// Of a cell, t_E(x, y) is a polynomial of degree 3 in x and in y that meets the lens at 4x4 Chebyshev nodes. It takes
/// 32 numbers for 1024 pixels, so that reading it costs no bandwidth. Where the polynomial misses the lens by more than
/// the bound (kinks of point meshes) or the lens's domain ends within the cell, the cell holds the exact t_E of every
/// pixel, NaN outside the domain: the edge is clean to the pixel. A cell outside the domain altogether holds nothing.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include <holdfast/geometry/types.hpp>
#include <holdfast/optics/eye.hpp>

namespace holdfast::detail {

inline constexpr int cell_pixels = 32;

enum class LensCellKind : std::uint8_t {
  empty,  ///< outside the lens's domain
  cubic,  ///< 4 vectors of 8 numbers: of each power of y the coefficients of 1, x, x^2, x^3 for t_x, then for t_y
  dense,  ///< row by row the t_x of cell_pixels pixels, then their t_y
};

struct LensCell {
  LensCellKind kind = LensCellKind::empty;
  std::size_t offset = 0;  ///< of its numbers
};

struct LensCells {
  int columns = 0;
  std::vector<LensCell> cells;  ///< row by row from the bottom
  std::vector<float> numbers;
  double max_error_px = 0.0;   ///< of the cubics, at the pixels that were checked
  double max_change_px = 0.0;  ///< greatest |t_E - panel tangent|: 0 when there is no lens
  int dense_cells = 0;

  [[nodiscard]] const LensCell& at(int x, int y) const {
    return cells[static_cast<std::size_t>(y / cell_pixels) * static_cast<std::size_t>(columns) +
                 static_cast<std::size_t>(x / cell_pixels)];
  }
};

/// Centre of a cell, from which x and y of its cubic count, px.
[[nodiscard]] inline float cell_centre(int pixel) {
  return static_cast<float>(pixel / cell_pixels * cell_pixels) + 0.5F * cell_pixels;
}

/// A cell's rectangle of pixels, cut off at the panel's edge.
struct CellArea {
  int x0, y0, width, height;
};

/// Coefficients of 1, d, d^2, d^3 from the values at four Chebyshev nodes of the pixels [begin, begin + length).
struct ChebyshevFit {
  Vector4 nodes;      ///< px from the panel's edge
  Matrix4 of_values;  ///< coefficients = of_values * values

  ChebyshevFit(int begin, int length) {
    Matrix4 powers;
    for (int k = 0; k < 4; ++k) {
      nodes[k] = begin + 0.5 * length * (1.0 - std::cos((2 * k + 1) * std::numbers::pi / 8.0));
      const double d = nodes[k] - static_cast<double>(cell_centre(begin));
      powers.row(k) << 1.0, d, d * d, d * d * d;
    }
    of_values = powers.inverse();
  }
};

/// Builds the cells of one colour; `ideal_at` gives t_E of a panel pixel or nothing.
template <typename IdealAt>
class LensCellsBuilder {
 public:
  LensCellsBuilder(const EyeModel& eye, const IdealAt& ideal_at, double max_error_px)
      : eye_(eye), ideal_at_(ideal_at), scale_(pixels_per_tangent(eye).cwiseAbs()), bound_px_(max_error_px) {}

  [[nodiscard]] LensCells build() {
    const PixelSize size = eye_.resolution;
    cells_.columns = (size.width + cell_pixels - 1) / cell_pixels;
    for (int y = 0; y < size.height; y += cell_pixels) {
      for (int x = 0; x < size.width; x += cell_pixels) {
        add({x, y, std::min(cell_pixels, size.width - x), std::min(cell_pixels, size.height - y)});
      }
    }
    return std::move(cells_);
  }

 private:
  static constexpr int checks = 9;  ///< a row and a column of a cell

  void add(const CellArea& area) {
    const std::size_t offset = cells_.numbers.size();
    LensCellKind kind = LensCellKind::empty;
    if (fit(area)) {
      kind = LensCellKind::cubic;
    } else if (any_inside(area)) {
      cells_.numbers.resize(offset);
      kind = LensCellKind::dense;
      fill(area);
      ++cells_.dense_cells;
    } else {
      cells_.numbers.resize(offset);
      cells_.max_change_px = std::numeric_limits<double>::infinity();
    }
    cells_.cells.push_back({kind, offset});
  }

  /// Appends the cubic; whether it is good enough.
  [[nodiscard]] bool fit(const CellArea& area) {
    const ChebyshevFit fit_x(area.x0, area.width);
    const ChebyshevFit fit_y(area.y0, area.height);
    Matrix4 value_x, value_y;
    for (int j = 0; j < 4; ++j) {
      for (int i = 0; i < 4; ++i) {
        const std::optional<Vector2> t = ideal_at_(Vector2(fit_x.nodes[i], fit_y.nodes[j]));
        if (!t) return false;
        value_x(i, j) = t->x();
        value_y(i, j) = t->y();
      }
    }
    const Matrix4 a = fit_x.of_values * value_x * fit_y.of_values.transpose();
    const Matrix4 b = fit_x.of_values * value_y * fit_y.of_values.transpose();
    const std::size_t offset = cells_.numbers.size();
    for (int j = 0; j < 4; ++j) {
      for (int i = 0; i < 4; ++i) cells_.numbers.push_back(static_cast<float>(a(i, j)));
      for (int i = 0; i < 4; ++i) cells_.numbers.push_back(static_cast<float>(b(i, j)));
    }
    return check(area, cells_.numbers.data() + offset);
  }

  [[nodiscard]] bool check(const CellArea& area, const float* cubic) {
    double worst = 0.0;
    double change = 0.0;
    for (int j = 0; j < checks; ++j) {
      for (int i = 0; i < checks; ++i) {
        const Vector2 pixel = check_pixel(area, i, j);
        const std::optional<Vector2> t = ideal_at_(pixel);
        if (!t) return false;
        const Vector2 error = *t - value(cubic, pixel.x() - static_cast<double>(cell_centre(area.x0)),
                                         pixel.y() - static_cast<double>(cell_centre(area.y0)));
        worst = std::max(worst, error.cwiseProduct(scale_).norm());
        change = std::max(change, (*t - tangent_of_pixel(eye_, pixel)).cwiseProduct(scale_).norm());
      }
    }
    if (!(worst <= bound_px_)) return false;
    cells_.max_error_px = std::max(cells_.max_error_px, worst);
    cells_.max_change_px = std::max(cells_.max_change_px, change);
    return true;
  }

  [[nodiscard]] static Vector2 check_pixel(const CellArea& area, int i, int j) {
    return {area.x0 + i * (area.width - 1) / (checks - 1) + 0.5, area.y0 + j * (area.height - 1) / (checks - 1) + 0.5};
  }

  [[nodiscard]] static Vector2 value(const float* cubic, double x, double y) {
    Vector2 t(0.0, 0.0);
    for (int j = 3; j >= 0; --j) {
      const float* of_x = cubic + 8 * j;
      const float* of_y = of_x + 4;
      const auto horner = [x](const float* c) {
        return c[0] + x * (c[1] + x * (c[2] + x * static_cast<double>(c[3])));
      };
      t = t * y + Vector2(horner(of_x), horner(of_y));
    }
    return t;
  }

  [[nodiscard]] bool any_inside(const CellArea& area) const {
    for (int j = 0; j < checks; ++j) {
      for (int i = 0; i < checks; ++i) {
        if (ideal_at_(check_pixel(area, i, j))) return true;
      }
    }
    return false;
  }

  void fill(const CellArea& area) {
    const std::size_t offset = cells_.numbers.size();
    cells_.numbers.resize(offset + 2 * cell_pixels * cell_pixels, std::numeric_limits<float>::quiet_NaN());
    for (int j = 0; j < area.height; ++j) {
      for (int i = 0; i < area.width; ++i) {
        const Vector2 pixel(area.x0 + i + 0.5, area.y0 + j + 0.5);
        const std::optional<Vector2> t = ideal_at_(pixel);
        if (!t) continue;
        float* row = cells_.numbers.data() + offset + static_cast<std::size_t>(2 * cell_pixels * j + i);
        row[0] = static_cast<float>(t->x());
        row[cell_pixels] = static_cast<float>(t->y());
      }
    }
    cells_.max_change_px = std::numeric_limits<double>::infinity();
  }

  const EyeModel& eye_;
  const IdealAt& ideal_at_;
  Vector2 scale_;
  double bound_px_;
  LensCells cells_;
};

}  // namespace holdfast::detail
