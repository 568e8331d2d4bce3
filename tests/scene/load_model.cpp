#include <filesystem>
#include <fstream>
#include <string>

#include <doctest/doctest.h>

#include <holdfast/scene/load_model.hpp>

using namespace holdfast;
using namespace holdfast::scene;

namespace {

std::filesystem::path scratch() {
  const auto folder = std::filesystem::temp_directory_path() / "holdfast_test_scene";
  std::filesystem::create_directories(folder);
  return folder;
}

/// An OBJ with one square of two triangles, its material file and, unless empty, its texture's name.
std::filesystem::path write_square(const std::string& name, const std::string& texture) {
  const auto folder = scratch();
  std::ofstream(folder / (name + ".mtl")) << "newmtl paper\nKd 0.25 0.5 0.75\n"
                                          << (texture.empty() ? "" : "map_Kd " + texture + "\n");
  std::ofstream(folder / (name + ".obj")) << "mtllib " << name << ".mtl\nusemtl paper\n"
                                          << "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
                                          << "f 1/1 2/2 3/3 4/4\n";
  return folder / (name + ".obj");
}

const std::filesystem::path models = "/usr/share/assimp/models";

}  // namespace

TEST_CASE("a square: two triangles, made-up normals, texture coordinates and colour as written") {
  const Model model = load_model(write_square("plain", ""));
  CHECK(model.name == "plain.obj");
  CHECK(model.triangle_count() == 2);
  CHECK(model.warnings.empty());
  REQUIRE(model.parts.size() == 1);
  const ModelMesh& mesh = model.meshes[model.parts[0].mesh];
  for (const auto& vertex : mesh.vertices) {
    CHECK(std::abs(vertex.normal[2]) == doctest::Approx(1.0));
    // (x, y) from -1 to 1 and (u, v) from 0 to 1 run together: v = 0 is the bottom
    CHECK(vertex.uv[0] == doctest::Approx(0.5 * (vertex.position[0] + 1.0f)));
    CHECK(vertex.uv[1] == doctest::Approx(0.5 * (vertex.position[1] + 1.0f)));
  }
  CHECK((model.materials[mesh.material].base_colour.head<3>() - Vector3(0.25, 0.5, 0.75)).norm() < 1e-6);
}

TEST_CASE("a texture beside the model is found, with Windows separators and other letter case too") {
  io::write_png(scratch() / "Paper.PNG", io::Image(4, 2, {1, 2, 3, 255}));
  for (const char* name : {"Paper.PNG", ".\\Paper.PNG", "C:\\art\\paper.png"}) {
    CAPTURE(name);
    const Model model = load_model(write_square("textured", name));
    CHECK(model.warnings.empty());
    REQUIRE(model.textures.size() == 1);
    CHECK(model.textures[0] == io::Image(4, 2, {1, 2, 3, 255}));
    CHECK(model.materials[model.meshes[0].material].texture == 0);
  }
}

TEST_CASE("a texture that is missing or broken leaves a warning that names it, and the model usable") {
  const Model missing = load_model(write_square("missing", "nowhere.png"));
  REQUIRE(missing.warnings.size() == 1);
  CHECK(missing.warnings[0].find("nowhere.png") != std::string::npos);
  CHECK(missing.warnings[0].find("paper") != std::string::npos);
  CHECK(missing.triangle_count() == 2);

  std::ofstream(scratch() / "broken.png") << "this is not a picture";
  const Model broken = load_model(write_square("broken", "broken.png"));
  REQUIRE(broken.warnings.size() == 1);
  CHECK(broken.warnings[0].find("PNG, JPEG or TGA") != std::string::npos);
}

TEST_CASE("files that are no models are refused in words") {
  CHECK_THROWS_WITH_AS(static_cast<void>(load_model(scratch() / "absent.glb")),
                       doctest::Contains("absent.glb: no such file"), io::InputError);
  CHECK_THROWS_WITH_AS(static_cast<void>(load_model(scratch())), doctest::Contains("not a file"), io::InputError);
  std::ofstream(scratch() / "text.glb") << "not a model at all";
  CHECK_THROWS_WITH_AS(static_cast<void>(load_model(scratch() / "text.glb")),
                       doctest::Contains("text.glb: assimp cannot read"), io::InputError);
  std::ofstream(scratch() / "points.obj") << "v 0 0 0\nv 1 0 0\nv 2 0 0\nl 1 2 3\n";
  CHECK_THROWS_AS(static_cast<void>(load_model(scratch() / "points.obj")), io::InputError);
}

TEST_CASE("models of assimp's collection: GLB with and without texture, OBJ with JPEG, DAE with TGA") {
  if (!std::filesystem::exists(models)) {
    MESSAGE("skipped: " << models.string() << " is absent (Debian: assimp-testmodels)");
    return;
  }
  const Model engine = load_model(models / "glTF2/2CylinderEngine-glTF-Binary/2CylinderEngine.glb");
  CHECK(engine.triangle_count() == 121496);
  CHECK(engine.parts.size() == 115);  // 34 meshes at many nodes
  CHECK(engine.warnings.empty());

  const Model box = load_model(models / "glTF2/BoxTextured-glTF-Binary/BoxTextured.glb");
  CHECK(box.triangle_count() == 12);
  REQUIRE(box.textures.size() == 1);  // PNG within the GLB
  CHECK(box.textures[0].width == 211);

  const Model spider = load_model(models / "OBJ/spider.obj");
  CHECK(spider.textures.size() == 5);  // JPEG, one of them progressive
  CHECK(spider.warnings.empty());

  const Model duck = load_model(models / "Collada/duck.dae");
  REQUIRE(duck.textures.size() == 1);  // TGA
  CHECK(duck.textures[0].width == 512);
  // The duck is yellow: most of its texture has much red and green, and little blue.
  const io::Rgba feather = duck.textures[0].at(256, 100);
  CHECK(feather[0] > 150);
  CHECK(feather[1] > 120);
  CHECK(feather[2] < 100);

  CHECK_THROWS_AS(static_cast<void>(load_model(models / "glTF2/BoxWithInfinites-glTF-Binary/BoxWithInfinites.glb")),
                  io::InputError);
  CHECK_THROWS_WITH_AS(static_cast<void>(load_model(models / "glTF2/MissingBin/BoxTextured.gltf")),
                       doctest::Contains("BoxTextured0.bin"), io::InputError);
}
