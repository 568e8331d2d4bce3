/// The forward depth mesh drawn on the CPU: which source pixel each panel pixel shows, with its state.
///
/// What a GPU does with the mesh: every triangle is filled at the pixel centres that it covers, source coordinates are
/// interpolated homogeneously, the nearer one wins, solid ones against equals. A panel pixel that no triangle reaches is
/// outside. Memory is the caller's, nothing is allocated. Bad input: a triangle with a corner that is not finite is left
/// out; arrays of another size than the panel are asserted.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

#include <holdfast/assert.hpp>
#include <holdfast/deflection/coverage.hpp>
#include <holdfast/deflection/depth_mesh.hpp>

namespace holdfast {

namespace deflection_detail {

/// What rasterizing a triangle writes to.
struct DepthTarget {
  PixelSize panel;
  PixelSize source;
  std::span<SourceSample> samples;
  std::span<float> nearness;
};

inline void fill_triangle(const DepthTarget& target, const DepthVertex& a, const DepthVertex& b, const DepthVertex& c,
                          SourceState state) {
  const DepthVertex* corners[3] = {&a, &b, &c};
  Vector2 p[3];
  for (int i = 0; i < 3; ++i) {
    p[i] = Vector2(double(corners[i]->panel_x) * target.panel.width, double(corners[i]->panel_y) * target.panel.height);
  }
  const auto cross = [](const Vector2& u, const Vector2& v) { return u.x() * v.y() - u.y() * v.x(); };
  const double area = cross(p[1] - p[0], p[2] - p[0]);
  if (!(std::abs(area) > 1e-12) || !std::isfinite(area)) return;
  const auto first = [](double low, int n) {
    return static_cast<int>(std::clamp(std::ceil(low - 0.5), 0.0, double(n)));
  };
  const auto last = [](double high, int n) {
    return static_cast<int>(std::clamp(std::floor(high - 0.5), -1.0, n - 1.0));
  };
  const auto [x_low, x_high] = std::minmax({p[0].x(), p[1].x(), p[2].x()});
  const auto [y_low, y_high] = std::minmax({p[0].y(), p[1].y(), p[2].y()});
  const int x_first = first(x_low, target.panel.width), x_last = last(x_high, target.panel.width);
  const int y_first = first(y_low, target.panel.height), y_last = last(y_high, target.panel.height);
  for (int y = y_first; y <= y_last; ++y) {
    for (int x = x_first; x <= x_last; ++x) {
      const Vector2 at(x + 0.5, y + 0.5);
      double weight[3];
      bool inside = true;
      for (int i = 0; i < 3; ++i) {
        weight[i] = cross(p[(i + 1) % 3] - at, p[(i + 2) % 3] - at) / area;
        inside = inside && weight[i] >= -1e-9;  // on an edge: in both triangles
      }
      if (!inside) continue;
      double nearness = 0.0, u = 0.0, v = 0.0, w = 0.0;
      for (int i = 0; i < 3; ++i) {
        nearness += weight[i] * double(corners[i]->nearness);
        u += weight[i] * double(corners[i]->source[0]);
        v += weight[i] * double(corners[i]->source[1]);
        w += weight[i] * double(corners[i]->source[2]);
      }
      const std::size_t i = static_cast<std::size_t>(y) * static_cast<std::size_t>(target.panel.width) + std::size_t(x);
      if (!(w > 0.0) || !(static_cast<float>(nearness) > target.nearness[i])) continue;
      target.nearness[i] = static_cast<float>(nearness);
      target.samples[i] = {Vector2(u / w * target.source.width, v / w * target.source.height), state};
    }
  }
}

inline void fill_triangles(const DepthTarget& target, const DepthMesh& mesh, std::span<const std::uint32_t> triangles,
                           SourceState state) {
  const auto& vertices = mesh.vertices();
  for (std::size_t i = 0; i + 2 < triangles.size(); i += 3) {
    fill_triangle(target, vertices[triangles[i]], vertices[triangles[i + 1]], vertices[triangles[i + 2]], state);
  }
}

}  // namespace deflection_detail

/// Fills one sample for each pixel of the panel, row by row from the bottom; `nearness` is working memory of the same
/// length. `source` is the size of the picture that the samples' pixels count in.
inline Coverage rasterize(const DepthMesh& mesh, const PixelSize& panel, const PixelSize& source,
                          std::span<SourceSample> samples, std::span<float> nearness) {
  [[maybe_unused]] const std::size_t pixels = std::size_t(panel.width) * std::size_t(panel.height);
  HOLDFAST_ASSERT(samples.size() == pixels && nearness.size() == pixels, "one sample for each pixel of the panel");
  std::fill(samples.begin(), samples.end(), SourceSample{Vector2::Zero(), SourceState::outside});
  std::fill(nearness.begin(), nearness.end(), -1.0f);
  const deflection_detail::DepthTarget target{panel, source, samples, nearness};
  deflection_detail::fill_triangles(target, mesh, mesh.solid(), SourceState::covered);
  deflection_detail::fill_triangles(target, mesh, mesh.bridges(), SourceState::covered);
  deflection_detail::fill_triangles(target, mesh, mesh.disoccluded(), SourceState::disoccluded);
  Coverage coverage;
  for (const SourceSample& sample : samples) coverage.count(sample.state);
  return coverage;
}

}  // namespace holdfast
