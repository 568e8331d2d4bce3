// Draws the panels of docs/pictures/deflection_shift.png, deflection_depth.png and deflection_rolling.png; labelled.py
// puts them side by side with their words:
//     g++ -std=c++20 -O1 -DHOLDFAST_HAS_EGL=1 -Iinclude -Ibuild/release/generated/include -I/usr/include/eigen3
//       docs/pictures/deflection_pictures.cpp -o /tmp/deflection_pictures -lEGL -lpng -ljpeg -lassimp
//     mkdir -p /tmp/panels && /tmp/deflection_pictures /tmp/panels && docs/pictures/labelled.sh /tmp/panels docs/pictures
// Grey is real, coloured is virtual, as the eye sees both through an exactly corrected lens.
#include <filesystem>

#include <holdfast/deflection/deflection.hpp>
#include <holdfast/io/png.hpp>
#include <holdfast/optics/hmd.hpp>
#include <holdfast/optics/overfill.hpp>
#include <holdfast/rendering/rendering.hpp>

using namespace holdfast;
using namespace holdfast::rendering;

namespace {

constexpr PixelSize tile{640, 360};

struct Studio {
  explicit Studio(const EyeModel& own) : eye(own) {}

  EyeModel eye;
  std::unique_ptr<Context> context = make_context();
  RegistrationScenePainter painter{*context, scene()};
  LateWarpPass late_warp{*context};
  DepthWarpPass depth_warp{*context};

  /// The registration scene with the near discs larger, so that what they hide is seen.
  static RegistrationScene scene() {
    RegistrationScene scene = default_registration_scene();
    for (Disc& disc : scene.discs) {
      if (disc.nominal_distance_m < 0.9) disc.radius_m *= 2.5;
    }
    return scene;
  }

  void draw(RenderTarget& target, const EyeModel& drawing, const Rigid& X_WE, const SceneStyle& style,
            const PixelRectangle& part = {}) {
    const View view{.eye = &drawing, .X_WE = X_WE, .part = part};
    painter.draw_solid(view, style);
    painter.draw_flat(view, style);
  }

  /// The room; X_WE_at takes seconds from the middle of scan-out.
  template <typename Pose>
  io::Image real(const DisplayTiming& timing, const Pose& X_WE_at) {
    RenderTarget target(*context, tile.width, tile.height, 4);
    target.clear(real_style().background);
    if (timing.scan_out == ScanOut::global) {
      draw(target, eye, X_WE_at(0.0), real_style());
      return target.read_rgba();
    }
    draw_rolling(target, timing.scan_direction, tile.height, [&](const Band& band) {
      const Vector2 panel = *drawn_pixel(eye, LensMode::exact, band.middle_px);
      const double line = line_fraction_of_pixel(timing.scan_direction, panel, Vector2(tile.width, tile.height));
      draw(target, eye, X_WE_at(line_seconds_from_middle(timing, line)), real_style(), band.part);
    });
    return target.read_rgba();
  }

  /// A picture drawn for X_WS, shown as `how` deflects it to the late poses; alpha is the mask.
  io::Image shown(const DeflectionSettings& how, const Rigid& X_WS, const LatePoses& late, const DisplayTiming& timing) {
    const FieldTangents wider = overfilled(eye.tangents, {degrees(10.0), degrees(10.0), degrees(8.0)});
    const RenderedView view{X_WS, wider, overfilled_size(eye, wider), HostTime{}};
    EyeModel drawing;
    drawing.tangents = view.tangents;
    drawing.resolution = view.size;
    RenderTarget source(*context, view.size.width, view.size.height, 4), seen(*context, tile.width, tile.height);
    source.clear(virtual_style().background);
    draw(source, drawing, X_WS, virtual_style());
    const RenderedPicture<RenderTarget*> picture(view, &source);
    const DeflectionResult deflection = deflect(how, picture, late);
    const WarpMesh mesh(*context, seen_mesh(eye, LensMode::exact));
    if (how.kind == DeflectionKind::depth) {
      DepthSurfaceTexture surface(*context, view.size);
      surface.update(picture, View{}.clip);
      depth_warp.draw(picture, surface, mesh, deflection.X_SE, timing, seen);
    } else {
      late_warp.draw(picture, mesh, deflection.H_SE, timing, seen);
    }
    return seen.read_rgba();
  }
};

io::Image opaque(io::Image image) {
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) image.rgba[i] = 255;
  return image;
}

