// A scene of planes, a sphere and boards, known in closed form: what depth deflection is judged against.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include <holdfast/deflection/depth_surface.hpp>
#include <holdfast/deflection/rendered_picture.hpp>
#include <holdfast/geometry/angle.hpp>
#include <holdfast/geometry/rays_planes.hpp>
#include <holdfast/geometry/so3.hpp>

namespace holdfast::test {

// All in the frame S of the picture, whose pose in the world is the view's.
struct DepthScene {
  struct Sphere {
    Vector3 centre;
    double radius;
  };
  struct Board {  // parallel to the picture, at z = -distance
    double distance, left, right, down, up;
  };
  std::vector<Plane> planes;
  std::vector<Sphere> spheres;
  std::vector<Board> boards;

  // Distance along the ray (in lengths of the direction) at which it first meets anything.
  std::optional<double> first_hit(const Vector3& origin, const Vector3& direction) const {
    double first = std::numeric_limits<double>::infinity();
    const auto take = [&](double at) {
      if (at > 1e-9 && at < first) first = at;
    };
    for (const Plane& plane : planes) {
      const double approach = plane.normal.dot(direction);
      if (approach != 0.0) take(-plane.signed_distance(origin) / approach);
    }
    for (const Sphere& sphere : spheres) {
      const Vector3 to_origin = origin - sphere.centre;
      const double a = direction.squaredNorm(), b = to_origin.dot(direction);
      const double inside = b * b - a * (to_origin.squaredNorm() - sphere.radius * sphere.radius);
      if (inside > 0.0) take((-b - std::sqrt(inside)) / a);
    }
    for (const Board& board : boards) {
      if (direction.z() == 0.0) continue;
      const double at = (-board.distance - origin.z()) / direction.z();
      const Vector3 p = origin + at * direction;
      if (p.x() >= board.left && p.x() <= board.right && p.y() >= board.down && p.y() <= board.up) take(at);
    }
    if (!std::isfinite(first)) return std::nullopt;
    return first;
  }

  DepthImage depth_image(const RenderedView& view) const {
    DepthImage depth{view.size, {}};
    for (int y = 0; y < view.size.height; ++y) {
      for (int x = 0; x < view.size.width; ++x) {
        const Vector2 t_S = tangent_of_source_pixel(view, Vector2(x + 0.5, y + 0.5));
        // The direction's z is -1, so that lengths along it are distances along -Z.
        const auto hit = first_hit(Vector3::Zero(), direction_of_tangents(t_S));
        depth.distance_m.push_back(hit ? static_cast<float>(*hit) : std::numeric_limits<float>::infinity());
      }
    }
    return depth;
  }

  // What the eye at X_SE sees at t_E, as a tangent of S; whether S saw it too.
  struct Truth {
    Vector2 t_S = Vector2::Zero();
    bool was_seen = false;
  };
  std::optional<Truth> truth(const Rigid& X_SE, const Vector2& t_E) const {
    const Vector3 direction = X_SE.q() * direction_of_tangents(t_E);
    const auto hit = first_hit(X_SE.p(), direction);
    if (!hit) {
      const auto t_S = tangents_of_point(direction);
      if (!t_S) return std::nullopt;
      return Truth{*t_S, !first_hit(Vector3::Zero(), direction)};
    }
    const Vector3 p_S = X_SE.p() + *hit * direction;
    const auto t_S = tangents_of_point(p_S);
    if (!t_S) return std::nullopt;
    const auto seen = first_hit(Vector3::Zero(), p_S);
    return Truth{*t_S, seen && *seen > 1.0 - 1e-9};
  }
};

// A room: a floor, a slanted wall, a ball and a board before them.
inline DepthScene room() {
  DepthScene scene;
  scene.planes.push_back(*Plane::make(Vector3(0, 1, 0), Vector3(0, -0.6, 0)));
  scene.planes.push_back(*Plane::make(Vector3(-0.6, 0.1, 1), Vector3(0, 0, -3)));
  scene.spheres.push_back({Vector3(0.25, -0.05, -1.2), 0.25});
  scene.boards.push_back({0.8, -0.45, -0.15, -0.25, 0.3});
  return scene;
}

// The view of a picture 15 % wider than the default eye's, from a place where no axis is the world's.
inline RenderedView wide_view(const PixelSize& size) {
  const double half_x = 1.15 * tan(degrees(30)), half_y = half_x * size.height / size.width;
  return {Rigid(so3::exp<double>(Vector3(0.4, -1.0, 0.3)), Vector3(3, 1, -2)),
          {-half_x, half_x, -half_y, half_y},
          size,
          {}};
}

// Within `reach` px of an edge of the depth image.
inline bool near_edge(const DepthSurface& surface, const Vector2& t_S, int reach) {
  const Vector2 pixel = surface.pixel_of_tangent(t_S);
  const int x = static_cast<int>(std::floor(pixel.x())), y = static_cast<int>(std::floor(pixel.y()));
  for (int j = std::max(0, y - reach); j <= std::min(surface.size().height - 2, y + reach); ++j) {
    for (int i = std::max(0, x - reach); i <= std::min(surface.size().width - 2, x + reach); ++i) {
      if (!surface.linked_right(i, j) || !surface.linked_up(i, j)) return true;
    }
  }
  return false;
}

}  // namespace holdfast::test
