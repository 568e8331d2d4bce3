/// From HmdModel to an OSVR display descriptor, as far as OSVR can say it; the file functions are in osvr.hpp.
///
/// Written: fields, canting (as overlap_percent), centres of projection, upside-down panels, polynomial lenses and
/// point meshes. OSVR gives both eyes one width and height of field, turns them symmetrically about the vertical and
/// gives no other lens: a headset that is not so is refused with the part that is not. What OSVR leaves to others (IPD,
/// refresh and scan-out, image distance, eye relief, the paper's cubic) is left out and listed.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include <holdfast/io/input_error.hpp>
#include <holdfast/io/lens_writer.hpp>
#include <holdfast/io/osvr_distortion.hpp>
#include <holdfast/io/osvr_types.hpp>
#include <holdfast/optics/hmd.hpp>

namespace holdfast::io {

struct OsvrText {
  std::string text;
  std::vector<std::string> left_out;  ///< what the descriptor cannot say
};

namespace detail {

[[noreturn]] inline void osvr_cannot(const std::string& what, const std::string& expected) {
  throw InputError({.problem = "an OSVR descriptor cannot express " + what, .expected = expected});
}

/// Rounded to 15 significant digits, so that a number that came from a decimal becomes that decimal again.
[[nodiscard]] inline double tidy(double value) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.15g", value);
  return std::strtod(digits, nullptr);
}

inline bool is_near(double a, double b) {
  return std::abs(a - b) <= 1e-9 * (1.0 + std::abs(a) + std::abs(b));
}

/// A rotationally symmetric polynomial a0 + a1 r + a2 r^2 + ... in its model's unit, or nothing.
struct OsvrPolynomialOf {
  std::optional<std::vector<double>> operator()(const NoLens&) const { return std::vector<double>{0.0, 1.0}; }
  std::optional<std::vector<double>> operator()(const RadialLens& l) const {
    return std::vector<double>{0.0, 1.0, 0.0, l.k};
  }
  std::optional<std::vector<double>> operator()(const PolynomialLens& l) const {
    std::vector<double> a{0.0, l.k0()};
    for (const double k : l.coefficients()) a.insert(a.end(), {0.0, k});
    return a;
  }
  std::optional<std::vector<double>> operator()(const PowerSeriesLens& l) const {
    std::vector<double> a{0.0};
    a.insert(a.end(), l.coefficients().begin(), l.coefficients().end());
    return a;
  }
  template <typename Other>
  std::optional<std::vector<double>> operator()(const Other&) const {
    return std::nullopt;
  }
};

class OsvrWriter {
 public:
  explicit OsvrWriter(const HmdModel& hmd) : hmd_(hmd) {}

  [[nodiscard]] OsvrText write(OsvrDisplayMode mode) {
    check_eyes();
    OrderedJson hmd;
    hmd["device"] = {{"vendor", ""}, {"model", hmd_.name}, {"Note", hmd_.source}};
    hmd["field_of_view"] = field();
    hmd["resolutions"] = OrderedJson::array({resolution(mode)});
    hmd["distortion"] = distortion();
    hmd["rendering"] = {{"left_roll", 0}, {"right_roll", 0}};
    hmd["eyes"] = OrderedJson::array({eye(hmd_.left), eye(hmd_.right)});
    list_what_is_left_out();
    const OrderedJson root{{"meta", {{"schemaVersion", 1}}}, {"hmd", std::move(hmd)}};
    return {pretty(root), std::move(left_out_)};
  }

 private:
  [[nodiscard]] static Vector2 size(const EyeModel& e) {
    return {e.tangents.right - e.tangents.left, e.tangents.up - e.tangents.down};
  }
  [[nodiscard]] static Angle outward(const EyeModel& e) {
    const Quaternion& q = e.X_HE.q();
    return radians((e.side == EyeSide::left ? 2.0 : -2.0) * std::atan2(q.y(), q.w()));
  }

