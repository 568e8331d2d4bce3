/// A model as read from a file: meshes, materials, pictures, and where each mesh stands; no GPU needed.
///
/// Frame M: the model's own, in whatever units its file has. fit_to gives the similarity T_WM that sets it at a
/// sensible size and place in the world. Bounds and sizes are of the parts as they stand, all node transforms applied.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <holdfast/geometry/vqs.hpp>
#include <holdfast/io/image.hpp>
#include <holdfast/rendering/mesh.hpp>

namespace holdfast::scene {

struct ModelMaterial {
  std::string name;
  Vector4 base_colour = Vector4(0.8, 0.8, 0.8, 1.0);
  std::optional<std::size_t> texture;  ///< index into Model::textures
  float alpha_cutoff = 0.0f;           ///< fragments less opaque are left out
  bool two_sided = true;
};

struct ModelMesh {
  std::vector<rendering::MeshVertex> vertices;
  std::vector<std::uint32_t> indices;  ///< three per triangle
  std::size_t material = 0;
};

/// One mesh at one place; a mesh may stand in several.
struct ModelPart {
  std::size_t mesh = 0;
  Matrix4 model_from_mesh = Matrix4::Identity();
};

struct Bounds {
  Vector3 low = Vector3::Zero();
  Vector3 high = Vector3::Zero();

  [[nodiscard]] Vector3 centre() const { return 0.5 * (low + high); }
  [[nodiscard]] double longest_side() const { return (high - low).maxCoeff(); }
};

struct Model {
  std::string name;  ///< file name without folder
  std::vector<ModelMesh> meshes;
  std::vector<ModelMaterial> materials;
  std::vector<io::Image> textures;
  std::vector<ModelPart> parts;
  std::vector<std::string>
      warnings;  ///< what had to be left out: a texture not found, points and lines, broken triangles

  [[nodiscard]] std::size_t triangle_count() const {
    std::size_t count = 0;
    for (const ModelPart& part : parts) count += meshes[part.mesh].indices.size() / 3;
    return count;
  }
};

/// Box round all that is drawn, in M. Precondition: there is something to draw (load_model sees to that).
[[nodiscard]] inline Bounds bounds_of(const Model& model) {
  Bounds bounds{Vector3::Constant(1e300), Vector3::Constant(-1e300)};
  for (const ModelPart& part : model.parts) {
    const Matrix3 A = part.model_from_mesh.topLeftCorner<3, 3>();
    const Vector3 b = part.model_from_mesh.topRightCorner<3, 1>();
    for (const rendering::MeshVertex& vertex : model.meshes[part.mesh].vertices) {
      const Vector3 p = A * Vector3(vertex.position[0], vertex.position[1], vertex.position[2]) + b;
      bounds.low = bounds.low.cwiseMin(p);
      bounds.high = bounds.high.cwiseMax(p);
    }
  }
  return bounds;
}

/// T_WM that puts the middle of the model's box at centre_W, turned by q_WM, its longest side size_m long. A model
/// whose vertices all coincide keeps its scale. Precondition: size_m > 0.
[[nodiscard]] inline Vqs fit_to(const Model& model, double size_m, const Vector3& centre_W,
                                const Quaternion& q_WM = Quaternion::Identity()) {
  HOLDFAST_ASSERT(size_m > 0.0, "a model's size is positive");
  const Bounds bounds = bounds_of(model);
  const double longest = bounds.longest_side();
  const double scale = longest > 0.0 ? size_m / longest : 1.0;
  const Vqs turned(Vector3::Zero(), q_WM, scale);
  return Vqs(centre_W - turned * bounds.centre(), q_WM, scale);
}

/// Where a model stands in the default registration scene: its box's diagonal 0.36 m long, 1 m ahead of the first
/// viewpoint, above the frame corner, turned so that two of its sides are seen.
[[nodiscard]] inline Vqs default_place(const Model& model) {
  const Quaternion yaw(Eigen::AngleAxisd(-0.6, Eigen::Vector3d::UnitY()));
  const Quaternion pitch(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX()));
  const Bounds bounds = bounds_of(model);
  const double diagonal = (bounds.high - bounds.low).norm();
  const double size_m = diagonal > 0.0 ? 0.36 * bounds.longest_side() / diagonal : 0.36;
  return fit_to(model, size_m, Vector3(-0.02, 0.10, -1.0), pitch * yaw);
}

}  // namespace holdfast::scene
