/// A VQS transform (geometry/vqs.hpp) without upkeep, for the inside of a lookup.
///
/// Products here do not renormalise: a lookup multiplies a handful of unit quaternions and normalises the result once,
/// in `to_vqs`. Products with an inverse are one step instead of two.
#pragma once

#include <holdfast/geometry/vqs.hpp>

namespace holdfast::detail {

struct RawVqs {
  Vector3 v = Vector3::Zero();
  Quaternion q = Quaternion::Identity();
  double s = 1;

  RawVqs() = default;
  RawVqs(const Vector3& v_AB, const Quaternion& q_AB, double s_AB) : v(v_AB), q(q_AB), s(s_AB) {}
  RawVqs(const Vqs& T_AB) : v(T_AB.v()), q(T_AB.q()), s(T_AB.s()) {}
};

[[nodiscard]] inline Vqs to_vqs(const RawVqs& T) {
  return Vqs(T.v, T.q, T.s);
}

/// q v q^-1 of a unit quaternion, by two cross products.
[[nodiscard]] inline Vector3 turned(double w, double x, double y, double z, const Vector3& v) {
  const double tx = 2 * (y * v.z() - z * v.y()), ty = 2 * (z * v.x() - x * v.z()), tz = 2 * (x * v.y() - y * v.x());
  return Vector3((v.x() + w * tx) + (y * tz - z * ty), (v.y() + w * ty) + (z * tx - x * tz),
                 (v.z() + w * tz) + (x * ty - y * tx));
}

/// T_AC = T_AB T_BC.
[[nodiscard]] inline RawVqs product(const RawVqs& T_AB, const RawVqs& T_BC) {
  const Vector3 p = turned(T_AB.q.w(), T_AB.q.x(), T_AB.q.y(), T_AB.q.z(), T_BC.v);
  const Vector3 v = T_AB.v + T_AB.s * p;
  return RawVqs(v, T_AB.q * T_BC.q, T_AB.s * T_BC.s);
}

/// T_BA.
[[nodiscard]] inline RawVqs inverse(const RawVqs& T_AB) {
  const double s_BA = T_AB.s == 1 ? 1 : 1 / T_AB.s;
  const Vector3 v = -s_BA * turned(T_AB.q.w(), -T_AB.q.x(), -T_AB.q.y(), -T_AB.q.z(), T_AB.v);
  return RawVqs(v, T_AB.q.conjugate(), s_BA);
}

/// T_BC = T_AB^-1 T_AC.
[[nodiscard]] inline RawVqs inverse_product(const RawVqs& T_AB, const RawVqs& T_AC) {
  const double s_BA = T_AB.s == 1 ? 1 : 1 / T_AB.s;
  const Vector3 d = T_AC.v - T_AB.v;
  const Vector3 v = s_BA * turned(T_AB.q.w(), -T_AB.q.x(), -T_AB.q.y(), -T_AB.q.z(), d);
  return RawVqs(v, T_AB.q.conjugate() * T_AC.q, s_BA * T_AC.s);
}

}  // namespace holdfast::detail
