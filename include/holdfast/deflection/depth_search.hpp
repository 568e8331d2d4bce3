/// Depth deflection backward: which point of the source picture does the displayed eye see in a direction?
///
/// The ray of the displayed eye E is followed through the surface of the depth image (DepthSurface) from near to far.
/// With o = p_SE and d = R_SE (t_E, -1), it appears in the source picture at distance 1/w at
///     t_S(w) = t_inf + w (o_xy + o_z t_inf),    t_inf = d_xy / -d_z,
/// a straight (epipolar) line in w. It is walked pixel by pixel, w falling from that of the nearest thing to 0. The
/// first place at which the ray passes from before a surface to behind it, inside a facet or between linked ones, is
/// what E sees. Passing behind a surface over a cut edge is no hit: the ray is then hidden from S until it comes out
/// again, and when it ends hidden, or comes out behind the surface that it has to meet, what E sees there was hidden
/// when the picture was drawn: disoccluded. The answer is then a guess, the farthest surface beside the edges that hid
/// it, a pixel away from the edge. A ray that reaches w = 0 before anything shows what is infinitely far. Steps: at most the pixels on the line,
/// about |p_SE| * pixels per tangent / nearest distance. Nothing is allocated.
/// Sources: Mark, McMillan & Bishop 1997 (post-rendering 3D warping); Amanatides & Woo 1987 (the walk).
/// Bad input: a direction that is not ahead of the source eye has no source, and an empty surface has none at all.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <holdfast/deflection/depth_surface.hpp>
#include <holdfast/deflection/scan_pose.hpp>
#include <holdfast/deflection/source_state.hpp>

namespace holdfast {

/// What a displayed direction shows.
struct DepthSource {
  Vector2 t_S = Vector2::Zero();  ///< where the source picture has it, or a guess (disoccluded, outside)
  double w = 0.0;                 ///< its inverse distance along -Z_S, 1/m; 0: infinitely far
  SourceState state = SourceState::covered;
};

class DepthSearch {
 public:
  /// The surface is not copied: it must live while the search is used.
  DepthSearch(const DepthSurface& surface, const ScanPose& X_SE) : surface_(&surface), X_SE_(X_SE) {}
  DepthSearch(DepthSurface&&, const ScanPose&) = delete;

  [[nodiscard]] const DepthSurface& surface() const { return *surface_; }
  [[nodiscard]] const ScanPose& X_SE() const { return X_SE_; }

  /// What E sees at t_E on the line of fraction s; nothing when that is not ahead of S.
  [[nodiscard]] std::optional<DepthSource> source(const Vector2& t_E, double s) const;

  /// Where E sees, at line fraction s, what the source picture shows at t_S: the inverse of source() where nothing
  /// hides it. Nothing when it is not ahead of E.
  [[nodiscard]] std::optional<Vector2> displayed_tangent(const Vector2& t_S, double s) const {
    if (surface_->is_empty()) return std::nullopt;
    const Vector3 p = seen_from_E(X_SE_.at(s), t_S, surface_->w_at(t_S));
    return tangents_of_point(p);
  }

  /// Direction from E, in E, of the point that S sees at t_S at inverse distance w: w times its position when w > 0.
  [[nodiscard]] static Vector3 seen_from_E(const Rigid& X_SE, const Vector2& t_S, double w) {
    const Vector3 from_E = direction_of_tangents(t_S) - w * X_SE.p();
    return X_SE.q().conjugate() * from_E;
  }

 private:
  const DepthSurface* surface_;
  ScanPose X_SE_;
};

namespace deflection_detail {

/// A displayed ray among the pixels of the depth image: pixel(w) = at_infinity + w * per_w.
struct EpipolarLine {
  Vector2 at_infinity, per_w;
  double nearest_w;  ///< where the walk begins

  [[nodiscard]] Vector2 pixel(double w) const { return at_infinity + w * per_w; }
};

/// The part of the line, as falling w, that lies inside the picture; empty (first < last) when none does.
struct LinePart {
  double first, last;
};

[[nodiscard]] inline LinePart inside_part(const EpipolarLine& line, const PixelSize& size) {
  LinePart part{line.nearest_w, 0.0};
  const double extent[2] = {double(size.width), double(size.height)};
  for (int i = 0; i < 2; ++i) {
    const double p = line.at_infinity[i], d = line.per_w[i];
    if (d == 0.0) {
      if (p < 0.0 || p > extent[i]) return {-1.0, 0.0};
      continue;
    }
    const auto [low, high] = std::minmax({-p / d, (extent[i] - p) / d});
    part.first = std::min(part.first, high);
    part.last = std::max(part.last, low);
  }
  return part;
}

/// The walk along one epipolar line.
class EpipolarWalk {
 public:
  EpipolarWalk(const DepthSurface& surface, const EpipolarLine& line) : surface_(surface), line_(line) {}

  [[nodiscard]] DepthSource run() {
    const LinePart part = inside_part(line_, surface_.size());
    if (!(part.first >= part.last)) return found_at(0.0, SourceState::outside);
    begin(part.first);
    came_from_outside_ = part.first < line_.nearest_w;
    for (;;) {
      const double exit = std::max(next_crossing(), part.last);
      if (visit(exit)) return found_at(w_, SourceState::covered);
      if (exit <= part.last || !step()) break;
    }
    return ending(part.last > 0.0);
  }

