#include <doctest/doctest.h>

#include <holdfast/scene/model.hpp>

using namespace holdfast;
using namespace holdfast::scene;

namespace {

/// Two corners of a box, at a node that scales by 2 and shifts.
Model two_corners() {
  Model model;
  ModelMesh mesh;
  mesh.vertices.resize(3);
  mesh.vertices[0].position = {0.0f, 0.0f, 0.0f};
  mesh.vertices[1].position = {1.0f, 0.5f, 0.25f};
  mesh.vertices[2].position = {0.5f, 0.5f, 0.0f};
  mesh.indices = {0, 1, 2};
  model.meshes.push_back(mesh);
  ModelPart part;
  part.model_from_mesh = Vqs(Vector3(10.0, 0.0, 0.0), Quaternion::Identity(), 2.0).matrix();
  model.parts.push_back(part);
  return model;
}

}  // namespace

TEST_CASE("bounds are of the parts as they stand") {
  const Bounds bounds = bounds_of(two_corners());
  CHECK((bounds.low - Vector3(10.0, 0.0, 0.0)).norm() < 1e-12);
  CHECK((bounds.high - Vector3(12.0, 1.0, 0.5)).norm() < 1e-12);
  CHECK(bounds.longest_side() == doctest::Approx(2.0));
  CHECK(two_corners().triangle_count() == 1);
}

TEST_CASE("fit_to puts the middle where asked, as large as asked, however the model is turned") {
  const Model model = two_corners();
  const Vector3 place(0.1, -0.2, -1.0);
  for (const double yaw : {0.0, 1.0, 3.0}) {
    const Quaternion q(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitY()));
    const Vqs T_WM = fit_to(model, 0.3, place, q);
    CHECK((T_WM * bounds_of(model).centre() - place).norm() < 1e-12);
    const Vector3 across = T_WM * Vector3(12.0, 0.0, 0.0) - T_WM * Vector3(10.0, 0.0, 0.0);
    CHECK(across.norm() == doctest::Approx(0.3));
  }
}

TEST_CASE("a model whose vertices coincide keeps its scale") {
  Model model = two_corners();
  for (auto& vertex : model.meshes[0].vertices) vertex.position = {1.0f, 1.0f, 1.0f};
  CHECK(fit_to(model, 0.3, Vector3::Zero()).s() == 1.0);
  CHECK(default_place(model).s() == 1.0);
}
