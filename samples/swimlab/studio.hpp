/// Draws the experiment's pictures off screen: the registration scene, and a model if wanted, as an eye sees it.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>

#include <holdfast/io/image.hpp>
#include <holdfast/registration/experiment_types.hpp>
#include <holdfast/rendering/depth_warp_pass.hpp>
#include <holdfast/rendering/late_warp_pass.hpp>
#include <holdfast/rendering/make_context.hpp>
#include <holdfast/rendering/registration_scene.hpp>
#include <holdfast/rendering/render_target.hpp>
#include <holdfast/scene/model_painter.hpp>
#include <holdfast/timing/display_timing.hpp>

namespace swimlab {

/// Samples a pixel: flat shapes have exact edges with one; the frame corner and models want the most there is.
enum class Smooth { no, yes };

class Studio {
 public:
  /// `model` empty: none. Throws RenderingError without OpenGL, io::InputError for a model that cannot be read.
  Studio(std::optional<holdfast::rendering::Backend> backend, const holdfast::RegistrationScene& scene,
         const std::filesystem::path& model);

  [[nodiscard]] const holdfast::rendering::ContextInfo& info() const { return context_->info(); }
  [[nodiscard]] const std::string& model_name() const { return model_name_; }

  /// What the headset shows the eye: drawn and deflected as `picture` says, seen through the lens as the application
  /// corrects it. The result's alpha is a mask: 255 what the drawing had, about half for what a depth warp revealed (a
  /// guess), 0 where there is no pixel.
  void draw_virtual(const holdfast::ShownPicture& picture, const holdfast::EyeModel& eye, holdfast::LensMode lens,
                    const holdfast::DisplayTiming& timing, const holdfast::rendering::SceneStyle& style, Smooth smooth,
                    holdfast::io::Image& result);

  /// The world: under a rolling scan-out line by line (in bands of about 8 lines, and seen through a lens in pieces of
  /// them) as it is when the line is lit. `X_WE_at`
  /// takes seconds from the middle of scan-out.
  void draw_real(const holdfast::EyeModel& eye, holdfast::LensMode lens, const holdfast::DisplayTiming& timing,
                 const std::function<holdfast::Rigid(double)>& X_WE_at, const holdfast::rendering::SceneStyle& style,
                 Smooth smooth, holdfast::io::Image& result, int bands = 90);

  /// Time spent in drawing and reading back since the start, and the number of pictures.
  [[nodiscard]] double draw_readback_ms() const { return draw_readback_ms_; }
  [[nodiscard]] std::size_t pictures() const { return pictures_; }
  /// Time spent in making what is needed once per eye and lens: targets and meshes.
  [[nodiscard]] double setup_ms() const { return setup_ms_; }

 private:
  void draw_warped(const holdfast::ShownPicture& picture, const holdfast::EyeModel& eye, holdfast::LensMode lens,
                   const holdfast::DisplayTiming& timing, const holdfast::rendering::SceneStyle& style,
                   holdfast::rendering::RenderTarget& source, holdfast::io::Image& result);
  void paint(const holdfast::rendering::View& view, const holdfast::rendering::SceneStyle& style);
  holdfast::rendering::RenderTarget& target_of(holdfast::PixelSize size, int samples, bool is_result = false);
  holdfast::rendering::WarpMesh& mesh_of(const holdfast::EyeModel& eye, holdfast::LensMode lens);
  holdfast::rendering::DepthSurfaceTexture& surface_of(holdfast::PixelSize size);

  std::unique_ptr<holdfast::rendering::Context> context_;
  holdfast::rendering::RegistrationScenePainter scene_;
  holdfast::rendering::LateWarpPass late_warp_;
  holdfast::rendering::DepthWarpPass depth_warp_;
  std::optional<holdfast::scene::ModelPainter> model_;
  holdfast::Vqs T_WM_;
  std::string model_name_;
  std::map<std::tuple<int, int, int, bool>, std::unique_ptr<holdfast::rendering::RenderTarget>> targets_;
  using EyeKey = std::tuple<holdfast::EyeSide, holdfast::LensMode, int, int, std::array<double, 4>>;
  std::map<EyeKey, holdfast::rendering::WarpMesh> meshes_;
  std::map<std::pair<int, int>, holdfast::rendering::DepthSurfaceTexture> surfaces_;
  double draw_readback_ms_ = 0.0, setup_ms_ = 0.0;
  std::size_t pictures_ = 0;
};

}  // namespace swimlab
