/// The complete visual display transform: a point of an object to the pixel that shows it, built from a descriptor.
///
/// Source: Robinett & Holloway 1994, eq. 6.4 and tables 6.1 and 8.1 (course 11):
///   T_S_O = T_S_US T_US_N T_N_E T_E_H T_H_HS T_HS_TB T_TB_R T_R_W T_W_O
/// O object, W world, R room, TB tracker base, HS head sensor, H head, E eye: frames of a FrameGraph. N normalized, US
/// undistorted screen, S screen: two matrices and a lens map, handed in here as data (optics/ makes them), because they
/// are no VQS transforms. H_HS, TB_R and E_H are static; the tracker's HS_TB, R_W (flying) and W_O (grabbing) are
/// dynamic. The descriptor holds transforms the way table 8.1 prints them and people measure them: T_H_E, T_H_HS,
/// T_R_TB; the tracker's samples are T_TB_HS, the pose it reports. The graph inverts. Units: metres; pixels with the
/// origin at the lower left. Bad input: a name that is taken or a transform that is not finite gives a message and
/// leaves the graph as it was; a point that is not in front of the eye or outside the lens gives nothing.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <holdfast/frames/chain.hpp>
#include <holdfast/frames/graph.hpp>
#include <holdfast/geometry/rigid.hpp>

namespace holdfast {

/// T_S_US: where a point of the undistorted screen (px) must be drawn for the lens to show it in its place; nothing
/// when the lens cannot show it. Empty: no lens.
using LensMap = std::function<std::optional<Vector2>(const Vector2& p_US)>;

struct EyeDescriptor {
  std::string name;                    ///< frame name, e.g. "LE"
  Rigid X_HE;                          ///< pose of the eye in the head
  Matrix4 T_NE = Matrix4::Identity();  ///< perspective, 000 section 7.7
  Matrix4 T_US_N =
      Matrix4::Identity();  ///< viewport, 000 section 7.8, as 4x4: rows x and y give px after the division by w
  LensMap T_S_US;           ///< 000 section 7.9
};

struct UserDescriptor {
  std::string name;  ///< appended to the frame names of this user: "1" gives R1, TB1, HS1, H1, LE1, RE1
  Rigid X_R_TB;      ///< where the tracker base is mounted in the room
  Rigid X_H_HS;      ///< where the sensor is mounted on the head-mounted display
  Vqs T_RW;          ///< where the user is in the world at first
  HistoryOptions tracking;
  HistoryOptions navigation{.capacity = 16};
  std::vector<EyeDescriptor> eyes;  ///< usually two
};

struct EyeFrames {
  FrameId E;
  EdgeId T_HE;
  EyeDescriptor descriptor;
};

struct UserFrames {
  FrameId R, TB, HS, H;
  EdgeId T_RW;     ///< dynamic: push or steer when the user flies, tilts or scales
  EdgeId T_R_TB;   ///< static
  EdgeId T_TB_HS;  ///< dynamic: push the tracker's measurements
  EdgeId T_H_HS;   ///< static
  std::vector<EyeFrames> eyes;
};

struct AddedUser {
  std::optional<UserFrames> user;
  std::string message;  ///< empty when the user was added
  explicit operator bool() const { return user.has_value(); }
};

namespace detail {

inline std::string refuse_user(const FrameGraph& graph, FrameId W, const UserDescriptor& d) {
  if (!graph.contains(W)) return "the world frame is not of this graph";
  std::vector<std::string> names{"R", "TB", "HS", "H"};
  bool finite = d.X_R_TB.is_finite() && d.X_H_HS.is_finite() && d.T_RW.is_finite();
  for (const EyeDescriptor& eye : d.eyes) {
    names.push_back(eye.name);
    finite = finite && eye.X_HE.is_finite() && eye.T_NE.allFinite() && eye.T_US_N.allFinite();
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string name = names[i] + d.name;
    if (names[i].empty()) return "an eye of user '" + d.name + "' has no name";
    if (graph.find(name)) return "the frame " + name + " is there already: give user '" + d.name + "' another name";
    for (std::size_t j = 0; j < i; ++j) {
      if (names[i] == names[j]) return "user '" + d.name + "' has two frames " + name;
    }
  }
  return finite ? "" : "a transform of user '" + d.name + "' has a number that is not finite";
}

}  // namespace detail

/// Adds a user's branch below the world. T_RW gets its first sample at time `since`; the tracker has none yet.
inline AddedUser add_user(FrameGraph& graph, FrameId W, const UserDescriptor& d, HostTime since) {
  std::string refusal = detail::refuse_user(graph, W, d);
  if (!refusal.empty()) return {std::nullopt, std::move(refusal)};
  UserFrames u;
  u.R = graph.frame("R" + d.name);
  u.TB = graph.frame("TB" + d.name);
  u.HS = graph.frame("HS" + d.name);
  u.H = graph.frame("H" + d.name);
  u.T_RW = graph.add_dynamic(u.R, W, d.navigation).edge;
  u.T_R_TB = graph.add_static(u.R, u.TB, d.X_R_TB).edge;
  u.T_TB_HS = graph.add_dynamic(u.TB, u.HS, d.tracking).edge;
  u.T_H_HS = graph.add_static(u.H, u.HS, d.X_H_HS).edge;
  for (const EyeDescriptor& eye : d.eyes) {
    const FrameId E = graph.frame(eye.name + d.name);
    u.eyes.push_back({E, graph.add_static(u.H, E, eye.X_HE).edge, eye});
  }
  graph.push(u.T_RW, since, d.T_RW);
  return {std::move(u), {}};
}

/// What happened to one point on its way to the screen.
struct ScreenPoint {
  Vector3 p_E = Vector3::Zero();
  Vector3 p_N = Vector3::Zero();
  Vector2 p_US = Vector2::Zero();
  Vector2 p_S = Vector2::Zero();
};

/// T_S_O at one time.
struct ScreenTransform {
  LookupStatus status = LookupStatus::no_path;
  Duration age{0};
  Matrix4 T_US_O = Matrix4::Identity();  ///< everything but the lens, in one matrix
  const LensMap* T_S_US = nullptr;

