/// How far the registration scene is from an eye in a direction: what a depth buffer would hold, without drawing.
///
/// A ray t = (t_x, t_y, -1) from the eye's origin hits a flat thing at distance lambda along -Z, lambda = n . c / n . t
/// (c: a point of its plane, n: its normal, in E), if the hit lies inside its outline; a bar of the frame corner where
/// the ray is inside all three pairs of its faces (slab method). The nearest hit counts, from either side; where there
/// is none the distance is infinite. Distances in metres along -Z, as DepthImage has them. Things that cannot be in the
/// cone round the field are left out when the eye is placed. Bad input: nothing is checked.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <holdfast/optics/tangents.hpp>
#include <holdfast/registration/scene_fiducials.hpp>

namespace holdfast {

class SceneDepth {
 public:
  /// The scene as seen from X_WE, in the directions of `field`. Keeps its memory when placed again.
  void place(const RegistrationScene& scene, const Rigid& X_WE, const FieldTangents& field) {
    X_EW_ = X_WE.inverse();
    set_cone(field);
    discs_.clear();
    rectangles_.clear();
    boxes_.clear();
    for (const Disc& disc : scene.discs) {
      const Vector3 c = X_EW_ * disc.centre_W;
      if (!may_be_seen(c, disc.radius_m)) continue;
      const Vector3 n = X_EW_.q() * disc.normal_W;
      discs_.push_back({c, n, n.dot(c), disc.radius_m * disc.radius_m});
    }
    add_rectangle(scene.edge.bottom_W, scene.edge.across_W, scene.edge.top_W - scene.edge.bottom_W);
    const Quaternion& q_WC = scene.board.X_WC.q();
    if (scene.board.columns > 0 && scene.board.rows > 0) {
      add_rectangle(scene.board.X_WC.p(), q_WC * Vector3(scene.board.columns * scene.board.square_m, 0.0, 0.0),
                    q_WC * Vector3(0.0, scene.board.rows * scene.board.square_m, 0.0));
    }
    add_corner(scene.corner);
  }

  /// Distance along -Z of the first thing in the direction of tangent `t`; infinite when there is none.
  [[nodiscard]] double at(const Vector2& t) const {
    const Vector3 ray(t.x(), t.y(), -1.0);
    double nearest = std::numeric_limits<double>::infinity();
    for (const FlatDisc& disc : discs_) {
      const double distance = disc.n_c / disc.n.dot(ray);
      if (!(distance > 0.0 && distance < nearest)) continue;
      if ((distance * ray - disc.c).squaredNorm() <= disc.r2) nearest = distance;
    }
    for (const Rectangle& r : rectangles_) {
      const double distance = r.n_o / r.n.dot(ray);
      if (!(distance > 0.0 && distance < nearest)) continue;
      const Vector3 q = distance * ray - r.o;
      const double u = q.dot(r.u), v = q.dot(r.v);
      if (u >= 0.0 && v >= 0.0 && u <= r.uu && v <= r.vv) nearest = distance;
    }
    for (const Box& box : boxes_) nearest = std::min(nearest, first_hit(box, ray));
    return nearest;
  }

 private:
  struct FlatDisc {
    Vector3 c, n;
    double n_c, r2;
  };
  struct Rectangle {
    Vector3 o, u, v, n;
    double n_o, uu, vv;
  };
  struct Box {
    Rigid X_FE;
    Vector3 low, high;
  };

  void set_cone(const FieldTangents& field) {
    double reach = 0.0;
    for (const double x : {field.left, field.right}) {
      for (const double y : {field.down, field.up}) reach = std::max(reach, std::hypot(x, y));
    }
    cone_ = std::atan(reach);
  }
  /// A ball round c, against the cone that holds the field.
  [[nodiscard]] bool may_be_seen(const Vector3& c, double radius) const {
    const double distance = c.norm();
    if (distance <= radius) return true;
    return std::acos(std::clamp(-c.z() / distance, -1.0, 1.0)) - std::asin(radius / distance) <= cone_;
  }

  void add_rectangle(const Vector3& o_W, const Vector3& u_W, const Vector3& v_W) {
    const Vector3 o = X_EW_ * o_W, u = X_EW_.q() * u_W, v = X_EW_.q() * v_W;
    if (!may_be_seen(o + 0.5 * (u + v), 0.5 * (u + v).norm())) return;
    const Vector3 n = u.cross(v);
    rectangles_.push_back({o, u, v, n, n.dot(o), u.squaredNorm(), v.squaredNorm()});
  }

  void add_corner(const FrameCorner& corner) {
    if (!(corner.length_m > 0.0)) return;
    const Rigid X_FE = (X_EW_ * corner.X_WF).inverse();
    const double half = 0.5 * corner.thickness_m;
    for (int axis = 0; axis < 3; ++axis) {
      Box box{X_FE, Vector3::Constant(-half), Vector3::Constant(half)};
      box.high[axis] = corner.length_m;
      const Vector3 middle = 0.5 * (box.low + box.high);
      if (may_be_seen(X_EW_ * (corner.X_WF * middle), 0.5 * (box.high - box.low).norm())) boxes_.push_back(box);
    }
  }

  [[nodiscard]] static double first_hit(const Box& box, const Vector3& ray_E) {
    const Vector3& from = box.X_FE.p();
    const Vector3 ray = box.X_FE.q() * ray_E;
    double enter = 0.0, leave = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      const double a = (box.low[axis] - from[axis]) / ray[axis], b = (box.high[axis] - from[axis]) / ray[axis];
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
    return enter <= leave ? enter : std::numeric_limits<double>::infinity();
  }

  Rigid X_EW_;
  double cone_ = 0.0;
  std::vector<FlatDisc> discs_;
  std::vector<Rectangle> rectangles_;
  std::vector<Box> boxes_;
};

}  // namespace holdfast
