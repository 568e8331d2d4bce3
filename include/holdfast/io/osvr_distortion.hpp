/// The "distortion" of an OSVR display descriptor: from JSON to the lens of one eye.
///
/// OSVR maps fractions of the eye's screen to fractions of its canonical rectangle, both from the lower left. Both lie
/// on the same rectangle of tangents here, so that a lens works on fractions and its placement does the rest.
/// Polynomials (rgb_symmetric_polynomials): with D = distance_scale, COP = center_proj, o = (p - COP) .* D,
///     p' = COP + ((a0 + a1 |o| + a2 |o|^2 + ...) o / |o|) ./ D
/// Point samples: [[screen], [canonical]] per eye, in the descriptor, in a file beside it, or built into OSVR (whose
/// files, builtin_osvr_*.json, are then looked for beside the descriptor). k1_red|green|blue alone are refused unless
/// all are zero: OSVR gives no formula for them, and its RenderManager ignores them. Source: OSVR-Docs
/// Configuring/distortion.md; OSVR-RenderManager.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <holdfast/io/json_reader.hpp>
#include <holdfast/io/lens_reader.hpp>
#include <holdfast/io/osvr_types.hpp>
#include <holdfast/optics/lens.hpp>

namespace holdfast::io::detail {

/// Green stands for the geometry; red and blue only when they differ.
struct OsvrLenses {
  Lens green;
  std::optional<Lens> red;
  std::optional<Lens> blue;
};

/// Where an eye's rectangle of tangents lies.
struct OsvrScreen {
  std::size_t eye = 0;  ///< 0 left, 1 right
  Vector2 centre_of_projection{0.5, 0.5};
  Vector2 centre = Vector2::Zero();  ///< the centre of projection's tangent
  Vector2 size = Vector2::Ones();    ///< tangents across and up
};

inline constexpr std::array<std::string_view, 3> osvr_colours{"red", "green", "blue"};

[[nodiscard]] inline OsvrLenses osvr_lenses(const std::array<Lens, 3>& rgb, bool red_differs, bool blue_differs) {
  OsvrLenses lenses{rgb[1], std::nullopt, std::nullopt};
  if (red_differs) lenses.red = rgb[0];
  if (blue_differs) lenses.blue = rgb[2];
  return lenses;
}

inline Lens osvr_polynomial(const JsonNode& node, const std::vector<double>& a, const LensPlacement& placement) {
  if (a[0] != 0.0) {
    node.elements(a.size(), a.size())[0].fail("a constant term tears the picture at its centre", "0");
  }
  const std::vector<double> c(a.begin() + 1, a.end());
  if (const LensProblem problem = PowerSeriesLens::problem_of(c); problem != LensProblem::none) {
    node.fail(std::string(describe(problem)), "coefficients a0 = 0, a1 > 0, a2 ...");
  }
  const bool is_identity = c[0] == 1.0 && std::all_of(c.begin() + 1, c.end(), [](double k) { return k == 0.0; });
  if (is_identity) return NoLens{};
  return Lens(PowerSeriesLens(c), placement);
}

inline OsvrLenses osvr_polynomials(const JsonNode& node, const OsvrScreen& screen) {
  node.allow_only({"type", "distance_scale_x", "distance_scale_y", "polynomial_coeffs_red", "polynomial_coeffs_green",
                   "polynomial_coeffs_blue", "k1_red", "k1_green", "k1_blue"});
  const Vector2 D(number_or(node, "distance_scale_x", 1.0, 1e-6, 1e6),
                  number_or(node, "distance_scale_y", 1.0, 1e-6, 1e6));
  const LensPlacement placement{screen.centre, screen.size.cwiseQuotient(D)};
  std::array<Lens, 3> lenses;
  std::array<std::vector<double>, 3> a;
  for (std::size_t i = 0; i < 3; ++i) {
    const JsonNode list = node.at("polynomial_coeffs_" + std::string(osvr_colours[i]));
    for (const JsonNode& e : list.elements(2, PowerSeriesLens::max_coefficients + 1))
      a[i].push_back(e.number(-1e9, 1e9));
    lenses[i] = osvr_polynomial(list, a[i], placement);
  }
  return osvr_lenses(lenses, a[0] != a[1], a[2] != a[1]);
}

/// The samples of one eye, relative to the centre of projection.
inline std::vector<PointMeshSample> osvr_samples(const JsonNode& node, const Vector2& centre) {
  std::vector<PointMeshSample> samples;
  constexpr double farthest = 1000.0;  // screen widths
  for (const JsonNode& e : node.elements(3, most_mesh_samples)) {
    const std::vector<JsonNode> pair = e.elements(2, 2);
    samples.push_back({read_vector2(pair[0], farthest) - centre, read_vector2(pair[1], farthest) - centre});
  }
  return samples;
}

/// Of a list with one mesh for each eye, that of the screen's.
inline JsonNode osvr_mesh_of_eye(const JsonNode& list, const OsvrScreen& screen) {
  return list.elements(2, 2)[screen.eye];
}

inline OsvrLenses osvr_mono_mesh(const JsonNode& list, const OsvrScreen& screen) {
  const JsonNode mesh = osvr_mesh_of_eye(list, screen);
  const PointMeshLens lens = point_mesh_lens(osvr_samples(mesh, screen.centre_of_projection), mesh);
  return {Lens(lens, LensPlacement{screen.centre, screen.size}), std::nullopt, std::nullopt};
}

inline OsvrLenses osvr_rgb_mesh(const JsonNode& node, const OsvrScreen& screen) {
  std::array<Lens, 3> lenses;
  std::array<std::vector<PointMeshSample>, 3> samples;
  for (std::size_t i = 0; i < 3; ++i) {
    const JsonNode list = osvr_mesh_of_eye(node.at(std::string(osvr_colours[i]) + "_point_samples"), screen);
    samples[i] = osvr_samples(list, screen.centre_of_projection);
    if (samples[i].size() != samples[0].size()) {
      list.fail("the colours' meshes differ in length: red has " + std::to_string(samples[0].size()) + " samples, " +
                    std::string(osvr_colours[i]) + " " + std::to_string(samples[i].size()),
                "as many samples for each colour of an eye");
    }
    lenses[i] = Lens(point_mesh_lens(samples[i], list), LensPlacement{screen.centre, screen.size});
  }
  return osvr_lenses(lenses, samples[0] != samples[1], samples[2] != samples[1]);
}

/// The file that OSVR would have built in. Its name is refused when OSVR has none of that name.
inline std::string osvr_built_in_file(const JsonNode& name) {
  switch (name.choice({"OSVR_HDK_13_V1", "OSVR_HDK_13_V2", "OSVR_HDK_20_V1"})) {
    case 0:
      return "builtin_osvr_hdk13_v1.json";
    case 1:
      return "builtin_osvr_hdk13_v2.json";
    default:
      return "builtin_osvr_hdk20_v1.json";
  }
}

inline std::string osvr_external_file(const JsonNode& node) {
  const std::string name = node.string();
  if (name.empty() || name.find_first_of("/\\:") != std::string::npos || name == "." || name == "..") {
    node.fail("not the plain name of a file", "the name of a file beside the descriptor");
  }
  return name;
}

/// Calls visit(distortion) with the distortion that the file `name` beside the descriptor holds.
template <typename Visit>
OsvrLenses in_file_beside(const std::string& name, const BesideReader& beside, const Visit& visit) {
  const NamedText found = beside(name);
  const JsonDocument document = JsonDocument::parse(found.text, found.file);
  const JsonNode root = document.root();
  const std::optional<JsonNode> display = root.find("display");
  return visit((display ? *display : root).at("hmd").at("distortion"));
}

inline OsvrLenses osvr_mono(const JsonNode& node, const OsvrScreen& screen, const BesideReader& beside) {
  node.allow_only({"type", "mono_point_samples", "mono_point_samples_built_in", "mono_point_samples_external_file",
                   "k1_red", "k1_green", "k1_blue"});
  const auto from = [&](const JsonNode& distortion) {
    return osvr_mono_mesh(distortion.at("mono_point_samples"), screen);
  };
  if (const auto name = node.find("mono_point_samples_built_in")) {
    return in_file_beside(osvr_built_in_file(*name), beside, from);
  }
  if (const auto name = node.find("mono_point_samples_external_file")) {
    return in_file_beside(osvr_external_file(*name), beside, from);
  }
  return from(node);
}

inline OsvrLenses osvr_rgb(const JsonNode& node, const OsvrScreen& screen, const BesideReader& beside) {
  node.allow_only({"type", "red_point_samples", "green_point_samples", "blue_point_samples",
                   "rgb_point_samples_external_file", "k1_red", "k1_green", "k1_blue"});
  const auto from = [&](const JsonNode& distortion) { return osvr_rgb_mesh(distortion, screen); };
  if (const auto name = node.find("rgb_point_samples_external_file")) {
    return in_file_beside(osvr_external_file(*name), beside, from);
  }
  return from(node);
}

inline OsvrLenses osvr_k1(const JsonNode& node, std::vector<std::string>& notes) {
  node.allow_only({"type", "k1_red", "k1_green", "k1_blue"});
  for (const std::string_view colour : osvr_colours) {
    const std::optional<JsonNode> k1 = node.find("k1_" + std::string(colour));
    if (!k1 || k1->number(-1e6, 1e6) == 0.0) continue;
    k1->fail(
        "rgb_k1_coefficients alone describe no lens: OSVR gives no formula for k1, and its RenderManager ignores it",
        "polynomial_coeffs_red, _green and _blue, or point samples");
  }
  notes.push_back("no distortion is described: the lens is taken as free of it");
  return {};
}

/// The kind that "type" names or, as in OSVR, that the keys show.
inline std::size_t osvr_distortion_kind(const JsonNode& node) {
  if (const auto type = node.find("type")) {
    return type->choice(
        {"rgb_symmetric_polynomials", "mono_point_samples", "rgb_point_samples", "rgb_k1_coefficients"});
  }
  const auto has = [&](std::initializer_list<std::string_view> keys) {
    return std::any_of(keys.begin(), keys.end(), [&](std::string_view key) { return node.find(key).has_value(); });
  };
  if (has({"polynomial_coeffs_red", "polynomial_coeffs_green", "polynomial_coeffs_blue"})) return 0;
  if (has({"mono_point_samples", "mono_point_samples_built_in", "mono_point_samples_external_file"})) return 1;
  if (has({"red_point_samples", "green_point_samples", "blue_point_samples", "rgb_point_samples_external_file"}))
    return 2;
  return 3;
}

inline OsvrLenses read_osvr_distortion(const JsonNode& node, const OsvrScreen& screen, const BesideReader& beside,
                                       std::vector<std::string>& notes) {
  switch (osvr_distortion_kind(node)) {
    case 0:
      return osvr_polynomials(node, screen);
    case 1:
      return osvr_mono(node, screen, beside);
    case 2:
      return osvr_rgb(node, screen, beside);
    default:
      return osvr_k1(node, notes);
  }
}

}  // namespace holdfast::io::detail