  explicit operator bool() const { return status == LookupStatus::ok || status == LookupStatus::held; }

  /// The pixel that shows p_O; nothing when the transform is not usable, the point is not in front of the eye, or the
  /// lens cannot show it. A pixel outside the viewport is given: clipping is the renderer's.
  [[nodiscard]] std::optional<Vector2> operator()(const Vector3& p_O) const {
    if (!*this) return std::nullopt;
    const Vector4 h = T_US_O * Vector4(p_O.x(), p_O.y(), p_O.z(), 1.0);
    if (!(h.w() > 0)) return std::nullopt;
    const Vector2 p_US(h.x() / h.w(), h.y() / h.w());
    return *T_S_US ? (*T_S_US)(p_US) : std::optional<Vector2>(p_US);
  }
};

/// T_S_O of one eye and one object, every static factor folded once: T_US_HS = T_US_N T_N_E T_E_H T_H_HS is one matrix.
/// `at` allocates nothing (calling a lens map may, if the map does).
class DisplayChain {
 public:
  /// Preconditions: the user and its eye (an index into user.eyes) are of this graph.
  DisplayChain(const FrameGraph& graph, const UserFrames& user, std::size_t eye, FrameId O)
      : eye_(user.eyes.at(eye)),
        O_(O),
        T_EO_(graph, eye_.E, O),
        T_HS_O_(graph, user.HS, O),
        T_US_HS_(eye_.descriptor.T_US_N * eye_.descriptor.T_NE *
                 graph.lookup(eye_.E, user.HS, HostTime()).T_AB.matrix()) {}

  [[nodiscard]] ScreenTransform at(HostTime t) const {
    const Lookup T_HS_O = T_HS_O_.at(t);
    ScreenTransform result{T_HS_O.status, T_HS_O.age, Matrix4::Identity(), &eye_.descriptor.T_S_US};
    if (T_HS_O) result.T_US_O = T_US_HS_ * T_HS_O.T_AB.matrix();
    return result;
  }

  /// Factor by factor instead of folded, to see each station: eye, normalized, undistorted screen, screen. Nothing as
  /// above.
  [[nodiscard]] std::optional<ScreenPoint> trace(const Vector3& p_O, HostTime t) const {
    const Lookup T_EO = T_EO_.at(t);
    if (!T_EO) return std::nullopt;
    ScreenPoint p;
    p.p_E = T_EO.T_AB * p_O;
    const Vector4 clip = eye_.descriptor.T_NE * Vector4(p.p_E.x(), p.p_E.y(), p.p_E.z(), 1.0);
    if (!(clip.w() > 0)) return std::nullopt;
    p.p_N = clip.head<3>() / clip.w();
    const Vector4 us = eye_.descriptor.T_US_N * Vector4(p.p_N.x(), p.p_N.y(), p.p_N.z(), 1.0);
    p.p_US = us.head<2>() / us.w();
    const std::optional<Vector2> p_S = eye_.descriptor.T_S_US ? eye_.descriptor.T_S_US(p.p_US) : p.p_US;
    if (!p_S) return std::nullopt;
    p.p_S = *p_S;
    return p;
  }

  [[nodiscard]] FrameId E() const { return eye_.E; }
  [[nodiscard]] FrameId O() const { return O_; }

 private:
  EyeFrames eye_;
  FrameId O_;
  Chain T_EO_, T_HS_O_;
  Matrix4 T_US_HS_;
};

}  // namespace holdfast