 private:
  void begin(double w) {
    w_ = w;
    const Vector2 start = line_.pixel(w);
    const int count[2] = {surface_.size().width, surface_.size().height};
    for (int i = 0; i < 2; ++i) {
      // w falls, so that pixels go against per_w. On a border between two pixels the one ahead counts.
      direction_[i] = line_.per_w[i] > 0.0 ? -1 : line_.per_w[i] < 0.0 ? 1 : 0;
      const double at = direction_[i] < 0 ? std::ceil(start[i]) - 1.0 : std::floor(start[i]);
      cell_[i] = static_cast<int>(std::clamp(at, 0.0, double(count[i] - 1)));
    }
  }

  /// w at which the line leaves the present pixel along axis i.
  [[nodiscard]] double crossing(int i) const {
    if (direction_[i] == 0) return -std::numeric_limits<double>::infinity();
    const double border = cell_[i] + (direction_[i] > 0 ? 1 : 0);
    return (border - line_.at_infinity[i]) / line_.per_w[i];
  }
  [[nodiscard]] double next_crossing() {
    const double x = crossing(0), y = crossing(1);
    leaving_ = x >= y ? 0 : 1;
    return std::min(std::max(x, y), w_);
  }

  /// Follows the ray through the present facet from w_ down to `exit`; true when it meets the surface, at w_.
  [[nodiscard]] bool visit(double exit) {
    const DepthFacet facet = surface_.facet(cell_[0], cell_[1]);
    const double before_in = w_ - facet.at(line_.pixel(w_));  // positive: before the surface
    const double before_out = exit - facet.at(line_.pixel(exit));
    if (before_in < 0.0 && is_before_) {
      if (entered_ && surface_.linked(cell_[0], cell_[1], -entered_dx_, -entered_dy_)) return true;
      hide(facet);
    }
    if (before_in >= 0.0) is_before_ = true;
    if (is_before_ && before_in >= 0.0 && before_out < 0.0) {
      w_ += (exit - w_) * before_in / (before_in - before_out);
      return true;
    }
    if (before_out >= 0.0) is_before_ = true;
    last_facet_ = facet;
    w_ = exit;
    return false;
  }

  /// The ray passes behind `facet` over a cut edge: remembers the farther of the two sides for the guess, one pixel away
  /// from the edge if that side goes on: beside an edge, smoothed pictures hold a mixture of both sides.
  void hide(const DepthFacet& facet) {
    is_before_ = false;
    if (!entered_) return;
    const bool is_here = facet.w < last_facet_.w;
    const DepthFacet& farther = is_here ? facet : last_facet_;
    if (guess_ && !(farther.w < guess_->w)) return;
    const int x = cell_[0] - (is_here ? 0 : entered_dx_), y = cell_[1] - (is_here ? 0 : entered_dy_);
    const int dx = is_here ? entered_dx_ : -entered_dx_, dy = is_here ? entered_dy_ : -entered_dy_;
    guess_ = surface_.linked(x, y, dx, dy) ? surface_.facet(x + dx, y + dy) : farther;
  }

  [[nodiscard]] DepthSource found_at(double w, SourceState state) const {
    return {surface_.tangent_of_pixel(line_.pixel(w)), w, state};
  }

  [[nodiscard]] bool step() {
    const int count[2] = {surface_.size().width, surface_.size().height};
    cell_[leaving_] += direction_[leaving_];
    entered_ = true;
    entered_dx_ = leaving_ == 0 ? direction_[0] : 0;
    entered_dy_ = leaving_ == 1 ? direction_[1] : 0;
    return cell_[leaving_] >= 0 && cell_[leaving_] < count[leaving_];
  }

  [[nodiscard]] DepthSource ending(bool leaves_picture) const {
    if (is_before_) return found_at(0.0, leaves_picture ? SourceState::outside : SourceState::covered);
    const bool unknown = leaves_picture || (came_from_outside_ && !guess_);
    const SourceState state = unknown ? SourceState::outside : SourceState::disoccluded;
    if (!guess_) return found_at(0.0, state);
    return {surface_.tangent_of_pixel(guess_->centre), guess_->w, state};
  }

  const DepthSurface& surface_;
  const EpipolarLine& line_;
  int cell_[2] = {0, 0};
  int direction_[2] = {0, 0};
  int leaving_ = 0;
  int entered_dx_ = 0, entered_dy_ = 0;
  bool entered_ = false;  // from another pixel of the picture
  bool came_from_outside_ = false;
  bool is_before_ = true;  // the surface
  double w_ = 0.0;
  DepthFacet last_facet_;
  std::optional<DepthFacet> guess_;
};

}  // namespace deflection_detail

inline std::optional<DepthSource> DepthSearch::source(const Vector2& t_E, double s) const {
  if (surface_->is_empty()) return std::nullopt;
  const Rigid X_SE = X_SE_.at(s);
  const Vector3 d = X_SE.q() * direction_of_tangents(t_E);
  if (!(d.z() < 0.0)) return std::nullopt;
  const Vector2 t_infinite(d.x() / -d.z(), d.y() / -d.z());
  const Vector3& o = X_SE.p();
  const Vector2 per_w = Vector2(o.x(), o.y()) + o.z() * t_infinite;
  // Only what is ahead of E: its own distance from S's plane bounds w where it has moved forward.
  double nearest_w = surface_->greatest_w();
  if (o.z() < 0.0) nearest_w = std::min(nearest_w, -1.0 / o.z());
  const Vector2 scale = surface_->pixels_per_tangent();
  const deflection_detail::EpipolarLine line{surface_->pixel_of_tangent(t_infinite), scale.cwiseProduct(per_w),
                                             nearest_w};
  if (!line.at_infinity.allFinite() || !line.per_w.allFinite()) return std::nullopt;
  return deflection_detail::EpipolarWalk(*surface_, line).run();
}

}  // namespace holdfast
