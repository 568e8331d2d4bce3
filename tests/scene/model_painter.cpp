#include <filesystem>

#include <doctest/doctest.h>

#include <holdfast/optics/hmd.hpp>
#include <holdfast/rendering/rendering.hpp>
#include <holdfast/scene/scene.hpp>

using namespace holdfast;
using namespace holdfast::rendering;
using namespace holdfast::scene;

namespace {

/// A square of side 2 in the plane z = 0, facing +Z, with a texture whose lower half is red and upper half blue.
Model flag() {
  Model model;
  ModelMesh mesh;
  for (const auto& corner :
       {std::array{-1.0f, -1.0f}, std::array{1.0f, -1.0f}, std::array{1.0f, 1.0f}, std::array{-1.0f, 1.0f}}) {
    MeshVertex vertex;
    vertex.position = {corner[0], corner[1], 0.0f};
    vertex.normal = {0.0f, 0.0f, 1.0f};
    vertex.uv = {0.5f * (corner[0] + 1.0f), 0.5f * (corner[1] + 1.0f)};
    mesh.vertices.push_back(vertex);
  }
  mesh.indices = {0, 1, 2, 0, 2, 3};
  model.meshes.push_back(mesh);
  io::Image texture(8, 8, {255, 0, 0, 255});
  for (int x = 0; x < 8; ++x)
    for (int y = 4; y < 8; ++y) texture.set(x, y, {0, 0, 255, 255});
  model.textures.push_back(texture);
  ModelMaterial material;
  material.base_colour = Vector4::Ones();
  material.texture = 0;
  model.materials.push_back(material);
  model.parts.push_back({});
  return model;
}

io::Image draw(const Model& model, const Vqs& T_WM, Backend backend, const Toning& toning = {}) {
  const auto context = make_context(backend);
  const EyeModel eye = default_hmd({320, 180}).left;
  RenderTarget target(*context, 320, 180);
  ModelPainter painter(*context, model);
  target.clear();
  painter.draw({.eye = &eye, .X_WE = Rigid()}, T_WM, toning);
  return target.read_rgba();
}

}  // namespace

TEST_CASE("a model is drawn where its similarity puts it, its texture the right way up") {
  const EyeModel eye = default_hmd({320, 180}).left;
  for (const Backend backend : built_backends()) {
    const Vector3 place(0.1, 0.05, -1.0);
    const io::Image image = draw(flag(), fit_to(flag(), 0.2, place), backend);
    const auto at = [&](const Vector3& offset) {
      const auto pixel = project(eye, place + offset);
      return image.at(static_cast<int>(pixel->x()), static_cast<int>(pixel->y()));
    };
    const io::Rgba low = at(Vector3(0.0, -0.05, 0.0)), high = at(Vector3(0.0, 0.05, 0.0));
    CHECK(low[0] > 100);
    CHECK(low[2] == 0);
    CHECK(high[2] > 100);
    CHECK(high[0] == 0);
    for (const Vector3& outside :
         {Vector3(0.11, 0, 0), Vector3(-0.11, 0, 0), Vector3(0, 0.11, 0), Vector3(0, -0.11, 0)}) {
      CHECK(at(outside) == io::Rgba{0, 0, 0, 255});
    }
  }
}

TEST_CASE("a part that is mirrored is lit on the side that is seen") {
  Model mirrored = flag();
  mirrored.parts[0].model_from_mesh(0, 0) = -1.0;
  const Vqs T_WM = fit_to(flag(), 0.2, Vector3(0, 0, -1));
  const io::Image a = draw(flag(), T_WM, built_backends().front());
  const io::Image b = draw(mirrored, T_WM, built_backends().front());
  CHECK(a.at(160, 80) == b.at(160, 80));  // same light: the normal still points to the eye
}

TEST_CASE("toning: no saturation is grey, a tint multiplies") {
  const Vqs T_WM = fit_to(flag(), 0.2, Vector3(0, 0, -1));
  const io::Rgba grey = draw(flag(), T_WM, built_backends().front(), {.saturation = 0.0f}).at(160, 80);
  CHECK(grey[0] == grey[1]);
  CHECK(grey[1] == grey[2]);
  CHECK(grey[0] > 0);
  const io::Rgba full = draw(flag(), T_WM, built_backends().front()).at(160, 80);
  const io::Rgba half = draw(flag(), T_WM, built_backends().front(), {.tint = Vector3(0.5, 1.0, 1.0)}).at(160, 80);
  CHECK(std::abs(2 * half[0] - full[0]) <= 1);
}

TEST_CASE("a model hides what is behind it and is hidden by what is before it") {
  const auto context = make_context();
  const EyeModel eye = default_hmd({640, 360}).left;
  RegistrationScene scene = default_registration_scene();
  scene.discs.clear();
  for (const double z : {-0.5, -2.0}) {
    Disc disc;
    disc.centre_W = Vector3(z == -0.5 ? -0.02 : 0.16, 0.0, z);
    disc.radius_m = 0.02;
    disc.color = Vector3(0.0, 1.0, 0.0);
    scene.discs.push_back(disc);
  }
  RenderTarget target(*context, 640, 360, 4);
  RegistrationScenePainter painter(*context, scene);
  ModelPainter model(*context, flag());
  const View view{.eye = &eye, .X_WE = Rigid()};
  SceneStyle style = virtual_style();
  style.corner = style.edge = style.board = false;
  target.clear();
  painter.draw_solid(view, style);
  model.draw(view, fit_to(flag(), 0.3, Vector3(0, 0, -1)), style.model_toning);
  painter.draw_flat(view, style);
  const io::Image image = target.read_rgba();
  const auto near_disc = project(eye, scene.discs[0].centre_W), far_disc = project(eye, scene.discs[1].centre_W);
  CHECK(image.at(static_cast<int>(near_disc->x()), static_cast<int>(near_disc->y())) == io::Rgba{0, 255, 0, 255});
  CHECK(image.at(static_cast<int>(far_disc->x()), static_cast<int>(far_disc->y()))[1] < 100);
}

TEST_CASE("both backends draw a real model alike") {
  const std::filesystem::path file = "/usr/share/assimp/models/Collada/duck.dae";
  if (!std::filesystem::exists(file) || built_backends().size() < 2) {
    MESSAGE("skipped: needs both backends and " << file.string() << " (Debian: assimp-testmodels)");
    return;
  }
  const Model duck = load_model(file);
  const io::Image a = draw(duck, default_place(duck), Backend::osmesa),
                  b = draw(duck, default_place(duck), Backend::egl);
  const ImageDifference d = compare(a, b);
  INFO(describe(d));
  CHECK(d.within(1));
  CHECK(compare(a, io::Image(320, 180)).differing_pixels > 1000);  // and there is something to see
}
