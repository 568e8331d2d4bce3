#include <sstream>

#include <doctest/doctest.h>

#include <holdfast/io/mesh_writer.hpp>
#include <holdfast/optics/optics.hpp>

using namespace holdfast;

namespace {

EyeModel chromatic_eye() {
  EyeModel eye = default_hmd().left;
  eye.lens_red = Lens(RadialLens{0.18}, placed_at(eye.tangents.up));
  return eye;
}

struct Obj {
  std::vector<std::array<float, 3>> v;
  std::vector<std::array<float, 2>> vt;
  std::vector<std::array<std::size_t, 6>> f;
  std::vector<std::string> objects;
};

/// A reader of its own: what the format says, and nothing else may be in the file.
Obj parse(const std::string& text) {
  Obj obj;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    if (kind == "v") {
      auto& v = obj.v.emplace_back();
      words >> v[0] >> v[1] >> v[2];
    } else if (kind == "vt") {
      auto& vt = obj.vt.emplace_back();
      words >> vt[0] >> vt[1];
    } else if (kind == "f") {
      auto& f = obj.f.emplace_back();
      char slash;
      for (std::size_t k = 0; k < 6; k += 2) words >> f[k] >> slash >> f[k + 1];
    } else if (kind == "o") {
      words >> obj.objects.emplace_back();
    } else {
      CHECK(kind == "#");
      continue;
    }
    CHECK_FALSE(words.fail());
  }
  return obj;
}

}  // namespace

TEST_CASE("JSON gives back every number of the mesh") {
  for (const EyeModel& eye : {default_hmd().left, chromatic_eye()}) {
    const PredistortionMesh mesh = adaptive_mesh(eye, LensMode::exact, {.max_error_px = 2.0});
    REQUIRE(mesh.ok());
    const nlohmann::json json = nlohmann::json::parse(io::mesh_json(mesh, "a \"quoted\" name", EyeSide::right));
    CHECK(json["schema"] == "holdfast/mesh/1");
    CHECK(json["hmd"] == "a \"quoted\" name");
    CHECK(json["eye"] == "right");
    CHECK(json["resolution_px"] == nlohmann::json({1280, 720}));
    CHECK(json["per_color"] == mesh.per_color);
    CHECK(json["max_error_px"].get<double>() == mesh.max_error_px);
    REQUIRE(json["vertices"].size() == mesh.vertices.size());
    REQUIRE(json["triangles"].size() == mesh.triangle_count());
    bool same = true;
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      const PredistortionVertex& v = mesh.vertices[i];
      std::vector<float> expected{v.panel_x, v.panel_y};
      for (std::size_t c = mesh.per_color ? 0 : 1; c < (mesh.per_color ? 3u : 2u); ++c) {
        expected.insert(expected.end(), {v.tangent[c][0], v.tangent[c][1]});
      }
      same = same && json["vertices"][i].get<std::vector<float>>() == expected;
    }
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      same = same && json["triangles"][i / 3][i % 3] == mesh.triangles[i];
    }
    CHECK(same);
  }
}

TEST_CASE("OBJ: vertices on the panel, texture coordinates in the source picture, per colour") {
  const EyeModel eye = chromatic_eye();
  const PredistortionMesh mesh = grid_mesh(eye, LensMode::exact, 4, 3);
  REQUIRE(mesh.per_color);
  const FieldTangents source{-2.0, 2.0, -1.5, 1.0};
  const Obj obj = parse(io::mesh_obj(mesh, "name\nv 1 2 3", EyeSide::left, source));
  const std::size_t n = mesh.vertices.size();
  REQUIRE(obj.v.size() == n);
  REQUIRE(obj.vt.size() == 3 * n);
  REQUIRE(obj.f.size() == 3 * mesh.triangle_count());
  CHECK(obj.objects == std::vector<std::string>{"red", "green", "blue"});
  for (std::size_t i = 0; i < n; ++i) {
    CHECK(obj.v[i] == std::array{mesh.vertices[i].panel_x, mesh.vertices[i].panel_y, 0.0f});
    for (std::size_t c = 0; c < 3; ++c) {
      CHECK(obj.vt[c * n + i][0] == doctest::Approx((mesh.vertices[i].tangent[c][0] + 2.0) / 4.0).epsilon(1e-6));
      CHECK(obj.vt[c * n + i][1] == doctest::Approx((mesh.vertices[i].tangent[c][1] + 1.5) / 2.5).epsilon(1e-6));
    }
  }
  for (std::size_t i = 0; i < obj.f.size(); ++i) {
    const std::size_t c = i / mesh.triangle_count(), t = i % mesh.triangle_count();
    for (std::size_t k = 0; k < 3; ++k) {
      CHECK(obj.f[i][2 * k] == mesh.triangles[3 * t + k] + 1);  // counted from 1
      CHECK(obj.f[i][2 * k + 1] == mesh.triangles[3 * t + k] + 1 + c * n);
    }
  }
  const Obj plain =
      parse(io::mesh_obj(grid_mesh(default_hmd().left, LensMode::exact, 2, 2), "n", EyeSide::left, source));
  CHECK(plain.objects == std::vector<std::string>{"panel"});
  CHECK(plain.vt.size() == plain.v.size());
}

TEST_CASE("an empty mesh is written as such") {
  const nlohmann::json json = nlohmann::json::parse(io::mesh_json({}, "", EyeSide::left));
  CHECK(json["vertices"].empty());
  CHECK(json["triangles"].empty());
  CHECK(parse(io::mesh_obj({}, "", EyeSide::left, {})).v.empty());
}

TEST_CASE("a name that is not UTF-8 is mended, not thrown at") {
  const nlohmann::json json = nlohmann::json::parse(io::mesh_json({}, "Goo\xffgle", EyeSide::left));
  CHECK(json["hmd"] == "Goo\xef\xbf\xbdgle");
}
