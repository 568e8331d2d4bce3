/// The surface that a depth image describes: a facet per pixel, linked to its neighbours or cut off from them.
///
/// In the space of tangents and inverse distance, (t_x, t_y, w = 1/z), straight lines and planes of the world stay
/// straight and flat. So each pixel carries a flat facet, w at its centre with the slope that its linked neighbours
/// give: a plane in the world is met exactly, however slanted. Neighbours are linked when w changes little from one to
/// the other (by at most link_tolerance of the nearer), or changes as it did just before or does just after (a steep
/// but smooth surface); else an edge lies between them, half way, and what is nearer hides what is behind.
/// Shape: one facet per pixel of the depth image; pixels of the depth image, origin at the lower left, centres at half
/// integers. update() allocates only when the image is larger than any before. Bad input: a DepthProblem names it; a
/// pixel that is no distance (NaN, below a micrometre, negative) counts as nothing drawn, see bad_pixels.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <holdfast/deflection/depth_image.hpp>
#include <holdfast/deflection/rendered_picture.hpp>

namespace holdfast {

/// A pixel's piece of the surface: inverse distance as a linear function of the pixel.
struct DepthFacet {
  Vector2 centre = Vector2::Zero();  ///< px
  double w = 0.0;                    ///< inverse distance there, 1/m
  Vector2 slope = Vector2::Zero();   ///< 1/m per px

  [[nodiscard]] double at(const Vector2& pixel) const { return w + slope.dot(pixel - centre); }
};

class DepthSurface {
 public:
  explicit DepthSurface(double link_tolerance = 0.01) : link_tolerance_(static_cast<float>(link_tolerance)) {}

  /// Takes over a depth image that was drawn with `view`; on a problem the surface is left empty.
  DepthProblem update(const RenderedView& view, const DepthImage& depth) {
    size_ = {};
    bad_pixels_ = 0;
    nearest_ = steepest_ = 0.0f;
    const DepthProblem problem = holdfast::problem_of(depth);
    if (problem != DepthProblem::none) return problem;
    if (holdfast::problem_of(view.tangents) != FieldProblem::none) return DepthProblem::no_field;
    view_ = view;
    view_.size = size_ = depth.size;  // from here on pixels are the depth image's
    w_.resize(depth.distance_m.size());
    links_.resize(depth.distance_m.size());
    for (std::size_t i = 0; i < w_.size(); ++i) w_[i] = inverse(depth.distance_m[i]);
    for (int y = 0; y < size_.height; ++y) {
      for (int x = 0; x < size_.width; ++x) links_[index(x, y)] = links_of(x, y);
    }
    return problem;
  }
  /// The same from a depth image that is bound to its view.
  DepthProblem update(const RenderedPicture<DepthImage>& depth) { return update(depth.view(), depth.picture()); }

  [[nodiscard]] const PixelSize& size() const { return size_; }  ///< of the depth image; zero: empty
  [[nodiscard]] bool is_empty() const { return size_.width == 0; }
  [[nodiscard]] std::size_t bad_pixels() const { return bad_pixels_; }
  /// No facet reaches a greater inverse distance, 1/m.
  [[nodiscard]] double greatest_w() const { return double(nearest_) + double(steepest_); }

  [[nodiscard]] Vector2 pixel_of_tangent(const Vector2& t_S) const { return source_pixel_of_tangent(view_, t_S); }
  [[nodiscard]] Vector2 tangent_of_pixel(const Vector2& pixel) const { return tangent_of_source_pixel(view_, pixel); }
  [[nodiscard]] Vector2 pixels_per_tangent() const { return holdfast::pixels_per_tangent(view_); }

  /// Whether the surface goes on from a pixel to its right or upper neighbour.
  [[nodiscard]] bool linked_right(int x, int y) const { return (links_[index(x, y)] & right_bit) != 0; }
  [[nodiscard]] bool linked_up(int x, int y) const { return (links_[index(x, y)] & up_bit) != 0; }
  /// Whether it goes on to the neighbour at (x + dx, y + dy), one of the four; not beyond the image's edge.
  [[nodiscard]] bool linked(int x, int y, int dx, int dy) const {
    const int left = x + std::min(dx, 0), below = y + std::min(dy, 0);
    if (left < 0 || below < 0) return false;
    return dx != 0 ? linked_right(left, y) : linked_up(x, below);
  }

