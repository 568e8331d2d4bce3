// The matrices an engine draws with, in every convention, against the picture's own pixels.
#include <cmath>
#include <random>

#include <doctest/doctest.h>

#include "pipeline/pipeline_heads.hpp"

using namespace holdfast;
using namespace holdfast::test;

TEST_CASE("view and projection put a point where the rendered view says, in every depth range and Y direction") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  HmdModel hmd = rolling_hmd();
  hmd.left.X_HE = eye_pose(EyeSide::left, 0.064, degrees(6.0), degrees(-2.0));
  const FieldOutline outline(hmd.left, LensMode::exact, hmd.timing);
  const EyePicture picture = *overfilled_picture(hmd.left, outline, {degrees(3.0), degrees(2.0), degrees(1.0)});
  for (const DepthRange depth : {DepthRange::minus_one_to_one, DepthRange::zero_to_one, DepthRange::one_to_zero}) {
    for (const YDirection y : {YDirection::up, YDirection::down}) {
      for (const double far_m : {50.0, std::numeric_limits<double>::infinity()}) {
        const ClipSettings clip{{0.1, far_m}, depth, y};
        const Rigid X_WE = Rigid(so3::exp<double>(Vector3(unit(random), unit(random), unit(random))),
                                 Vector3(unit(random), 1.7, unit(random))) *
                           hmd.left.X_HE;
        const EyeView eye = make_eye_view(EyeSide::left, X_WE, time_at(1.5), picture, clip);
        CHECK(eye.projection == projection_matrix(picture.tangents, clip.planes, depth, y));
        for (int i = 0; i < 20; ++i) {
          const double distance = 0.2 + 20.0 * std::abs(unit(random));
          const Vector3 p_E = distance * Vector3(0.5 * unit(random), 0.3 * unit(random), -1.0);
          const Vector3 p_W = X_WE * p_E;
          const Vector4 clip_p = eye.projection * eye.view * Vector4(p_W.x(), p_W.y(), p_W.z(), 1.0);
          const Vector2 ndc(clip_p.x() / clip_p.w(), (y == YDirection::up ? 1.0 : -1.0) * clip_p.y() / clip_p.w());
          const Vector2 pixel(0.5 * (ndc.x() + 1.0) * eye.viewport.width, 0.5 * (ndc.y() + 1.0) * eye.viewport.height);
          const RenderedView view = eye.rendered_view();
          const Vector2 expected = source_pixel_of_tangent(view, *tangents_of_point(p_E));
          CHECK((pixel - expected).norm() < 1e-9);  // rounding of 1300 px through three matrices
        }
      }
    }
  }
}