/// The mask over the picture: what was hidden when it was drawn in red, what it has not at all in blue.
io::Image marked(const io::Image& shown, io::Image over) {
  for (std::size_t i = 0; i < shown.rgba.size(); i += 4) {
    const MaskValue value = mask_value(shown.rgba[i + 3]);
    if (value == MaskValue::covered) continue;
    over.rgba[i] = value == MaskValue::disoccluded ? 255 : 40;
    over.rgba[i + 1] = 60;
    over.rgba[i + 2] = value == MaskValue::disoccluded ? 60 : 255;
  }
  return over;
}

Rigid turned(double yaw_deg, double pitch_deg, double roll_deg) {
  return Rigid::rotation(so3::exp<double>(Vector3(degrees(pitch_deg).radians(), degrees(yaw_deg).radians(), 0.0)) *
                         so3::exp<double>(Vector3(0.0, 0.0, degrees(roll_deg).radians())));
}

}  // namespace

int main(int, char** arguments) {
  const std::filesystem::path folder = arguments[1];
  EyeModel eye = default_hmd(tile).left;
  eye.X_HE = Rigid();
  eye.tangents = {-0.8, 0.8, -0.45, 0.45};
  Studio studio(eye);
  const DisplayTiming global;
  const auto save = [&](const char* name, const io::Image& image) { io::write_png(folder / name, image); };

  // A head that turned by 6 degrees to the side, 2 up and 4 about its line of sight since the picture was drawn.
  {
    const Rigid X_WS, X_WE = turned(6.0, 2.0, 4.0);
    const io::Image real = studio.real(global, [&](double) { return X_WE; });
    for (const DeflectionKind kind :
         {DeflectionKind::none, DeflectionKind::shift, DeflectionKind::shift_roll, DeflectionKind::rotation}) {
      const io::Image shown = studio.shown({.kind = kind}, X_WS, LatePoses::at_once(X_WE), global);
      save(("turn_" + std::string(name_of(kind)) + ".png").c_str(), overlay(real, opaque(shown)));
    }
  }
  // A head that stepped 4 cm aside and turned a little.
  {
    const Rigid X_WS, X_WE = Rigid::translation(Vector3(0.04, 0.01, 0.0)) * turned(3.0, 0.0, 0.0);
    const io::Image real = studio.real(global, [&](double) { return X_WE; });
    for (const DeflectionKind kind :
         {DeflectionKind::none, DeflectionKind::rotation, DeflectionKind::plane, DeflectionKind::depth}) {
      const io::Image shown =
          studio.shown({.kind = kind, .plane_distance_m = 1.0}, X_WS, LatePoses::at_once(X_WE), global);
      save(("step_" + std::string(name_of(kind)) + ".png").c_str(), overlay(real, opaque(shown)));
      if (kind == DeflectionKind::depth) save("step_mask.png", marked(shown, overlay(real, opaque(shown))));
    }
  }
  // A head that turns at 300 degrees a second, on a display that takes 11.1 ms from the top line to the bottom one.
  {
    DisplayTiming rolling;
    rolling.scan_out = ScanOut::rolling;
    rolling.scan_duration = std::chrono::microseconds(11100);
    const auto X_WE_at = [](double seconds) { return turned(300.0 * seconds, 0.0, 0.0); };
    const double half = 0.5 * to_seconds(rolling.scan_duration);
    const LatePoses late{X_WE_at(-half), X_WE_at(half)};
    const io::Image real = studio.real(rolling, X_WE_at);
    for (const bool per_scanline : {false, true}) {
      const io::Image shown = studio.shown({.kind = DeflectionKind::rotation, .per_scanline = per_scanline},
                                           turned(-4.0, 0.0, 0.0), late, rolling);
      save(per_scanline ? "rolling_by_line.png" : "rolling_at_once.png", overlay(real, opaque(shown)));
    }
  }
}
