/// Fixed-size vectors, matrices and quaternions of the public interface.
///
/// All are unaligned (Eigen::DontAlign), so that a struct of them has the same layout in a translation unit built for
/// SSE and in one built for AVX, and may be held in any container. Quaternions are Hamilton's; their members are named
/// (x, y, z, w) and are always passed by name, never by memory order.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace holdfast {

template <typename Scalar, int Rows>
using VectorOf = Eigen::Matrix<Scalar, Rows, 1, Eigen::DontAlign>;
/// Column-major, but for a single row, which Eigen wants row-major.
template <typename Scalar, int Rows, int Columns = Rows>
using MatrixOf =
    Eigen::Matrix<Scalar, Rows, Columns,
                  int(Eigen::DontAlign) | int(Rows == 1 && Columns != 1 ? Eigen::RowMajor : Eigen::ColMajor)>;
template <typename Scalar>
using QuaternionOf = Eigen::Quaternion<Scalar, Eigen::DontAlign>;

using Vector2 = VectorOf<double, 2>;
using Vector3 = VectorOf<double, 3>;
using Vector4 = VectorOf<double, 4>;
using Vector6 = VectorOf<double, 6>;
using Matrix2 = MatrixOf<double, 2>;
using Matrix3 = MatrixOf<double, 3>;
using Matrix4 = MatrixOf<double, 4>;
using Matrix6 = MatrixOf<double, 6>;
using Quaternion = QuaternionOf<double>;

}  // namespace holdfast
