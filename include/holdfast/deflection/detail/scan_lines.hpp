/// The maps from panel to source of all lines of a scan, as float matrices ready for the CPU warp's inner loops.
///
/// A matrix takes (t_E, 1), or without a lens (panel pixel, 1), to the homogeneous texel (x, y, 1) of the source;
/// texels count from the centre of the lower left pixel. A display that is scanned by rows has one matrix a row (one
/// for all when nothing moves during the scan), one that is scanned by columns a table of each element along the
/// columns.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include <holdfast/deflection/composed_warp.hpp>
#include <holdfast/geometry/types.hpp>

namespace holdfast::detail {

/// The nine elements of a matrix, row by row: for one row of the target, or (pitch > 0) for each of its columns.
struct LineMatrix {
  const float* elements = nullptr;
  std::ptrdiff_t pitch = 0;  ///< from an element's table to the next element's
};

class ScanLines {
 public:
  /// Whether all matrices are finite. Allocates when the target is larger than all before.
  [[nodiscard]] bool prepare(const ComposedWarp& warp, bool is_linear) {
    const PixelSize source = warp.view().size;
    const SourceMatrices uv = warp.source_matrices();
    texel_of_uv_ << source.width, 0.0, -0.5, 0.0, source.height, -0.5, 0.0, 0.0, 1.0;
    tangent_of_input_ = is_linear ? tangent_of_panel_pixel(warp.eye()) : Matrix3(Matrix3::Identity());
    const Vector3& line = warp.line_coefficients();
    const bool constant = uv.is_constant() || (line.x() == 0.0 && line.y() == 0.0);
    by_column_ = !constant && line.x() != 0.0;
    count_ = constant ? 1 : by_column_ ? warp.eye().resolution.width : warp.eye().resolution.height;
    const Matrix3 linear = uv.linear();
    const Matrix3 quadratic = uv.quadratic();
    const std::size_t needed = 9 * static_cast<std::size_t>(by_column_ ? pitch() : count_);
    if (elements_.size() < needed) elements_.resize(needed);
    const double along = by_column_ ? line.x() : line.y();
    double sum = 0.0;
    for (int i = 0; i < count_; ++i) {
      const double s = line.z() + along * (i + 0.5) / count_;
      const Matrix3 M = texel_of_uv_ * (uv.begin + s * (linear + s * quadratic)) * tangent_of_input_;
      sum += M.sum();
      store(i, M);
    }
    return std::isfinite(sum);
  }

  [[nodiscard]] LineMatrix at_row(int y) const {
    if (by_column_) return {elements_.data(), pitch()};
    return {elements_.data() + (count_ == 1 ? 0 : 9 * static_cast<std::ptrdiff_t>(y)), 0};
  }

 private:
  /// Tables are read a vector at a time, also past the last column.
  [[nodiscard]] std::ptrdiff_t pitch() const { return (count_ + 7) / 8 * 8; }

  void store(int i, const Matrix3& M) {
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) {
        const std::ptrdiff_t k = 3 * row + column;
        const std::ptrdiff_t at = by_column_ ? k * pitch() + i : 9 * static_cast<std::ptrdiff_t>(i) + k;
        elements_[static_cast<std::size_t>(at)] = static_cast<float>(M(row, column));
      }
    }
  }

  [[nodiscard]] static Matrix3 tangent_of_panel_pixel(const EyeModel& eye) {
    const Vector2 scale = pixels_per_tangent(eye);
    const FieldTangents t = panel_tangents(eye);
    Matrix3 A;
    A << 1.0 / scale.x(), 0.0, t.left, 0.0, 1.0 / scale.y(), t.down, 0.0, 0.0, 1.0;
    return A;
  }

  Matrix3 texel_of_uv_ = Matrix3::Identity();
  Matrix3 tangent_of_input_ = Matrix3::Identity();
  bool by_column_ = false;
  int count_ = 0;
  std::vector<float> elements_;
};

}  // namespace holdfast::detail