  void check_eyes() const {
    const Vector2 a = size(hmd_.left), b = size(hmd_.right);
    if (!is_near(a.x(), b.x()) || !is_near(a.y(), b.y())) {
      osvr_cannot("eyes with fields of different size", "the same width and height in tangents for both");
    }
    if (!(a.x() > 0.0 && a.y() > 0.0)) osvr_cannot("a mirrored field", "left < right and down < up");
    if (hmd_.left.resolution != hmd_.right.resolution) osvr_cannot("eyes with different resolutions", "one for both");
    for (const EyeModel* e : {&hmd_.left, &hmd_.right}) {
      const Quaternion& q = e->X_HE.q();
      const Vector3 expected((e->side == EyeSide::left ? -0.5 : 0.5) * hmd_.ipd_m, 0.0, 0.0);
      if (!is_near(q.x(), 0.0) || !is_near(q.z(), 0.0))
        osvr_cannot("an eye that is tilted or rolled", "turned sideways at most");
      if ((e->X_HE.p() - expected).norm() > 1e-9)
        osvr_cannot("an eye beside its place", "eyes at half the IPD from the middle");
    }
    if (!is_near(outward(hmd_.left).radians(), outward(hmd_.right).radians())) {
      osvr_cannot("eyes turned by different angles", "a symmetric headset");
    }
  }

  [[nodiscard]] OrderedJson field() const {
    const Vector2 s = size(hmd_.left);
    const double horizontal = 2.0 * std::atan(s.x() / 2.0);
    const double vertical = 2.0 * std::atan(s.y() / 2.0);
    const double overlap = 1.0 - 2.0 * outward(hmd_.left).radians() / horizontal;
    if (!(overlap >= -1e-12 && overlap <= 1.0 + 1e-12)) {
      osvr_cannot("converging eyes, or eyes without overlap", "eyes turned outward by half the field at most");
    }
    return {{"monocular_horizontal", tidy(horizontal * 180.0 / std::numbers::pi)},
            {"monocular_vertical", tidy(vertical * 180.0 / std::numbers::pi)},
            {"overlap_percent", std::clamp(tidy(100.0 * overlap), 0.0, 100.0)},
            {"pitch_tilt", tidy(-std::atan(lens_height()) * 180.0 / std::numbers::pi)}};
  }

  [[nodiscard]] OrderedJson resolution(OsvrDisplayMode mode) const {
    const PixelSize eye = hmd_.left.resolution;
    const int across = mode == OsvrDisplayMode::side_by_side ? 2 : 1;
    const int up = mode == OsvrDisplayMode::one_above_the_other ? 2 : 1;
    constexpr std::array names{"horz_side_by_side", "vert_side_by_side", "full_screen"};
    return {{"width", eye.width * across},
            {"height", eye.height * up},
            {"video_inputs", mode == OsvrDisplayMode::full_screen ? 2 : 1},
            {"display_mode", names[static_cast<std::size_t>(mode)]},
            {"swap_eyes", 0}};
  }

  [[nodiscard]] OrderedJson eye(const EyeModel& e) const {
    const Vector2 s = size(e);
    return {{"center_proj_x", tidy(-e.tangents.left / s.x())},
            {"center_proj_y", tidy((lens_height() - e.tangents.down) / s.y())},
            {"rotate_180", e.upside_down ? 1 : 0}};
  }

  [[nodiscard]] bool any_mesh() const {
    for (const EyeModel* e : {&hmd_.left, &hmd_.right}) {
      for (const Color color : {Color::red, Color::green, Color::blue}) {
        if (e->lens_of(color).model_if<PointMeshLens>() != nullptr) return true;
      }
    }
    return false;
  }
  [[nodiscard]] bool is_mono() const {
    return !hmd_.left.lens_red && !hmd_.left.lens_blue && !hmd_.right.lens_red && !hmd_.right.lens_blue;
  }

  [[nodiscard]] OrderedJson distortion() const {
    if (!any_mesh()) return polynomials();
    if (is_mono()) return {{"type", "mono_point_samples"}, {"mono_point_samples", meshes(Color::green)}};
    return {{"type", "rgb_point_samples"},
            {"red_point_samples", meshes(Color::red)},
            {"green_point_samples", meshes(Color::green)},
            {"blue_point_samples", meshes(Color::blue)}};
  }

  [[nodiscard]] OrderedJson meshes(Color color) const {
    return OrderedJson::array({mesh(hmd_.left, color), mesh(hmd_.right, color)});
  }

  [[nodiscard]] static OrderedJson mesh(const EyeModel& e, Color color) {
    const Lens& lens = e.lens_of(color);
    const PointMeshLens* model = lens.model_if<PointMeshLens>();
    if (model == nullptr) osvr_cannot("a point mesh beside a lens of another kind", "point meshes for all, or none");
    const LensPlacement& place = lens.placement();
    const Vector2 low(e.tangents.left, e.tangents.down);
    const auto fraction = [&](const Vector2& u) {
      const Vector2 f = (place.centre + place.scale.cwiseProduct(u) - low).cwiseQuotient(size(e));
      return OrderedJson::array({tidy(f.x()), tidy(f.y())});
    };
    OrderedJson samples = OrderedJson::array();
    for (const PointMeshSample& s : model->mesh().samples) {
      samples.push_back(OrderedJson::array({fraction(s.panel), fraction(s.seen)}));
    }
    return samples;
  }

