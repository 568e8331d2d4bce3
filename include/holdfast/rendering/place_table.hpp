/// Where a tangent of the displayed eye is drawn: the inverse of the lens as a table in GPU memory, for DepthMeshPass.
///
/// Per colour, for a grid of ideal tangents t_E over all that the panel shows: the place of the panel that shows it
/// (drawn_tangent), and the place at which to draw it, which is the same for the panel's picture, or where the eye sees
/// it (seen_tangent) for the picture that is seen. Interpolated linearly; with 256 x 256 entries that is right to 0.02
/// px of 1280 for a lens like the Flight Helmet's. Depends on eye and mode alone: make it once. Bad input: a lens that
/// shows nothing on the panel throws RenderingError.
#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <vector>

#include <holdfast/optics/eye.hpp>
#include <holdfast/rendering/gl_object.hpp>

namespace holdfast::rendering {

enum class DrawnPicture {
  panel,  ///< what the panel shows
  seen,   ///< what the eye sees through the lens
};

namespace detail {

/// Box round all ideal tangents that the panel shows in any colour; left > right when it shows none.
[[nodiscard]] inline FieldTangents shown_tangents(const EyeModel& eye, LensMode mode) {
  constexpr int cells = 48;
  constexpr double most = std::numeric_limits<double>::infinity();
  FieldTangents box{most, -most, most, -most};
  for (int i = 0; i <= cells; ++i) {
    for (int j = 0; j <= cells; ++j) {
      const Vector2 pixel(double(i) / cells * eye.resolution.width, double(j) / cells * eye.resolution.height);
      for (const Color color : {Color::red, Color::green, Color::blue}) {
        const auto t = ideal_tangent_at_panel(eye.lens_of(color), mode, tangent_of_pixel(eye, pixel));
        if (!t) continue;
        box = {std::min(box.left, t->x()), std::max(box.right, t->x()), std::min(box.down, t->y()),
               std::max(box.up, t->y())};
      }
    }
  }
  return box;
}

}  // namespace detail

class PlaceTable {
 public:
  PlaceTable(Context& context, const EyeModel& eye, LensMode mode, DrawnPicture drawn = DrawnPicture::panel)
      : resolution_(eye.resolution),
        per_colour_(mode != LensMode::none && (eye.lens_red || eye.lens_blue)),
        texture_(make_texture(context, GL_TEXTURE_2D_ARRAY)) {
    const FieldTangents box = detail::shown_tangents(eye, mode);
    if (!(box.right > box.left) || !(box.up > box.down)) throw RenderingError("the panel shows nothing of the field");
    // A margin of an eighth, so that triangles which reach over the panel's edge have their outer corner.
    const double x = 0.125 * (box.right - box.left), y = 0.125 * (box.up - box.down);
    const Vector2 low(box.left - x, box.down - y), high(box.right + x, box.up + y);
    const Vector2 scale = Vector2::Constant(entries - 1).cwiseQuotient(high - low);
    entry_of_tangent_ = {low.x(), low.y(), scale.x(), scale.y()};

    const GlFunctions& gl = context.gl();
    const int layers = per_colour_ ? 3 : 1;
    gl.TextureStorage3D(id(), 1, GL_RGBA32F, entries, entries, layers);
    gl.TextureParameteri(id(), GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl.TextureParameteri(id(), GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    std::vector<std::array<float, 4>> values(std::size_t{entries} * entries);
    for (int layer = 0; layer < layers; ++layer) {
      const Lens& lens = eye.lens_of(per_colour_ ? static_cast<Color>(layer) : Color::green);
      for (std::size_t i = 0; i < values.size(); ++i) {
        const Vector2 entry(static_cast<double>(i % entries), static_cast<double>(i / entries));
        values[i] = places(eye, lens, mode, drawn, low + entry.cwiseQuotient(scale));
      }
      gl.TextureSubImage3D(id(), 0, 0, 0, layer, entries, entries, 1, GL_RGBA, GL_FLOAT, values.data());
    }
    throw_gl_error(gl, "uploading a table of places");
  }

  [[nodiscard]] GLuint id() const { return texture_.id(); }
  [[nodiscard]] PixelSize resolution() const { return resolution_; }  ///< of the picture that is drawn
  [[nodiscard]] bool is_per_colour() const { return per_colour_; }
  /// Entry = (t_E - (x, y)) .* (z, w).
  [[nodiscard]] const Vector4& entry_of_tangent() const { return entry_of_tangent_; }

 private:
  static constexpr int entries = 256;

  /// Panel and drawn place, 0 to 1; 1e10 when there is none.
  [[nodiscard]] static std::array<float, 4> places(const EyeModel& eye, const Lens& lens, LensMode mode,
                                                   DrawnPicture drawn, const Vector2& t_E) {
    const Vector2 size(eye.resolution.width, eye.resolution.height);
    const auto panel = drawn_tangent(lens, mode, t_E);
    const auto place = drawn == DrawnPicture::panel ? panel : seen_tangent(lens, mode, t_E);
    if (!panel || !place) return {1e10f, 1e10f, 1e10f, 1e10f};
    const Vector2 p = pixel_of_tangent(eye, *panel).cwiseQuotient(size);
    const Vector2 q = pixel_of_tangent(eye, *place).cwiseQuotient(size);
    return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(q.x()), static_cast<float>(q.y())};
  }

  PixelSize resolution_;
  bool per_colour_;
  GlObject texture_;
  Vector4 entry_of_tangent_;
};

}  // namespace holdfast::rendering
