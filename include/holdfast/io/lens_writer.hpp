/// The lenses of a headset descriptor: from Lens to JSON, so that lens_reader.hpp gives back every number bit by bit.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <nlohmann/json.hpp>

#include <holdfast/optics/lens.hpp>

namespace holdfast::io::detail {

using OrderedJson = nlohmann::ordered_json;

struct LensModelWriter {
  OrderedJson operator()(const NoLens&) const { return {{"model", "none"}}; }
  OrderedJson operator()(const RadialLens& l) const { return {{"model", "radial"}, {"k", l.k}}; }
  OrderedJson operator()(const PolynomialLens& l) const {
    return {{"model", "polynomial"}, {"k0", l.k0()}, {"coefficients", list(l.coefficients())}};
  }
  OrderedJson operator()(const PowerSeriesLens& l) const {
    return {{"model", "power_series"}, {"coefficients", list(l.coefficients())}};
  }
  OrderedJson operator()(const ViveLens& l) const {
    const ViveCoefficients& c = l.coefficients();
    return {{"model", "vive"}, {"coefficients", {c.k1, c.k2, c.k3, c.k4}}};
  }
  OrderedJson operator()(const CatmullRomLens& l) const {
    const CatmullRomCoefficients& c = l.coefficients();
    return {{"model", "catmull_rom"}, {"knots", list(c.knots)}, {"r_max", c.r_max}, {"chroma", list(c.chroma)}};
  }
  OrderedJson operator()(const KannalaBrandtLens& l) const {
    return {{"model", "kannala_brandt"}, {"coefficients", list(l.coefficients())}};
  }
  /// OpenCV's order: k1, k2, p1, p2, k3, k4, k5, k6.
  OrderedJson operator()(const BrownConradyLens& l) const {
    const BrownConradyCoefficients& c = l.coefficients();
    return {{"model", "brown_conrady"}, {"coefficients", {c.k1, c.k2, c.p1, c.p2, c.k3, c.k4, c.k5, c.k6}}};
  }
  OrderedJson operator()(const BivariateLens& l) const {
    const BivariateCoefficients& c = l.coefficients();
    return {{"model", "bivariate"}, {"x", list(c.x)}, {"y", list(c.y)}, {"limit", c.limit}};
  }
  /// A formula that goes from the seen point to the panel.
  template <LensModel M>
  OrderedJson operator()(const ReversedLens<M>& l) const {
    OrderedJson json = (*this)(l.model());
    json["direction"] = "seen_to_panel";
    return json;
  }
  OrderedJson operator()(const PointMeshLens& l) const {
    OrderedJson samples = OrderedJson::array();
    for (const PointMeshSample& s : l.mesh().samples) {
      samples.push_back({s.panel.x(), s.panel.y(), s.seen.x(), s.seen.y()});
    }
    return {{"model", "point_mesh"}, {"samples", std::move(samples)}};
  }

 private:
  [[nodiscard]] static std::vector<double> list(std::span<const double> k) { return {k.begin(), k.end()}; }
};

inline OrderedJson lens_json(const Lens& lens) {
  OrderedJson json = std::visit(LensModelWriter{}, lens.model());
  if (lens.model_if<NoLens>()) return json;
  const LensPlacement& place = lens.placement();
  if (place.scale.x() == place.scale.y() && place.scale.x() > 0.0) {
    json["r_norm"] = place.scale.x();
  } else {
    json["scale"] = {place.scale.x(), place.scale.y()};
  }
  json["centre"] = {place.centre.x(), place.centre.y()};
  json["k_pd"] = lens.k_pd();
  return json;
}

/// Plain values, arrays of them, and up to four such arrays together.
[[nodiscard]] inline bool fits_one_line(const OrderedJson& json) {
  if (json.is_primitive()) return true;
  const auto is_plain = [](const OrderedJson& e) { return e.is_primitive(); };
  if (!json.is_array()) return false;
  return std::all_of(json.begin(), json.end(), is_plain) ||
         (json.size() <= 4 && std::all_of(json.begin(), json.end(), fits_one_line));
}

/// JSON with two spaces a level, but short arrays on one line. Text that is not UTF-8 gets replacement characters: a
/// name must not keep a headset from being written.
inline void append_pretty(std::string& text, const OrderedJson& json, std::size_t depth) {
  const auto plain_text = [](const OrderedJson& e) {
    return e.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
  };
  if (json.is_primitive() || json.empty()) {
    text += plain_text(json);
    return;
  }
  const bool one_line = fits_one_line(json);
  const std::string line = "\n" + std::string(2 * depth + 2, ' ');
  text += json.is_array() ? "[" : "{";
  bool first = true;
  for (const auto& [key, value] : json.items()) {
    if (!first) text += one_line ? ", " : ",";
    if (!one_line) text += line;
    if (json.is_object()) text += plain_text(OrderedJson(key)) + ": ";
    append_pretty(text, value, depth + 1);
    first = false;
  }
  if (!one_line) text += line.substr(0, line.size() - 2);
  text += json.is_array() ? "]" : "}";
}

[[nodiscard]] inline std::string pretty(const OrderedJson& json) {
  std::string text;
  append_pretty(text, json, 0);
  return text + "\n";
}

}  // namespace holdfast::io::detail