  [[nodiscard]] OrderedJson polynomials() const {
    const Vector2 unit = unit_of_distance();
    OrderedJson json{{"type", "rgb_symmetric_polynomials"},
                     {"distance_scale_x", tidy(size(hmd_.left).x() / unit.x())},
                     {"distance_scale_y", tidy(size(hmd_.left).y() / unit.y())}};
    for (const Color color : {Color::red, Color::green, Color::blue}) {
      const std::vector<double> a = polynomial(hmd_.left.lens_of(color), unit);
      const std::vector<double> b = polynomial(hmd_.right.lens_of(color), unit);
      bool is_same = a.size() == b.size();
      for (std::size_t i = 0; is_same && i < a.size(); ++i) is_same = is_near(a[i], b[i]);
      if (!is_same) osvr_cannot("different polynomials for the two eyes", "the same lens before both");
      json["polynomial_coeffs_" + std::string(osvr_colours[static_cast<std::size_t>(color)])] = a;
    }
    return json;
  }

  /// The height of polynomial lenses' centre, which pitch_tilt expresses; meshes need no centre.
  [[nodiscard]] double lens_height() const {
    for (const Color color : {Color::green, Color::red, Color::blue}) {
      const Lens& lens = hmd_.left.lens_of(color);
      const bool has_centre = lens.model_if<NoLens>() == nullptr && lens.model_if<PointMeshLens>() == nullptr;
      if (has_centre) return lens.centre().y();
    }
    return 0.0;
  }

  /// Tangents per unit of the polynomials: the scale of the first lens that has one.
  [[nodiscard]] Vector2 unit_of_distance() const {
    for (const Color color : {Color::green, Color::red, Color::blue}) {
      const Lens& lens = hmd_.left.lens_of(color);
      if (lens.model_if<NoLens>() == nullptr) return lens.placement().scale.cwiseAbs();
    }
    return size(hmd_.left);
  }

  [[nodiscard]] std::vector<double> polynomial(const Lens& lens, const Vector2& unit) const {
    std::optional<std::vector<double>> a = std::visit(OsvrPolynomialOf{}, lens.model());
    if (!a) osvr_cannot("a lens that is no polynomial of the radius", "a radial polynomial or a point mesh");
    if (lens.model_if<NoLens>() != nullptr) return *a;
    if (!is_near(lens.centre().x(), 0.0) || !is_near(lens.centre().y(), lens_height())) {
      osvr_cannot("a lens beside the centre of projection", "lenses centred straight ahead, all equally high");
    }
    const Vector2 ratio = unit.cwiseQuotient(lens.placement().scale.cwiseAbs());
    if (!is_near(ratio.x(), ratio.y())) osvr_cannot("lenses stretched differently", "one shape for all");
    double power = 1.0;  // a_i counts in the i-th power of the unit, seen in the first
    for (std::size_t i = 1; i < a->size(); ++i) {
      (*a)[i] *= power;
      power *= ratio.x();
    }
    return *a;
  }

  void list_what_is_left_out() {
    left_out_.push_back("the IPD of " + brief(tidy(hmd_.ipd_m * 1000.0)) + " mm");
    left_out_.push_back("the display's timing, " + brief(hmd_.timing.refresh_hz) + " Hz");
    for (const EyeModel* e : {&hmd_.left, &hmd_.right}) {
      const std::string side = e->side == EyeSide::left ? "the left" : "the right";
      if (!std::isinf(e->image_distance_m)) left_out_.push_back(side + " image's distance");
      if (e->eye_relief_m != 0.0) left_out_.push_back(side + " eye's relief");
      if (!e->lenses_at_relief.empty()) left_out_.push_back(side + " eye's lenses at other reliefs");
      if (e->lens.k_pd() != 0.0) left_out_.push_back(side + " lens's cubic k_pd");
    }
  }

  const HmdModel& hmd_;
  std::vector<std::string> left_out_;
};

}  // namespace detail

/// The descriptor's text, and what it leaves out. Throws InputError naming the part that OSVR cannot express.
[[nodiscard]] inline OsvrText osvr_json(const HmdModel& hmd, OsvrDisplayMode mode = OsvrDisplayMode::side_by_side) {
  return detail::OsvrWriter(hmd).write(mode);
}

}  // namespace holdfast::io
