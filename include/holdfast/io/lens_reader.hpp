/// The lenses of a headset descriptor (schema "holdfast/hmd/1"): from JSON to Lens. hmd_reader.hpp reads the rest.
///
/// "model" names the model, its other keys are those of the model's header; "r_norm" or "scale", "centre" and "k_pd"
/// place any model (LensPlacement). Bad input: io::InputError with line, key and what was expected.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <holdfast/io/json_reader.hpp>
#include <holdfast/optics/cubic_fit.hpp>
#include <holdfast/optics/lens.hpp>

namespace holdfast::io::detail {

inline constexpr double largest_tangent = 100.0;  // 89.4 degrees: more is a slip, not a headset
inline constexpr double largest_coefficient = 1000.0;
inline constexpr std::size_t most_mesh_samples = 20'000;

inline double number_or(const JsonNode& object, std::string_view key, double fallback, double lowest, double highest) {
  const std::optional<JsonNode> member = object.find(key);
  return member ? member->number(lowest, highest) : fallback;
}

inline Vector2 read_vector2(const JsonNode& node, double largest) {
  const std::vector<JsonNode> e = node.elements(2, 2);
  return {e[0].number(-largest, largest), e[1].number(-largest, largest)};
}

inline std::vector<double> read_coefficients(const JsonNode& node, std::size_t fewest, std::size_t most) {
  std::vector<double> k;
  for (const JsonNode& e : node.elements(fewest, most))
    k.push_back(e.number(-largest_coefficient, largest_coefficient));
  return k;
}

template <std::size_t N>
void read_fixed(const JsonNode& node, std::array<double, N>& numbers) {
  const std::vector<double> k = read_coefficients(node, N, N);
  std::copy(k.begin(), k.end(), numbers.begin());
}

/// Refuses keys that neither the model nor its placement has.
inline void allow_lens_keys(const JsonNode& node, std::initializer_list<std::string_view> of_model) {
  std::vector<std::string_view> keys{"model", "k_pd", "r_norm", "scale", "centre"};
  keys.insert(keys.begin() + 1, of_model.begin(), of_model.end());
  node.allow_only(keys);
}

/// Refuses what the model cannot use, by the model's own words.
inline void require_usable(const JsonNode& node, LensProblem problem) {
  if (problem != LensProblem::none)
    node.fail(std::string(describe(problem)), "coefficients of a lens that can be inverted");
}

inline PolynomialLens read_polynomial(const JsonNode& node) {
  const JsonNode list = node.at("coefficients");
  const std::vector<double> k = read_coefficients(list, 1, PolynomialLens::max_coefficients);
  const double k0 = number_or(node, "k0", 1.0, 0.1, 10.0);
  require_usable(list, PolynomialLens::problem_of(k, k0));
  return PolynomialLens(k, k0);
}

inline PowerSeriesLens read_power_series(const JsonNode& node) {
  const JsonNode list = node.at("coefficients");
  const std::vector<double> c = read_coefficients(list, 1, PowerSeriesLens::max_coefficients);
  require_usable(list, PowerSeriesLens::problem_of(c));
  return PowerSeriesLens(c);
}

/// k1, k2, k3 and, if it is there, k4.
inline ViveLens read_vive(const JsonNode& node) {
  const JsonNode list = node.at("coefficients");
  std::vector<double> k = read_coefficients(list, 3, 4);
  k.resize(4, 0.0);
  const ViveCoefficients c{k[0], k[1], k[2], k[3]};
  require_usable(list, ViveLens::problem_of(c));
  return ViveLens(c);
}

inline CatmullRomLens read_catmull_rom(const JsonNode& node) {
  CatmullRomCoefficients c;
  read_fixed(node.at("knots"), c.knots);
  c.r_max = node.at("r_max").number(1e-6, largest_tangent);
  if (const auto chroma = node.find("chroma")) read_fixed(*chroma, c.chroma);
  require_usable(node, CatmullRomLens::problem_of(c));
  return CatmullRomLens(c);
}

inline KannalaBrandtLens read_kannala_brandt(const JsonNode& node) {
  KannalaBrandtLens::Coefficients k{};
  read_fixed(node.at("coefficients"), k);
  require_usable(node, KannalaBrandtLens::problem_of(k));
  return KannalaBrandtLens(k);
}

/// OpenCV's order: k1, k2, p1, p2 and, as far as they are there, k3, k4, k5, k6.
inline BrownConradyLens read_brown_conrady(const JsonNode& node) {
  const JsonNode list = node.at("coefficients");
  std::vector<double> k = read_coefficients(list, 4, 8);
  k.resize(8, 0.0);
  const BrownConradyCoefficients c{k[0], k[1], k[2], k[3], k[4], k[5], k[6], k[7]};
  require_usable(list, BrownConradyLens::problem_of(c));
  return BrownConradyLens(c);
}

inline BivariateLens read_bivariate(const JsonNode& node) {
  BivariateCoefficients c;
  read_fixed(node.at("x"), c.x);
  read_fixed(node.at("y"), c.y);
  c.limit = number_or(node, "limit", c.limit, 1e-6, largest_tangent);
  require_usable(node, BivariateLens::problem_of(c));
  return BivariateLens(c);
}

/// "direction": "seen_to_panel" turns the model round.
template <LensModel M>
[[nodiscard]] Lens::Model directed(const JsonNode& node, M model) {
  const std::optional<JsonNode> direction = node.find("direction");
  if (!direction || direction->choice({"panel_to_seen", "seen_to_panel"}) == 0) return model;
  return ReversedLens<M>(std::move(model));
}

/// The lens of samples that stand at `node` (sample i at node's i-th element).
inline PointMeshLens point_mesh_lens(std::vector<PointMeshSample> samples, const JsonNode& node) {
  const PointMeshResult result = make_point_mesh(std::move(samples));
  if (result.ok()) return PointMeshLens(result.mesh);
  if (result.problem == PointMeshProblem::duplicate_panel_point) {
    node.elements(0, most_mesh_samples)[result.sample].fail(
        std::string(describe(result.problem)),
        "another point than that of sample " + std::to_string(result.other_sample));
  }
  node.fail(std::string(describe(result.problem)), "samples whose triangles keep their orientation");
}

inline PointMeshLens read_point_mesh(const JsonNode& node) {
  const JsonNode list = node.at("samples");
  std::vector<PointMeshSample> samples;
  for (const JsonNode& sample : list.elements(3, most_mesh_samples)) {
    const std::vector<JsonNode> e = sample.elements(4, 4);
    const auto number = [&](std::size_t i) { return e[i].number(-1e6, 1e6); };
    samples.push_back({Vector2(number(0), number(1)), Vector2(number(2), number(3))});
  }
  return point_mesh_lens(std::move(samples), list);
}

inline Lens::Model read_lens_model(const JsonNode& node) {
  switch (node.at("model").choice({"none", "radial", "polynomial", "power_series", "vive", "catmull_rom",
                                   "kannala_brandt", "brown_conrady", "bivariate", "point_mesh"})) {
    case 0:
      node.allow_only({"model"});
      return NoLens{};
    case 1:
      allow_lens_keys(node, {"k"});
      return RadialLens{node.at("k").number(-largest_coefficient, largest_coefficient)};
    case 2:
      allow_lens_keys(node, {"k0", "coefficients", "direction"});
      return directed(node, read_polynomial(node));
    case 3:
      allow_lens_keys(node, {"coefficients", "direction"});
      return directed(node, read_power_series(node));
    case 4:
      allow_lens_keys(node, {"coefficients"});
      return read_vive(node);
    case 5:
      allow_lens_keys(node, {"knots", "r_max", "chroma"});
      return read_catmull_rom(node);
    case 6:
      allow_lens_keys(node, {"coefficients"});
      return read_kannala_brandt(node);
    case 7:
      allow_lens_keys(node, {"coefficients", "direction"});
      return directed(node, read_brown_conrady(node));
    case 8:
      allow_lens_keys(node, {"x", "y", "limit"});
      return read_bivariate(node);
    default:
      allow_lens_keys(node, {"samples"});
      return read_point_mesh(node);
  }
}

/// r_norm, or scale (two components, negative to mirror) for a lens that is not as wide as high.
inline LensPlacement read_placement(const JsonNode& node) {
  LensPlacement place;
  if (const auto centre = node.find("centre")) place.centre = read_vector2(*centre, largest_tangent);
  const std::optional<JsonNode> scale = node.find("scale");
  if (!scale) return placed_at(node.at("r_norm").number(1e-6, largest_tangent), place.centre);
  if (node.find("r_norm")) scale->fail("given beside r_norm", "either r_norm or scale");
  place.scale = read_vector2(*scale, largest_tangent);
  if (!(place.scale.cwiseAbs().minCoeff() >= 1e-6)) scale->fail("too small a scale", "at least 1e-6 in size");
  return place;
}

/// Models whose distortion depends on the radius alone.
[[nodiscard]] inline bool is_rotational(const Lens::Model& model) {
  return !std::holds_alternative<BivariateLens>(model) && !std::holds_alternative<BrownConradyLens>(model) &&
         !std::holds_alternative<ReversedLens<BrownConradyLens>>(model) &&
         !std::holds_alternative<PointMeshLens>(model);
}

/// Without k_pd: the best cubic of a rotational lens, none for the others.
inline Lens read_lens(const JsonNode& node) {
  const Lens::Model model = read_lens_model(node);
  if (std::holds_alternative<NoLens>(model)) return NoLens{};
  const Lens lens(model, read_placement(node));
  if (const auto k_pd = node.find("k_pd")) return lens.with_k_pd(k_pd->number(-1000.0, 1000.0));
  return is_rotational(model) ? with_best_cubic(lens) : lens;
}

}  // namespace holdfast::io::detail
