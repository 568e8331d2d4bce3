/// Draws the registration scene (registration/scene_fiducials.hpp) as the real world looks or as the headset's virtual
/// one does.
///
/// Real: muted, a wooden frame corner, pale discs on darkness. Virtual: saturated, axes in three colours, coloured
/// discs. Laid over each other (composition.hpp), what is not registered shows as a coloured fringe beside its pale
/// twin. Discs, upright edge and checkerboard have exact edges whatever the target's samples (flat_shape.hpp); the
/// frame corner is solid and takes its smoothness from the target's samples. Draws into the bound target, whose size
/// must be the eye's resolution. Nothing is created per frame.
#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include <holdfast/registration/scene_fiducials.hpp>
#include <holdfast/rendering/flat_shape.hpp>
#include <holdfast/rendering/lit_painter.hpp>
#include <holdfast/rendering/render_target.hpp>

namespace holdfast::rendering {

/// Colours that replace the scene's own, and the parts that are drawn.
struct SceneStyle {
  ClearColour background;
  std::optional<Vector3> disc_colour, corner_colour, edge_colour, board_bright, board_dark;
  Toning corner_toning;
  Toning model_toning;  ///< for a model drawn with the scene
  bool discs = true, corner = true, edge = true, board = true;
};

/// As a camera sees the real things.
[[nodiscard]] inline SceneStyle real_style() {
  SceneStyle style;
  style.background = {0.05f, 0.055f, 0.065f, 1.0f};
  style.disc_colour = Vector3(0.45, 0.45, 0.45);
  style.corner_colour = Vector3(0.75, 0.6, 0.42);
  style.edge_colour = Vector3(0.3, 0.3, 0.3);
  style.board_bright = Vector3(0.42, 0.42, 0.42);
  style.board_dark = Vector3(0.1, 0.1, 0.1);
  style.corner_toning = {.saturation = 0.8f, .tint = Vector3(0.7, 0.7, 0.7)};
  style.model_toning = {.saturation = 0.2f, .tint = Vector3(0.46, 0.41, 0.36)};
  return style;
}

/// As the headset adds the virtual things: colours as the scene has them, black where it shows nothing.
[[nodiscard]] inline SceneStyle virtual_style() {
  SceneStyle style;
  style.edge_colour = Vector3(0.0, 0.55, 0.7);
  style.board_bright = Vector3(0.6, 0.12, 0.55);
  style.board_dark = Vector3(0.12, 0.0, 0.1);
  style.model_toning = {.saturation = 1.2f, .tint = Vector3(0.5, 0.6, 0.64)};
  return style;
}

/// The same with discs alone, white on black: what centroids are measured in.
[[nodiscard]] inline SceneStyle disc_measuring_style() {
  SceneStyle style;
  style.disc_colour = Vector3::Ones();
  style.corner = style.edge = style.board = false;
  return style;
}

[[nodiscard]] inline FlatShape shape_of(const Disc& disc) {
  FlatShape shape;
  shape.kind = FlatShape::Kind::disc;
  shape.origin_W = disc.centre_W;
  const Vector3 away = std::abs(disc.normal_W.y()) < 0.9 ? Vector3(0, 1, 0) : Vector3(1, 0, 0);
  shape.u_axis_W = disc.radius_m * away.cross(disc.normal_W).normalized();
  shape.v_axis_W = disc.radius_m * disc.normal_W.cross(shape.u_axis_W).normalized();
  shape.colour = disc.color;
  return shape;
}

[[nodiscard]] inline FlatShape shape_of(const VerticalEdge& edge) {
  FlatShape shape;
  shape.kind = FlatShape::Kind::rectangle;
  shape.origin_W = edge.bottom_W;
  shape.u_axis_W = edge.across_W;
  shape.v_axis_W = edge.top_W - edge.bottom_W;
  shape.colour = edge.color;
  return shape;
}

[[nodiscard]] inline FlatShape shape_of(const Checkerboard& board) {
  FlatShape shape;
  shape.kind = FlatShape::Kind::board;
  shape.origin_W = board.X_WC.p();
  shape.u_axis_W = board.square_m * (board.X_WC.q() * Vector3(1, 0, 0));
  shape.v_axis_W = board.square_m * (board.X_WC.q() * Vector3(0, 1, 0));
  shape.cells = Vector2(board.columns, board.rows);
  shape.colour = board.bright;
  shape.other_colour = board.dark;
  return shape;
}

class RegistrationScenePainter {
 public:
  RegistrationScenePainter(Context& context, const RegistrationScene& scene)
      : lit_(context), flat_(context), corner_(scene.corner) {
    for (int axis = 0; axis < 3; ++axis) {
      // The first bar fills the joint; the others start at its face, so that no two surfaces coincide.
      const double half = scene.corner.thickness_m / 2.0;
      Vector3 low = Vector3::Constant(-half), high = Vector3::Constant(half);
      low[axis] = axis == 0 ? -half : half;
      high[axis] = scene.corner.length_m;
      bars_.push_back(make_box(context, low, high));
    }
    for (const Disc& disc : scene.discs) shapes_.push_back({Part::disc, shape_of(disc)});
    shapes_.push_back({Part::edge, shape_of(scene.edge)});
    if (scene.board.columns > 0 && scene.board.rows > 0) shapes_.push_back({Part::board, shape_of(scene.board)});
    order_.resize(shapes_.size());
  }

