/// Cholesky's factor of a small symmetric positive definite matrix, S = L L^T, and what is solved by it.
///
/// Source: Golub & Van Loan, Matrix Computations, 4th edition, sections 3.1 and 4.2. Plain loops, which compilers unroll at such
/// sizes. Eigen's own LLT and LDLT solve as well, but each size of them costs a compiler some 20,000 class templates, as much as
/// all of a filter: they are for matrices whose size is known at run time only.
/// Shapes: S and L are Size x Size; B has Size rows and any fixed number of columns. Units: the caller's.
/// Bad input: `cholesky` answers false when S is not positive definite, or a number is not finite; the others then have no L to
/// work with.
#pragma once

#include <cmath>
#include <limits>

#include <holdfast/geometry/types.hpp>

namespace holdfast {

/// Lower L with L L^T = S, from S's lower triangle; false when S is not positive definite. Zeros above the diagonal.
template <int Size>
[[nodiscard]] bool cholesky(const MatrixOf<double, Size>& S, MatrixOf<double, Size>& L) {
  for (int j = 0; j < Size; ++j) {
    double pivot = S(j, j);
    for (int k = 0; k < j; ++k) pivot -= L(j, k) * L(j, k);
    if (!(pivot > 0.0 && pivot < std::numeric_limits<double>::max())) return false;
    L(j, j) = std::sqrt(pivot);
    for (int i = j + 1; i < Size; ++i) {
      double sum = S(i, j);
      for (int k = 0; k < j; ++k) sum -= L(i, k) * L(j, k);
      L(i, j) = sum / L(j, j);
      L(j, i) = 0.0;
    }
  }
  return true;
}

/// L^-1 B: when B's columns have the covariance S, these have the identity.
template <int Size, int Columns>
[[nodiscard]] MatrixOf<double, Size, Columns> whitened_by(const MatrixOf<double, Size>& L,
                                                          MatrixOf<double, Size, Columns> B) {
  for (int column = 0; column < Columns; ++column) {
    for (int i = 0; i < Size; ++i) {
      double sum = B(i, column);
      for (int k = 0; k < i; ++k) sum -= L(i, k) * B(k, column);
      B(i, column) = sum / L(i, i);
    }
  }
  return B;
}

/// L^-T B.
template <int Size, int Columns>
[[nodiscard]] MatrixOf<double, Size, Columns> back_substituted(const MatrixOf<double, Size>& L,
                                                               MatrixOf<double, Size, Columns> B) {
  for (int column = 0; column < Columns; ++column) {
    for (int i = Size - 1; i >= 0; --i) {
      double sum = B(i, column);
      for (int k = i + 1; k < Size; ++k) sum -= L(k, i) * B(k, column);
      B(i, column) = sum / L(i, i);
    }
  }
  return B;
}

/// S^-1 B.
template <int Size, int Columns>
[[nodiscard]] MatrixOf<double, Size, Columns> solved_by(const MatrixOf<double, Size>& L,
                                                        const MatrixOf<double, Size, Columns>& B) {
  return back_substituted<Size, Columns>(L, whitened_by<Size, Columns>(L, B));
}

/// S^-1, exactly symmetric.
template <int Size>
[[nodiscard]] MatrixOf<double, Size> inverse_by(const MatrixOf<double, Size>& L) {
  const MatrixOf<double, Size> inverse = solved_by<Size, Size>(L, MatrixOf<double, Size>::Identity());
  MatrixOf<double, Size> symmetric;
  for (int j = 0; j < Size; ++j) {
    for (int i = 0; i < Size; ++i) symmetric(i, j) = 0.5 * (inverse(i, j) + inverse(j, i));
  }
  return symmetric;
}

/// v^T S^-1 v, Mahalanobis' distance squared.
template <int Size>
[[nodiscard]] double squared_distance(const MatrixOf<double, Size>& L, const VectorOf<double, Size>& v) {
  const VectorOf<double, Size> white = whitened_by<Size, 1>(L, v);
  double sum = 0.0;
  for (int i = 0; i < Size; ++i) sum += white[i] * white[i];
  return sum;
}

}  // namespace holdfast
