#include <limits>
#include <type_traits>

#include <doctest/doctest.h>
#include <glm/gtc/matrix_transform.hpp>

#include <holdfast/interop/glm.hpp>

using namespace holdfast;

namespace {

const Vector3 p_B(0.3, -0.7, 1.1);
const Quaternion q_AB = so3::exp<double>(Vector3(0.2, -0.9, 1.4));

Vector3 transformed(const glm::dmat4& M_AB, const Vector3& p) {
  const glm::dvec4 h = M_AB * glm::dvec4(p.x(), p.y(), p.z(), 1.0);
  return Vector3(h.x, h.y, h.z);
}

}  // namespace

TEST_CASE("precision is kept unless another is asked for") {
  static_assert(std::is_same_v<decltype(to_glm(Vector3())), glm::dvec3>);
  static_assert(std::is_same_v<decltype(to_glm<float>(Vector3())), glm::vec3>);
  static_assert(std::is_same_v<decltype(to_glm<float>(Matrix4())), glm::mat4>);
  static_assert(std::is_same_v<decltype(to_glm(Quaternion())), glm::dquat>);
  static_assert(std::is_same_v<decltype(to_glm<float>(Rigid())), glm::mat4>);
  static_assert(std::is_same_v<decltype(to_glm(Vqsf())), glm::mat4>);
  static_assert(std::is_same_v<decltype(from_glm(glm::mat4())), MatrixOf<float, 4>>);
  CHECK(to_glm<float>(Vector2(0.1, 0.2)) == glm::vec2(0.1f, 0.2f));
}

TEST_CASE("vectors keep the order of their numbers") {
  CHECK(to_glm(Vector2(1, 2)) == glm::dvec2(1, 2));
  CHECK(to_glm(Vector3(1, 2, 3)) == glm::dvec3(1, 2, 3));
  CHECK(to_glm(Vector4(1, 2, 3, 4)) == glm::dvec4(1, 2, 3, 4));
  CHECK(from_glm(glm::dvec3(1, 2, 3)) == Vector3(1, 2, 3));
}

TEST_CASE("a quaternion's w stays w, whatever the order in memory or in the constructor") {
  const Quaternion q(0.1, 0.2, 0.3, 0.4);  // w, x, y, z
  const glm::dquat g = to_glm(q);
  CHECK(g.w == 0.1);
  CHECK(g.x == 0.2);
  CHECK(g.y == 0.3);
  CHECK(g.z == 0.4);
  CHECK(from_glm(g).coeffs() == q.coeffs());
  CHECK(from_glm(glm::dquat(1, 0, 0, 0)).w() == 1.0);
}

TEST_CASE("a quaternion turns a point the same way on either side") {
  const glm::dvec3 theirs = to_glm(q_AB) * to_glm(p_B);
  const Vector3 ours = q_AB * p_B;
  CHECK((from_glm(theirs) - ours).norm() < 1e-15);  // rounding of numbers below 2
  // The trap: the same four numbers in the wrong order turn it elsewhere.
  const glm::dquat wrong(q_AB.x(), q_AB.y(), q_AB.z(), q_AB.w());
  CHECK((from_glm(wrong * to_glm(p_B)) - ours).norm() > 0.1);
}

TEST_CASE("matrices are column-major on both sides: translation is the last column") {
  Matrix4 m;
  m << 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16;
  const glm::dmat4 g = to_glm(m);
  CHECK(g[3] == glm::dvec4(4, 8, 12, 16));
  CHECK(g[0][1] == 5.0);
  CHECK(from_glm(g) == m);
  MatrixOf<double, 2, 3> wide;
  wide << 1, 2, 3, 4, 5, 6;
  CHECK(to_glm(wide)[2] == glm::dvec2(3, 6));
  CHECK(from_glm(to_glm(wide)) == wide);
}

TEST_CASE("X_AB and T_AB move a point as their GLM matrices do, and as GLM's own functions make them") {
  const Rigid X_AB(q_AB, Vector3(1, -2, 3));
  const Vqs T_AB(Vector3(1, -2, 3), q_AB, 2.5);
  // Rounding of numbers below 10.
  CHECK((transformed(to_glm(X_AB), p_B) - X_AB * p_B).norm() < 1e-14);
  CHECK((transformed(to_glm(T_AB), p_B) - T_AB * p_B).norm() < 1e-14);
  const glm::dmat4 M_AB = glm::translate(glm::dmat4(1), glm::dvec3(1, -2, 3)) * glm::mat4_cast(to_glm(q_AB)) *
                          glm::scale(glm::dmat4(1), glm::dvec3(2.5));
  CHECK((from_glm(M_AB) - T_AB.matrix()).cwiseAbs().maxCoeff() < 1e-14);
}

TEST_CASE("round trips through matrices") {
  const Vqs T_AB(Vector3(1, -2, 3), q_AB, 2.5);
  const Vqs back = vqs_from_glm(to_glm(T_AB)).value();
  CHECK((back * p_B - T_AB * p_B).norm() < 1e-14);
  CHECK(back.s() == doctest::Approx(2.5).epsilon(1e-14));
  const Vqsf single = vqs_from_glm(to_glm<float>(T_AB)).value();
  // Single precision: 1e-7 of numbers below 10.
  CHECK((single * p_B.cast<float>() - (T_AB * p_B).cast<float>()).norm() < 1e-5f);
  const Rigid X_AB(q_AB, Vector3(1, -2, 3));
  CHECK((rigid_from_glm(to_glm(X_AB)).value() * p_B - X_AB * p_B).norm() < 1e-14);
}

TEST_CASE("a matrix that is no such transform gives nothing") {
  CHECK_FALSE(rigid_from_glm(to_glm(Vqs(Vector3(0, 0, 0), q_AB, 2.0))).has_value());
  CHECK(vqs_from_glm(to_glm(Vqs(Vector3(0, 0, 0), q_AB, 2.0))).has_value());
  CHECK_FALSE(vqs_from_glm(glm::scale(glm::dmat4(1), glm::dvec3(1, 1, 2))).has_value());
  CHECK_FALSE(vqs_from_glm(glm::scale(glm::dmat4(1), glm::dvec3(1, 1, -1))).has_value());
  CHECK_FALSE(vqs_from_glm(glm::perspective(1.0, 1.5, 0.1, 10.0)).has_value());
  glm::dmat4 bad(1);
  bad[3][0] = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(vqs_from_glm(bad).has_value());
}