  [[nodiscard]] double w(int x, int y) const { return double(w_[index(x, y)]); }

  [[nodiscard]] DepthFacet facet(int x, int y) const {
    return {Vector2(x + 0.5, y + 0.5), w(x, y),
            Vector2(slope(x, y, x > 0 && linked_right(x - 1, y), linked_right(x, y), 1, 0),
                    slope(x, y, y > 0 && linked_up(x, y - 1), linked_up(x, y), 0, 1))};
  }

  /// Inverse distance of what the source picture shows at t_S; beyond its edges that of the nearest pixel, extended.
  /// Precondition: not empty.
  [[nodiscard]] double w_at(const Vector2& t_S) const {
    const Vector2 pixel = pixel_of_tangent(t_S);
    const auto nearest = [](double at, int count) {
      return static_cast<int>(std::clamp(std::floor(at), 0.0, double(count - 1)));
    };
    const DepthFacet f = facet(nearest(pixel.x(), size_.width), nearest(pixel.y(), size_.height));
    const Vector2 inside(std::clamp(pixel.x(), 0.0, double(size_.width)),
                         std::clamp(pixel.y(), 0.0, double(size_.height)));
    return std::max(f.at(inside), 0.0);
  }

 private:
  static constexpr std::uint8_t right_bit = 1, up_bit = 2;

  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(size_.width) + static_cast<std::size_t>(x);
  }

  [[nodiscard]] float inverse(float distance) {
    constexpr float nearest_m = 1e-6f;  // what is nearer has no inverse distance to compute with
    if (!(distance >= nearest_m)) {
      ++bad_pixels_;
      return 0.0f;
    }
    const float w = 1.0f / distance;
    nearest_ = std::max(nearest_, w);
    return w;
  }

  /// Whether b follows on a, given the pixel before a and the one after b in the same row or column.
  [[nodiscard]] bool continues(float before, float a, float b, float after) const {
    const float step = b - a;
    if (std::abs(step) <= link_tolerance_ * std::max(a, b)) return true;
    const float half = 0.5f * std::abs(step);
    return std::abs(step - (a - before)) <= half || std::abs(step - (after - b)) <= half;
  }

  [[nodiscard]] std::uint8_t links_of(int x, int y) {
    const std::size_t i = index(x, y);
    const auto row = static_cast<std::size_t>(size_.width);
    std::uint8_t links = 0;
    // At the picture's edge there is no pixel before or after: the pixel itself stands for it, as if level.
    if (x + 1 < size_.width &&
        continues(w_[x > 0 ? i - 1 : i], w_[i], w_[i + 1], w_[x + 2 < size_.width ? i + 2 : i + 1])) {
      links |= right_bit;
      steepest_ = std::max(steepest_, std::abs(w_[i + 1] - w_[i]));
    }
    if (y + 1 < size_.height &&
        continues(w_[y > 0 ? i - row : i], w_[i], w_[i + row], w_[y + 2 < size_.height ? i + 2 * row : i + row])) {
      links |= up_bit;
      steepest_ = std::max(steepest_, std::abs(w_[i + row] - w_[i]));
    }
    return links;
  }

  /// Mean of the steps to the linked neighbours along (dx, dy).
  [[nodiscard]] double slope(int x, int y, bool before, bool after, int dx, int dy) const {
    const double here = w(x, y);
    const double back = before ? here - w(x - dx, y - dy) : 0.0;
    const double ahead = after ? w(x + dx, y + dy) - here : 0.0;
    return before && after ? 0.5 * (back + ahead) : back + ahead;
  }

  float link_tolerance_;
  RenderedView view_;
  PixelSize size_;
  std::vector<float> w_;
  std::vector<std::uint8_t> links_;  // per pixel: to the right, upward
  std::size_t bad_pixels_ = 0;
  float nearest_ = 0.0f;   // greatest w of a pixel
  float steepest_ = 0.0f;  // greatest step between linked pixels
};

}  // namespace holdfast
