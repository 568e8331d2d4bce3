/// A VQS transform (geometry/vqs.hpp) as bare numbers and without upkeep, for the inside of a lookup.
///
/// Products here do not renormalise: a lookup multiplies a handful of unit quaternions and normalises the result once,
/// in `to_vqs`. Bare numbers, multiplied in place, are what compilers keep in registers: with matrix types, pieces are
/// stored one by one and loaded in pairs, and every such load waits.
#pragma once

#include <holdfast/geometry/vqs.hpp>

namespace holdfast::detail {

struct RawVqs {
  double vx, vy, vz;
  Quaternion q;
  double s;

  RawVqs() = default;  // not initialised
  RawVqs(const Vqs& T) : vx(T.v().x()), vy(T.v().y()), vz(T.v().z()), q(T.q()), s(T.s()) {}
};

[[nodiscard]] inline Vqs to_vqs(const RawVqs& T) {
  return Vqs(Vector3(T.vx, T.vy, T.vz), T.q, T.s);
}

/// T_AC = T_AB T_BC; T_AC may be one of the two.
EIGEN_ALWAYS_INLINE void multiply(const RawVqs& T_AB, const RawVqs& T_BC, RawVqs& T_AC) {
  const double x = T_AB.q.x(), y = T_AB.q.y(), z = T_AB.q.z(), w = T_AB.q.w(), s = T_AB.s;
  const double vx = T_BC.vx, vy = T_BC.vy, vz = T_BC.vz;
  // q v q^-1 of a unit quaternion, by two cross products.
  const double tx = 2 * (y * vz - z * vy), ty = 2 * (z * vx - x * vz), tz = 2 * (x * vy - y * vx);
  T_AC.vx = T_AB.vx + s * ((vx + w * tx) + (y * tz - z * ty));
  T_AC.vy = T_AB.vy + s * ((vy + w * ty) + (z * tx - x * tz));
  T_AC.vz = T_AB.vz + s * ((vz + w * tz) + (x * ty - y * tx));
  T_AC.q = T_AB.q * T_BC.q;
  T_AC.s = s * T_BC.s;
}

/// T_BC = T_AB^-1 T_AC; T_BC may be one of the two.
EIGEN_ALWAYS_INLINE void divide(const RawVqs& T_AB, const RawVqs& T_AC, RawVqs& T_BC) {
  const double x = T_AB.q.x(), y = T_AB.q.y(), z = T_AB.q.z(), w = T_AB.q.w(), s = T_AB.s == 1 ? 1 : 1 / T_AB.s;
  const double vx = T_AC.vx - T_AB.vx, vy = T_AC.vy - T_AB.vy, vz = T_AC.vz - T_AB.vz;
  const double tx = 2 * (y * vz - z * vy), ty = 2 * (z * vx - x * vz), tz = 2 * (x * vy - y * vx);
  T_BC.vx = s * ((vx - w * tx) + (y * tz - z * ty));
  T_BC.vy = s * ((vy - w * ty) + (z * tx - x * tz));
  T_BC.vz = s * ((vz - w * tz) + (x * ty - y * tx));
  T_BC.q = T_AB.q.conjugate() * T_AC.q;
  T_BC.s = s * T_AC.s;
}

}  // namespace holdfast::detail