  /// Everything; what else is solid (a model) must have been drawn before.
  void draw(const View& view, const SceneStyle& style) {
    draw_solid(view, style);
    draw_flat(view, style);
  }

  /// The frame corner.
  void draw_solid(const View& view, const SceneStyle& style) {
    if (!style.corner) return;
    lit_.begin(view, style.corner_toning);
    const Matrix4 X_WF = corner_.X_WF.matrix();
    for (std::size_t axis = 0; axis < bars_.size(); ++axis) {
      Material material;
      material.base_colour << style.corner_colour.value_or(corner_.colors[axis]), 1.0;
      lit_.draw(bars_[axis], X_WF, material);
    }
  }

  /// Discs, edge and board, farther ones first; blended over what is there.
  void draw_flat(const View& view, const SceneStyle& style) {
    const Rigid X_EW = view.X_WE.inverse();
    std::size_t count = 0;
    for (std::size_t i = 0; i < shapes_.size(); ++i) {
      if (is_drawn(shapes_[i].part, style)) order_[count++] = {-(X_EW * shapes_[i].shape.centre_W()).z(), i};
    }
    std::sort(order_.begin(), order_.begin() + static_cast<std::ptrdiff_t>(count), [](const Place& a, const Place& b) {
      return a.distance != b.distance ? a.distance > b.distance : a.index < b.index;
    });
    flat_.begin(view);
    for (std::size_t i = 0; i < count; ++i) {
      const Piece& piece = shapes_[order_[i].index];
      FlatShape shape = piece.shape;
      if (piece.part == Part::disc) shape.colour = style.disc_colour.value_or(shape.colour);
      if (piece.part == Part::edge) shape.colour = style.edge_colour.value_or(shape.colour);
      if (piece.part == Part::board) {
        shape.colour = style.board_bright.value_or(shape.colour);
        shape.other_colour = style.board_dark.value_or(shape.other_colour);
      }
      flat_.draw(view, shape);
    }
    flat_.end();
  }

 private:
  enum class Part { disc, edge, board };
  struct Piece {
    Part part;
    FlatShape shape;
  };
  struct Place {
    double distance = 0.0;
    std::size_t index = 0;
  };

  [[nodiscard]] static bool is_drawn(Part part, const SceneStyle& style) {
    return part == Part::disc ? style.discs : part == Part::edge ? style.edge : style.board;
  }

  LitPainter lit_;
  FlatShapePainter flat_;
  FrameCorner corner_;
  std::vector<Mesh> bars_;
  std::vector<Piece> shapes_;
  std::vector<Place> order_;
};

}  // namespace holdfast::rendering
