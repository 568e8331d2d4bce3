/// Finds the triangle that holds a point, among triangles of any shape that do not overlap.
///
/// A grid of about as many cells as triangles lists for each cell the triangles whose boxes touch it; a look-up tests
/// the few of one cell. Unlike a walk it needs no neighbours, and works with gaps and without the Delaunay property. A
/// point within rounding (1e-12 of a triangle's height) of an edge counts as inside, so that no crack lies between
/// neighbours. Look-ups allocate nothing. Unit: any. Bad input: outside all triangles, or not finite: nothing.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <holdfast/assert.hpp>
#include <holdfast/geometry/types.hpp>

namespace holdfast {

class TriangleGrid {
 public:
  /// The triangle, and how much each of its corners counts at the point (barycentric weights, sum 1).
  struct Place {
    int triangle = 0;
    std::array<double, 3> weights{};
  };

  TriangleGrid() = default;

  /// Triangles of no area are never found. Precondition: the points are finite, the indices those of points.
  TriangleGrid(std::span<const Vector2> points, std::span<const std::array<int, 3>> triangles) {
    if (triangles.empty()) return;
    Vector2 low = Vector2::Constant(INFINITY), high = Vector2::Constant(-INFINITY);
    shapes_.reserve(triangles.size());
    for (const std::array<int, 3>& t : triangles) {
      const std::array<Vector2, 3> corner{points[static_cast<std::size_t>(t[0])],
                                          points[static_cast<std::size_t>(t[1])],
                                          points[static_cast<std::size_t>(t[2])]};
      shapes_.push_back(shape_of(corner));
      low = low.cwiseMin(shapes_.back().low);
      high = high.cwiseMax(shapes_.back().high);
    }
    origin_ = low;
    const Vector2 extent = (high - low).cwiseMax(Vector2::Constant(1e-300));
    const double side = std::sqrt(static_cast<double>(triangles.size()));
    columns_ = rows_ = std::clamp(static_cast<int>(side), 1, 2048);
    cells_per_unit_ = Vector2(columns_ / extent.x(), rows_ / extent.y());
    fill();
  }

  [[nodiscard]] std::optional<Place> find(const Vector2& p) const {
    if (shapes_.empty()) return std::nullopt;
    const Vector2 cell = (p - origin_).cwiseProduct(cells_per_unit_);
    constexpr double slack = 1e-9;  // of a cell: points on the border within rounding
    if (!(cell.x() >= -slack && cell.y() >= -slack && cell.x() <= columns_ + slack && cell.y() <= rows_ + slack)) {
      return std::nullopt;
    }
    const std::size_t index = index_of(column_of(cell.x()), row_of(cell.y()));
    for (std::uint32_t i = first_[index]; i < first_[index + 1]; ++i) {
      const Shape& shape = shapes_[listed_[i]];
      const Vector2 q = p - shape.corner;
      const double u = shape.to_u.dot(q);
      const double v = shape.to_v.dot(q);
      constexpr double rounding = -1e-12;
      if (u >= rounding && v >= rounding && 1.0 - u - v >= rounding) {
        return Place{static_cast<int>(listed_[i]), {1.0 - u - v, u, v}};
      }
    }
    return std::nullopt;
  }

 private:
  struct Shape {
    Vector2 corner;      ///< the triangle's first point
    Vector2 to_u, to_v;  ///< weights of the second and third point: to_u . (p - corner), to_v . (p - corner)
    Vector2 low, high;   ///< its box
  };

  [[nodiscard]] static Shape shape_of(const std::array<Vector2, 3>& c) {
    const Vector2 b = c[1] - c[0];
    const Vector2 d = c[2] - c[0];
    const double area2 = b.x() * d.y() - b.y() * d.x();
    // Without area the weights are NaN or infinite, and no point passes the test.
    return {c[0], Vector2(d.y() / area2, -d.x() / area2), Vector2(-b.y() / area2, b.x() / area2),
            c[0].cwiseMin(c[1]).cwiseMin(c[2]), c[0].cwiseMax(c[1]).cwiseMax(c[2])};
  }

  [[nodiscard]] int column_of(double cell_x) const { return std::clamp(static_cast<int>(cell_x), 0, columns_ - 1); }
  [[nodiscard]] int row_of(double cell_y) const { return std::clamp(static_cast<int>(cell_y), 0, rows_ - 1); }
  [[nodiscard]] std::size_t index_of(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column);
  }

  /// Calls visit(cell index) for each cell that the shape's box, grown by rounding, touches.
  template <typename Visit>
  void for_each_cell(const Shape& shape, const Visit& visit) const {
    constexpr double slack = 1e-9;
    const Vector2 low = (shape.low - origin_).cwiseProduct(cells_per_unit_) - Vector2::Constant(slack);
    const Vector2 high = (shape.high - origin_).cwiseProduct(cells_per_unit_) + Vector2::Constant(slack);
    for (int row = row_of(low.y()); row <= row_of(high.y()); ++row) {
      for (int column = column_of(low.x()); column <= column_of(high.x()); ++column) visit(index_of(column, row));
    }
  }

  void fill() {
    first_.assign(index_of(0, rows_) + 1, 0);
    for (const Shape& shape : shapes_) for_each_cell(shape, [&](std::size_t cell) { ++first_[cell + 1]; });
    for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
    listed_.resize(first_.back());
    std::vector<std::uint32_t> at(first_.begin(), first_.end() - 1);
    for (std::size_t i = 0; i < shapes_.size(); ++i) {
      for_each_cell(shapes_[i], [&](std::size_t cell) { listed_[at[cell]++] = static_cast<std::uint32_t>(i); });
    }
  }

  std::vector<Shape> shapes_;
  Vector2 origin_ = Vector2::Zero();
  Vector2 cells_per_unit_ = Vector2::Zero();
  int columns_ = 0;
  int rows_ = 0;
  std::vector<std::uint32_t> first_;   ///< where each cell's list begins; one more at the end
  std::vector<std::uint32_t> listed_;  ///< triangles, cell by cell
};

}  // namespace holdfast
