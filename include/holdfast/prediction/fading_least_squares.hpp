/// Weights that would have predicted best of late: linear least squares that forgets.
///
/// Finds c that minimises the sum of |y - F c|^2 over past examples, each counting exp(-age / memory), and stays near a
/// prior where they do not decide (ridge regression). The axes of a vector share their weights, so no direction is
/// preferred.
/// Source: recursive least squares with exponential forgetting (Ljung 1999, System Identification, section 11.2), here
/// by its normal equations, which cannot drift. Units: those of the examples. Nothing here allocates.
/// Bad input: precondition finite examples.
#pragma once

#include <holdfast/geometry/cholesky.hpp>

namespace holdfast {

template <int N>
class FadingLeastSquares {
 public:
  using Weights = VectorOf<double, N>;
  using Features = MatrixOf<double, 3, N>;

  /// `fade` is what remains of the earlier examples.
  void add(const Features& features, const Vector3& target, double fade) {
    count_ = fade * count_ + 1.0;
    A_ *= fade;
    b_ *= fade;
    A_.noalias() += features.transpose().lazyProduct(features);
    b_.noalias() += features.transpose().lazyProduct(target);
  }

  /// `ridge` holds each weight at its prior: by this part of what its examples weigh, and as if as many examples had
  /// spoken for it in which its movement was `usual`. Precondition: ridge > 0. Without examples: the prior.
  [[nodiscard]] Weights solve(const Weights& prior, double ridge, const Weights& usual) const {
    MatrixOf<double, N> A = A_;
    const Weights stiffness = (ridge * A_.diagonal() + count_ * usual.cwiseAbs2()).array() + 1e-14;
    A.diagonal() += stiffness;
    const Weights rhs = b_ + stiffness.cwiseProduct(prior);
    MatrixOf<double, N> L;
    if (!cholesky<N>(A, L)) return prior;
    const Weights weights = solved_by<N, 1>(L, rhs);
    return weights.allFinite() ? weights : prior;
  }

 private:
  MatrixOf<double, N> A_ = MatrixOf<double, N>::Zero();
  Weights b_ = Weights::Zero();
  double count_ = 0.0;  ///< of examples, faded
};

}  // namespace holdfast
