#include <cstdio>

#include "sizes.hpp"

Sizes second_sizes();
holdfast::Rigid second_product(const holdfast::Rigid& X_AB, const holdfast::Rigid& X_BC);

int main() {
  using holdfast::Rigid;
  using holdfast::Vector3;
  if (sizes() != second_sizes()) {
    std::puts("the two files disagree about the layout of a public type");
    return 1;
  }
  const Rigid X_AB(holdfast::so3::exp<double>(Vector3(0.1, 0.2, 0.3)), Vector3(1, 2, 3));
  const Rigid X_BC(holdfast::so3::exp<double>(Vector3(-0.4, 0.2, 0.1)), Vector3(4, 5, 6));
  const Vector3 p_C(0.5, 0.25, -2.0);
  const double apart = (second_product(X_AB, X_BC) * p_C - X_AB * (X_BC * p_C)).norm();
  // A few roundings of numbers of size 10; fused multiply-add may differ in the last bits.
  return apart < 1e-14 ? 0 : 1;
}
