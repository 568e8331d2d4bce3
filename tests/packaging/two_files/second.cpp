#include "sizes.hpp"

// Built for AVX2 where the processor has it: layouts must not depend on that.
Sizes second_sizes() {
  return sizes();
}

holdfast::Rigid second_product(const holdfast::Rigid& X_AB, const holdfast::Rigid& X_BC) {
  return X_AB * X_BC;
}
