// Draws docs/pictures/registration_scene.png and docs/pictures/models.png.
//     g++ -std=c++20 -O1 -DHOLDFAST_HAS_EGL=1 -Iinclude -Ibuild/release/generated/include -I/usr/include/eigen3
//       docs/pictures/registration_pictures.cpp -o /tmp/pictures -lEGL -lpng -ljpeg -lassimp && /tmp/pictures
//       docs/pictures
#include <filesystem>
#include <vector>

#include <holdfast/io/png.hpp>
#include <holdfast/optics/hmd.hpp>
#include <holdfast/rendering/rendering.hpp>
#include <holdfast/scene/scene.hpp>

using namespace holdfast;
using namespace holdfast::rendering;

namespace {

constexpr PixelSize tile{480, 270};
constexpr int gap = 6;

/// Pictures in reading order, `columns` a row, on a light ground.
io::Image tiled(const std::vector<io::Image>& pictures, int columns) {
  const int rows = (static_cast<int>(pictures.size()) + columns - 1) / columns;
  io::Image sheet(columns * (tile.width + gap) - gap, rows * (tile.height + gap) - gap, {255, 255, 255, 255});
  for (int i = 0; i < static_cast<int>(pictures.size()); ++i) {
    const int left = (i % columns) * (tile.width + gap);
    const int bottom = (rows - 1 - i / columns) * (tile.height + gap);
    for (int y = 0; y < tile.height; ++y)
      for (int x = 0; x < tile.width; ++x)
        sheet.set(left + x, bottom + y, pictures[static_cast<std::size_t>(i)].at(x, y));
  }
  return sheet;
}

}  // namespace

int main(int, char** arguments) {
  const std::filesystem::path folder = arguments[1];
  const auto context = make_context();
  const EyeModel eye = default_hmd(tile).left;
  RenderTarget target(*context, tile.width, tile.height, 4);
  RegistrationScenePainter painter(*context, default_registration_scene());

  const auto draw = [&](const Rigid& X_WE, const SceneStyle& style, scene::ModelPainter* model, const Vqs& T_WM) {
    const View view{.eye = &eye, .X_WE = X_WE};
    target.clear(style.background);
    painter.draw_solid(view, style);
    if (model != nullptr) model->draw(view, T_WM, style.model_toning);
    painter.draw_flat(view, style);
    return target.read_rgba();
  };

  // Yaw of 2 Hz and 3 degrees, seen 60 ms late: at its fastest the virtual world is 2.2 degrees behind.
  const Rigid X_WE = eye.X_HE;
  const Rigid X_WE_late = Rigid::rotation(so3::exp<double>(Vector3(0.0, degrees(2.2).radians(), 0.0))) * eye.X_HE;
  const io::Image real = draw(X_WE, real_style(), nullptr, {});
  const io::Image late = draw(X_WE_late, virtual_style(), nullptr, {});
  io::write_png(folder / "registration_scene.png",
                tiled({real, late, overlay(real, draw(X_WE, virtual_style(), nullptr, {})), overlay(real, late)}, 2));

  std::vector<io::Image> pictures;
  for (const char* file : {"glTF2/2CylinderEngine-glTF-Binary/2CylinderEngine.glb", "OBJ/spider.obj",
                           "Collada/duck.dae", "glTF2/BoxTextured-glTF-Binary/BoxTextured.glb"}) {
    const scene::Model model = scene::load_model(std::filesystem::path("/usr/share/assimp/models") / file);
    scene::ModelPainter model_painter(*context, model);
    const Vqs T_WM = scene::default_place(model);
    SceneStyle plain = virtual_style();
    plain.background = {0.05f, 0.055f, 0.065f, 1.0f};
    plain.model_toning = {};
    pictures.push_back(draw(X_WE, plain, &model_painter, T_WM));
  }
  io::write_png(folder / "models.png", tiled(pictures, 2));
}
