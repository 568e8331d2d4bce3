/// A lens given by samples (point_mesh.hpp), linear on each triangle of them, with its exact inverse.
///
///     const PointMeshResult result = make_point_mesh(samples);
///     if (result.ok()) eye.lens = Lens(PointMeshLens(result.mesh), placement);
///
/// distort finds the triangle of panel points round p and maps p by it; undistort finds the triangle on the seen side
/// and maps back. Each takes a look-up in a grid and a few multiplications. The domain is what the kept triangles
/// cover; outside, in gaps too, the answer is nothing. valid_radius is that of the largest disc round the origin in the
/// domain, 0 when the origin is outside. Jacobians are constant on a triangle; distort_jacobian is NaN outside. Copies
/// share the mesh.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include <holdfast/assert.hpp>
#include <holdfast/geometry/types.hpp>
#include <holdfast/optics/lens_model.hpp>
#include <holdfast/optics/point_mesh.hpp>

namespace holdfast {

class PointMeshLens {
 public:
  /// Precondition: a mesh from make_point_mesh.
  explicit PointMeshLens(std::shared_ptr<const PointMesh> mesh) : mesh_(std::move(mesh)) {
    HOLDFAST_ASSERT(mesh_ != nullptr && !mesh_->triangles.empty(), "a lens needs a mesh with triangles");
  }

  [[nodiscard]] const PointMesh& mesh() const { return *mesh_; }
  [[nodiscard]] double valid_radius() const { return mesh_->panel_radius; }
  [[nodiscard]] double valid_image_radius() const { return mesh_->seen_radius; }

  [[nodiscard]] std::optional<Vector2> distort(const Vector2& p) const {
    const std::optional<TriangleGrid::Place> place = mesh_->panel_grid.find(p);
    return place ? std::optional<Vector2>(blend(*place, &PointMeshSample::seen)) : std::nullopt;
  }
  [[nodiscard]] std::optional<Vector2> undistort(const Vector2& v) const {
    const std::optional<TriangleGrid::Place> place = mesh_->seen_grid.find(v);
    return place ? std::optional<Vector2>(blend(*place, &PointMeshSample::panel)) : std::nullopt;
  }
  [[nodiscard]] Matrix2 distort_jacobian(const Vector2& p) const {
    const std::optional<TriangleGrid::Place> place = mesh_->panel_grid.find(p);
    if (!place) return Matrix2::Constant(std::numeric_limits<double>::quiet_NaN());
    return mesh_->jacobians[static_cast<std::size_t>(place->triangle)];
  }
  [[nodiscard]] std::optional<Matrix2> undistort_jacobian(const Vector2& v) const {
    const std::optional<TriangleGrid::Place> place = mesh_->seen_grid.find(v);
    if (!place) return std::nullopt;
    return Matrix2(mesh_->jacobians[static_cast<std::size_t>(place->triangle)].inverse());
  }

  /// The same mesh, not one with the same samples.
  friend bool operator==(const PointMeshLens&, const PointMeshLens&) = default;

 private:
  [[nodiscard]] Vector2 blend(const TriangleGrid::Place& place, Vector2 PointMeshSample::*side) const {
    const std::array<int, 3>& t = mesh_->triangles[static_cast<std::size_t>(place.triangle)];
    const auto corner = [&](std::size_t i) -> const Vector2& {
      return mesh_->samples[static_cast<std::size_t>(t[i])].*side;
    };
    return place.weights[0] * corner(0) + place.weights[1] * corner(1) + place.weights[2] * corner(2);
  }

  std::shared_ptr<const PointMesh> mesh_;
};

static_assert(LensModel<PointMeshLens>);

}  // namespace holdfast
