/// A camera's table of deviations: what its real image coordinates differ from a pinhole's, on a grid of 25 by 25 nodes
/// (course 11, The HiBall Tracking System, 5.1).
///
///   ideal = real - deviation(real),   deviation interpolated bilinearly from the four nearest nodes
/// for lens distortion and sensors that are not linear, after the view matrix (camera_view.hpp) has taken what a pinhole
/// can. The grid spans [-half_extent_m, half_extent_m] in u and v; beyond it the edge's deviation holds. Metres.
/// `fit_deviation_table` makes one of measured pairs: at each node, the plane that fits the samples of the four cells
/// around it best, nearer ones counting more; nodes without samples take the mean of their neighbours.
/// Bad input: coordinates that are not finite are given back; a fit gives nothing for an extent that is not positive, for no
/// sample within it, or for numbers that are not finite.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/LU>

#include <holdfast/geometry/types.hpp>

namespace holdfast {

struct DeviationTable {
  static constexpr int nodes = 25;  ///< along each side

  double half_extent_m = 0.0;
  std::array<Vector2, nodes * nodes> deviation{};  ///< row by row of rising v, in each u rises

  DeviationTable() { deviation.fill(Vector2::Zero()); }

  [[nodiscard]] double step_m() const { return 2.0 * half_extent_m / (nodes - 1); }
  [[nodiscard]] Vector2 node_at(int column, int row) const {
    return Vector2(column * step_m() - half_extent_m, row * step_m() - half_extent_m);
  }

  [[nodiscard]] Vector2 deviation_at(const Vector2& real) const {
    if (!real.allFinite() || !(half_extent_m > 0.0)) return Vector2::Zero();
    const Cell u = cell(real.x());
    const Cell v = cell(real.y());
    const Vector2* lower = &deviation[v.index * nodes + u.index];
    const Vector2* upper = lower + nodes;
    return (1.0 - v.part) * ((1.0 - u.part) * lower[0] + u.part * lower[1]) +
           v.part * ((1.0 - u.part) * upper[0] + u.part * upper[1]);
  }

  [[nodiscard]] Vector2 ideal(const Vector2& real) const { return real - deviation_at(real); }

  /// The real coordinates of an ideal point, for simulation; nothing when the table is so steep that the search of
  /// real = ideal + deviation(real) does not settle.
  [[nodiscard]] std::optional<Vector2> real(const Vector2& ideal_uv) const {
    Vector2 found = ideal_uv;
    for (int step = 0; step < 100; ++step) {
      const Vector2 next = ideal_uv + deviation_at(found);
      const double moved = (next - found).cwiseAbs().maxCoeff();
      found = next;
      if (moved <= 1e-14 * half_extent_m) return found;
    }
    return std::nullopt;
  }

 private:
  struct Cell {
    int index;    ///< of its lower node
    double part;  ///< 0 at the lower node, 1 at the upper
  };
  [[nodiscard]] Cell cell(double x) const {
    const double at = std::clamp((x + half_extent_m) / step_m(), 0.0, double(nodes - 1));
    const int index = std::min(static_cast<int>(at), nodes - 2);
    return {index, at - index};
  }
};

/// One point as the sensor gave it, and where a pinhole would have put it.
struct DeviationSample {
  Vector2 real = Vector2::Zero();
  Vector2 ideal = Vector2::Zero();
};

namespace detail {

/// Weighted least squares of a plane over one node's surroundings: value = first row + slopes, in steps from the node.
struct NodeFit {
  Matrix3 normal = Matrix3::Zero();
  MatrixOf<double, 3, 2> right = MatrixOf<double, 3, 2>::Zero();

  void add(const Vector2& offset, const Vector2& value, double weight) {
    const Vector3 row(1.0, offset.x(), offset.y());
    normal += weight * row * row.transpose();
    right += weight * row * value.transpose();
  }

  [[nodiscard]] std::optional<Vector2> value() const {
    const double weight = normal(0, 0);
    if (!(weight > 1e-9)) return std::nullopt;
    // Samples all round a node give a determinant of weight^3 / 36; on a line, or too few, they tell no slope.
    const double determinant = normal.determinant();
    if (determinant < 1e-4 * weight * weight * weight) return Vector2(right.row(0).transpose() / weight);
    const MatrixOf<double, 3, 2> solution = normal.inverse() * right;
    return Vector2(solution.row(0).transpose());
  }
};

/// Gives empty nodes the mean of their filled neighbours, from the filled ones outwards.
inline void fill_empty_nodes(std::vector<std::optional<Vector2>>& values) {
  constexpr int n = DeviationTable::nodes;
  bool empty = true;
  while (empty) {
    empty = false;
    const std::vector<std::optional<Vector2>> before = values;
    for (int i = 0; i < n * n; ++i) {
      if (before[i]) continue;
      Vector2 sum = Vector2::Zero();
      int count = 0;
      const auto take = [&](bool inside, int neighbour) {
        if (!inside || !before[neighbour]) return;
        sum += *before[neighbour];
        ++count;
      };
      take(i % n > 0, i - 1);
      take(i % n < n - 1, i + 1);
      take(i >= n, i - n);
      take(i < n * (n - 1), i + n);
      if (count > 0) {
        values[i] = sum / count;
      } else {
        empty = true;
      }
    }
  }
}

}  // namespace detail

[[nodiscard]] inline std::optional<DeviationTable> fit_deviation_table(std::span<const DeviationSample> samples,
                                                                       double half_extent_m) {
  if (!(half_extent_m > 0.0) || !std::isfinite(half_extent_m)) return std::nullopt;
  constexpr int n = DeviationTable::nodes;
  DeviationTable table;
  table.half_extent_m = half_extent_m;
  std::vector<detail::NodeFit> fits(n * n);
  for (const DeviationSample& sample : samples) {
    if (!sample.real.allFinite() || !sample.ideal.allFinite()) return std::nullopt;
    if (sample.real.cwiseAbs().maxCoeff() > half_extent_m) continue;
    const Vector2 at = (sample.real.array() + half_extent_m) / table.step_m();
    const int column = std::min(static_cast<int>(at.x()), n - 2);
    const int row = std::min(static_cast<int>(at.y()), n - 2);
    for (int corner = 0; corner < 4; ++corner) {
      const int i = column + corner % 2;
      const int j = row + corner / 2;
      const Vector2 offset = at - Vector2(i, j);
      const double weight = (1.0 - std::abs(offset.x())) * (1.0 - std::abs(offset.y()));
      fits[j * n + i].add(offset, sample.real - sample.ideal, weight);
    }
  }
  std::vector<std::optional<Vector2>> values(n * n);
  for (int i = 0; i < n * n; ++i) values[i] = fits[i].value();
  if (std::none_of(values.begin(), values.end(), [](const auto& value) { return value.has_value(); })) {
    return std::nullopt;
  }
  detail::fill_empty_nodes(values);
  for (int i = 0; i < n * n; ++i) table.deviation[i] = *values[i];
  return table;
}

}  // namespace holdfast
