// The frame loop: its plan, its poses, its stages, and that it tells what it had to make do with.
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <thread>

#include <doctest/doctest.h>

#include <holdfast/deflection/composed_warp.hpp>

#include "pipeline/pipeline_heads.hpp"

using namespace holdfast;
using namespace holdfast::test;

namespace {

constexpr auto ms = [](double x) { return from_milliseconds(x); };

/// Begins, latches and deflects one frame at the given times.
struct Run {
  Frame frame;
  LateLatch latch;
  FrameDeflection deflection;
};
Run run_frame(FrameLoop& loop, HostTime begin, HostTime latch, HostTime deflect) {
  Run run;
  run.frame = loop.begin_frame(begin);
  run.latch = loop.late_latch(run.frame, latch);
  run.deflection = loop.deflect(run.frame.rendered_views(), deflect);
  return run;
}

}  // namespace

TEST_CASE("a frame is planned as plan_frame plans it, and predicted to the middle of its scan-out") {
  const HmdModel hmd = rolling_hmd();
  LatestPose latest;
  latest.publish(steady_head(1.000));
  const LatestPoseSource source(latest);
  FrameLoopSettings settings;
  settings.compute_time = ms(2);
  settings.render_start_phase = ms(1);
  settings.scan_out_refreshes = 2;
  settings.warp_time = ms(1.5);
  FrameLoop loop(hmd, source, settings);
  const HostTime now = time_at(1.004);
  const Frame frame = loop.begin_frame(now);

  const FramePlan expected = *plan_frame({hmd.timing, ms(2), ms(1), 2}, time_at(1.0), now);
  CHECK(frame.id == 1);
  CHECK(frame.plan.measured == expected.measured);
  CHECK(frame.plan.render_start == expected.render_start);
  CHECK(frame.plan.scan_out_start == expected.scan_out_start);
  CHECK(frame.t() == expected.middle_of_scan_out);
  CHECK(frame.plan.wait == expected.wait);
  CHECK(frame.deadline == expected.scan_out_start - ms(1.5));
  CHECK(frame.refresh == frame_period(hmd.timing));
  CHECK(frame.issues.none());
  const PredictionResult head = predict_constant_velocity(*latest.newest(), frame.t());
  CHECK(frame.head.X_WB.matrix() == head.X_WB.matrix());
  CHECK(frame.head.covariance == head.covariance);
  for (const EyeSide side : {EyeSide::left, EyeSide::right}) {
    const EyeView& eye = frame.eye(side);
    CHECK(eye.side == side);
    CHECK(eye.t == frame.t());
    CHECK(eye.X_WE.matrix() == (head.X_WB * hmd.eye(side).X_HE).matrix());
    CHECK(eye.view == eye.X_WE.inverse().matrix());
    CHECK(eye.projection == projection_matrix(eye.tangents, settings.clip.planes));
    const RenderedView view = eye.rendered_view();
    CHECK(view.X_WS.matrix() == eye.X_WE.matrix());
    CHECK(view.tangents == eye.tangents);
    CHECK(view.size == eye.viewport);
    CHECK(view.t == frame.t());
  }
  CHECK(loop.begin_frame(now).id == 2);
}

TEST_CASE("a head at rest: late matrices are the identity to the last bit") {
  LatestPose latest;
  const LatestPoseSource source(latest);
  for (const DeflectionKind kind : deflection_kinds) {
    FrameLoopSettings settings;
    settings.deflection.kind = kind;
    FrameLoop loop(rolling_hmd(), source, settings);
    for (int i = 0; i < 20; ++i) {
      PoseEstimate still = steady_head(1.0, Vector3::Zero(), Vector3::Zero());
      still.X_WB = Rigid(so3::exp<double>(Vector3(0.1 * i, 0.3 - 0.2 * i, 0.05 * i)), Vector3(3.0 * i, 1.7, -0.1));
      still.t = latest.newest() ? latest.newest()->t + ms(1) : time_at(1.0);
      latest.publish(still);
      const Run run = run_frame(loop, still.t + ms(3), still.t + ms(8), still.t + ms(12));
      CHECK(run.latch.turned.radians() == 0.0);
      CHECK(run.latch.moved_m == 0.0);
      for (const EyeDeflection& eye : run.deflection.eyes) {
        CHECK(eye.deflection.H_SE.matrices().is_identity());
        CHECK(eye.source.is_constant());
        CHECK(eye.lacking <= 0.0);
      }
      CHECK(run.deflection.turned.radians() == 0.0);
      CHECK(run.deflection.moved_m == 0.0);
      CHECK(run.deflection.issues.none());
    }
  }
}

TEST_CASE("a moving head on a global display: without newer measurement there is nothing to correct, to the last bit") {
  LatestPose latest;
  const LatestPoseSource source(latest);
  FrameLoop loop(default_hmd(), source);
  for (int i = 0; i < 20; ++i) {
    latest.publish(steady_head(1.0 + 0.1 * i, Vector3(0.1 * i, 2.0 - 0.3 * i, 0.7)));
    const HostTime now = latest.newest()->t + ms(2);
    const Run run = run_frame(loop, now, now + ms(4), now + ms(9));
    CHECK(run.latch.turned.radians() == 0.0);
    for (const EyeDeflection& eye : run.deflection.eyes) CHECK(eye.deflection.H_SE.matrices().is_identity());
    CHECK(run.deflection.issues.none());
  }
}

TEST_CASE("turning and moving the whole world changes nothing but the poses") {
  const Rigid X_VW(so3::exp<double>(Vector3(0.4, -2.0, 0.9)), Vector3(3.0, -1.0, 7.0));
  LatestPose latest_W, latest_V;
  const LatestPoseSource source_W(latest_W), source_V(latest_V);
  FrameLoop loop_W(rolling_hmd(), source_W), loop_V(rolling_hmd(), source_V);
  const auto publish = [&](double t, const Vector3& w) {
    const PoseEstimate in_W = steady_head(t, w);
    PoseEstimate in_V = in_W;
    in_V.X_WB = X_VW * in_W.X_WB;
    in_V.velocity->v_WB = X_VW.q() * in_W.velocity->v_WB;  // w_WB_B is in B: it stays
    latest_W.publish(in_W);
    latest_V.publish(in_V);
  };
  publish(1.000, Vector3(0.3, 1.7, -0.2));
  Frame frame_W = loop_W.begin_frame(time_at(1.002)), frame_V = loop_V.begin_frame(time_at(1.002));
  publish(1.005, Vector3(-0.2, 1.2, 0.3));
  const LateLatch latch_W = loop_W.late_latch(frame_W, time_at(1.006));
  const LateLatch latch_V = loop_V.late_latch(frame_V, time_at(1.006));
  publish(1.010, Vector3(0.1, 1.5, 0.1));
  const FrameDeflection late_W = loop_W.deflect(frame_W.rendered_views(), time_at(1.012));
  const FrameDeflection late_V = loop_V.deflect(frame_V.rendered_views(), time_at(1.012));
  // Rounding of poses 8 m from the origin.
  constexpr double rounding = 2e-14;
  CHECK(std::abs((latch_W.turned - latch_V.turned).radians()) < rounding);
  CHECK(latch_W.turned.radians() > 1e-3);
  CHECK(std::abs(latch_W.moved_m - latch_V.moved_m) < rounding);
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(worst_difference(X_VW * frame_W.eyes[i].X_WE, frame_V.eyes[i].X_WE) < rounding);
    const ScanMatrices& H_W = late_W.eyes[i].deflection.H_SE.matrices();
    const ScanMatrices& H_V = late_V.eyes[i].deflection.H_SE.matrices();
    CHECK(worst_difference(H_W.begin, H_V.begin) < rounding);
    CHECK(worst_difference(H_W.middle, H_V.middle) < rounding);
    CHECK(worst_difference(H_W.end, H_V.end) < rounding);
    CHECK(worst_difference(H_W.middle, Matrix3::Identity()) > 1e-4);
    CHECK(std::abs(late_W.eyes[i].lacking - late_V.eyes[i].lacking) < rounding);
  }
  CHECK(late_W.issues == late_V.issues);
}

TEST_CASE("left and right mirror: a mirrored head gives the other eye's views and matrices") {
  HmdModel hmd = rolling_hmd();
  hmd.left.X_HE = eye_pose(EyeSide::left, 0.064, degrees(5.0), degrees(2.0));
  hmd.left.tangents = {-0.9, 0.6, -0.7, 0.5};
  hmd.right = mirrored(hmd.left);
  const auto mirror = [](const PoseEstimate& e) {  // x -> -x in W and in H
    PoseEstimate m = e;
    const Quaternion& q = e.X_WB.q();
    const Vector3 flip(-1.0, 1.0, 1.0);
    m.X_WB = Rigid(Quaternion(q.w(), q.x(), -q.y(), -q.z()), flip.cwiseProduct(e.X_WB.p()));
    m.velocity->v_WB = flip.cwiseProduct(e.velocity->v_WB);
    m.velocity->w_WB_B = -flip.cwiseProduct(e.velocity->w_WB_B);  // an axial vector
    return m;
  };
  LatestPose latest, latest_mirrored;
  const LatestPoseSource source(latest), source_mirrored(latest_mirrored);
  FrameLoop loop(hmd, source), loop_mirrored(hmd, source_mirrored);
  const auto publish = [&](const PoseEstimate& e) {
    latest.publish(e);
    latest_mirrored.publish(mirror(e));
  };
  publish(steady_head(1.0));
  const Frame a = loop.begin_frame(time_at(1.001)), b = loop_mirrored.begin_frame(time_at(1.001));
  publish(steady_head(1.01, Vector3(1.0, -0.5, 0.4)));
  const FrameDeflection late_a = loop.deflect(a.rendered_views(), time_at(1.012));
  const FrameDeflection late_b = loop_mirrored.deflect(b.rendered_views(), time_at(1.012));
  const Matrix3 F = Vector3(-1.0, 1.0, 1.0).asDiagonal();
  for (std::size_t i = 0; i < 2; ++i) {
    const EyeView &left = a.eyes[i], &right = b.eyes[1 - i];
    CHECK(left.tangents == mirrored(right.tangents));
    CHECK(left.viewport == right.viewport);
    const ScanMatrices& H_left = late_a.eyes[i].deflection.H_SE.matrices();
    const ScanMatrices& H_right = late_b.eyes[1 - i].deflection.H_SE.matrices();
    const Matrix3 begin = F * H_right.begin * F, end = F * H_right.end * F;
    CHECK(worst_difference(H_left.begin, begin) < 1e-15);
    CHECK(worst_difference(H_left.end, end) < 1e-15);
  }
}

TEST_CASE("late latch replaces the views by the newest pose's and says how far they moved") {
  LatestPose latest;
  const LatestPoseSource source(latest);
  FrameLoop loop(rolling_hmd(), source);
  latest.publish(steady_head(1.0, Vector3(0, 1.7, 0), Vector3(0.4, 0, 0)));
  Frame frame = loop.begin_frame(time_at(1.001));
  // The head slows down: 10 ms later it turns at 0.7 rad/s. Predicted over T from then, it is 1.0 rad/s * T behind.
  latest.publish([] {
    PoseEstimate e = steady_head(1.01, Vector3(0, 1.7, 0), Vector3(0.4, 0, 0));
    e.velocity->w_WB_B = Vector3(0, 0.7, 0);
    e.velocity->v_WB = Vector3(0.4, 0.3, 0);
    return e;
  }());
  const Frame before = frame;
  const LateLatch latch = loop.late_latch(frame, time_at(1.0105));
  const double T = to_seconds(frame.t() - time_at(1.01));
  CHECK(latch.issues.none());
  CHECK(latch.fresher == ms(10));
  CHECK(latch.turned.radians() == doctest::Approx(1.0 * T).epsilon(1e-12));
  CHECK(latch.moved_m == doctest::Approx(0.3 * T).epsilon(1e-12));
  CHECK(frame.when_latched == time_at(1.0105));
  CHECK(frame.measured_for_latch == time_at(1.01));
  CHECK(frame.t() == before.t());
  const Rigid X_WH = predict_constant_velocity(*latest.newest(), frame.t()).X_WB;
  for (const EyeSide side : {EyeSide::left, EyeSide::right}) {
    CHECK(frame.eye(side).X_WE.matrix() == (X_WH * loop.eye_model(side).X_HE).matrix());
    CHECK(frame.eye(side).tangents == before.eye(side).tangents);
    CHECK(frame.eye(side).projection == before.eye(side).projection);
  }

  // A head that goes on as predicted moves nothing.
  latest.publish(steady_head(2.0));
  Frame steady = loop.begin_frame(time_at(2.001));
  latest.publish(steady_head(2.008));
  const LateLatch nothing = loop.late_latch(steady, time_at(2.009));
  CHECK(nothing.turned.radians() < 1e-14);
  CHECK(nothing.moved_m < 1e-14);
  CHECK(nothing.fresher == ms(8));
}

TEST_CASE("how much fresher a latch is: nothing after a frame without measurement, bounded for made-up times") {
  struct Fixed : PoseSource {
    std::optional<PoseEstimate> estimate;
    [[nodiscard]] std::optional<PoseEstimate> newest(HostTime) const override { return estimate; }
    [[nodiscard]] PredictionResult predict(const PoseEstimate& from, HostTime t) const override {
      return predict_none(from, t);
    }
  } source;
  FrameLoop loop(rolling_hmd(), source);
  Frame frame = loop.begin_frame(time_at(1.0));
  CHECK_FALSE(frame.has_measurement);
  CHECK(frame_log(frame, nullptr, nullptr).when_measured == HostTime{});
  source.estimate = steady_head(0.9);
  CHECK(loop.late_latch(frame, time_at(1.001)).fresher == Duration{0});
  frame = loop.begin_frame(time_at(1.0));
  CHECK(frame.has_measurement);
  source.estimate->t = time_at(0.95);
  CHECK(loop.late_latch(frame, time_at(1.001)).fresher == ms(50));
  source.estimate->t = time_at(0.85);  // the tracker's clock was set back
  CHECK(loop.late_latch(frame, time_at(1.001)).fresher == ms(-50));

  constexpr double years_100 = 100.0 * 365.25 * 86400.0;
  source.estimate->t = HostTime::max();
  CHECK(to_seconds(loop.late_latch(frame, time_at(1.001)).fresher) == doctest::Approx(years_100));
  frame = loop.begin_frame(time_at(1.0));
  source.estimate->t = HostTime::min();
  CHECK(to_seconds(loop.late_latch(frame, time_at(1.001)).fresher) == doctest::Approx(-years_100));
}

TEST_CASE("deflection predicts to the light of the first, middle and last line, in every scan direction") {
  for (const ScanDirection direction : scan_directions) {
    const HmdModel hmd = rolling_hmd(direction);
    LatestPose latest;
    const LatestPoseSource source(latest);
    FrameLoop loop(hmd, source);
    latest.publish(steady_head(1.0));
    const Frame frame = loop.begin_frame(time_at(1.001));
    const FrameDeflection late = loop.deflect(frame.rendered_views(), frame.deadline - ms(3));
    CHECK(late.scan_out_start == frame.plan.scan_out_start);
    CHECK(late.scan_middle == frame.t());
    // Half a nanosecond of rounding at each end.
    CHECK(std::abs((late.scan_end - late.scan_begin - ms(11.1)).count()) <= 1);
    CHECK(std::abs((late.scan_begin + ms(5.55) - late.scan_middle).count()) <= 1);
    const PoseEstimate e = *latest.newest();
    CHECK(late.head_begin.X_WB.matrix() == predict_constant_velocity(e, late.scan_begin).X_WB.matrix());
    CHECK(late.head_middle.X_WB.matrix() == predict_constant_velocity(e, late.scan_middle).X_WB.matrix());
    CHECK(late.head_end.X_WB.matrix() == predict_constant_velocity(e, late.scan_end).X_WB.matrix());
    for (const EyeSide side : {EyeSide::left, EyeSide::right}) {
      const EyeDeflection& eye = late.eye(side);
      CHECK(eye.late.X_WE_begin.matrix() == (late.head_begin.X_WB * hmd.eye(side).X_HE).matrix());
      CHECK(eye.late.X_WE_middle->matrix() == (late.head_middle.X_WB * hmd.eye(side).X_HE).matrix());
      CHECK(eye.late.X_WE_end.matrix() == (late.head_end.X_WB * hmd.eye(side).X_HE).matrix());
      const DeflectionResult expected = deflect(DeflectionSettings{}, frame.eye(side).rendered_view(), eye.late);
      CHECK(eye.deflection.H_SE.matrices() == expected.H_SE.matrices());
      CHECK(eye.source == source_matrices(frame.eye(side).rendered_view(), expected.H_SE));
    }
    CHECK(late.issues.none());
  }
}

TEST_CASE("a head that only turns, known exactly: after deflection every point is where it belongs") {
  // Canted eyes, and a source that knows the truth. The eyes themselves move, so things stand 1000 km away.
  HmdModel hmd = rolling_hmd();
  hmd.left.X_HE = eye_pose(EyeSide::left, 0.064, degrees(8.0));
  hmd.right = mirrored(hmd.left);
  // What a rolling display leaves: the third order of the sine through three poses, 0.008 (0.14 rad)^3 3 deg, times
  // 1109 px and 1 + tan^2 of 38 degrees at the canted eye's edge.
  double most_px = 0.003;
  SUBCASE("global") {
    hmd.timing.scan_out = ScanOut::global;
    most_px = 1e-4;  // 3 mm of eye movement at 1000 km are 3e-6 px; rounding of positions there 2e-10 m
  }
  SUBCASE("rows") {}
  SUBCASE("columns") {
    hmd.timing.scan_direction = ScanDirection::left_to_right;
  }
  SUBCASE("upside down") {
    hmd.left.upside_down = hmd.right.upside_down = true;
  }
  const auto motion = make_yaw_sine(2.0, degrees(3.0), std::chrono::seconds(2));
  const auto truth = prophet(*motion);
  // Drawn for a pose that is 60 ms old.
  const RuntimePoseSource stale(
      [&](HostTime t) { return std::optional<PoseEstimate>(exact_estimate(*motion, t - ms(60))); });
  for (const LensMode lens : {LensMode::none, LensMode::exact}) {
    FrameLoopSettings settings;
    settings.lens = lens;
    settings.budget = {degrees(4.0), degrees(1.0), degrees(1.0)};
    FrameLoop drawing(hmd, stale, settings), showing(hmd, truth, settings);
    double worst_px = 0.0, worst_undeflected_px = 0.0;
    int compared = 0;
    for (int i = 0; i < 40; ++i) {
      const HostTime now = time_at(0.5 + 0.025 * i);
      const Frame frame = drawing.begin_frame(now);
      const FrameDeflection late = showing.deflect(frame.rendered_views(), frame.deadline - ms(3));
      CHECK(late.issues.none());
      for (const EyeSide side : {EyeSide::left, EyeSide::right}) {
        const EyeModel& eye = hmd.eye(side);
        const RenderedView view = frame.eye(side).rendered_view();
        const ComposedWarp warp(eye, lens, hmd.timing, view, late.eye(side).deflection.H_SE);
        for (const double x : {-0.4, 0.0, 0.4}) {
          for (const double y : {-0.25, 0.1, 0.25}) {
            const Vector3 far_W = 1e6 * Vector3(x, y, -1.0);
            const auto t_S = tangents_of_point(Vector3(view.X_WS.inverse() * far_W));
            const auto seen = warp.seen_pixel(source_pixel_of_tangent(view, *t_S));
            if (!seen || !is_inside(eye, *seen)) continue;
            // The line on which it is seen tells when, and so where the eye was then.
            const double s = warp.line_fraction(*warp.panel_pixel_seen(*seen));
            const HostTime t = late.scan_middle + line_time_from_middle(hmd.timing, s);
            const auto expected = project(eye, (motion->at(t).X_WB * eye.X_HE).inverse() * far_W);
            worst_px = std::max(worst_px, (*seen - *expected).norm());
            const auto drawn = project(eye, view.X_WS.inverse() * far_W);
            worst_undeflected_px = std::max(worst_undeflected_px, (*drawn - *expected).norm());
            ++compared;
          }
        }
      }
    }
    CAPTURE(static_cast<int>(lens));
    MESSAGE("worst after deflection ", worst_px, " px");
    CHECK(compared > 400);
    CHECK(worst_px < most_px);
    CHECK(worst_undeflected_px > 20.0);
  }
}

TEST_CASE("each stage can be switched off alone") {
  LatestPose latest;
  const LatestPoseSource source(latest);
  FrameLoop loop(rolling_hmd(), source);
  latest.publish(steady_head(1.0));
  const auto run_all = [&] {
    Run run;
    run.frame = loop.begin_frame(time_at(1.001));
    run.latch = loop.late_latch(run.frame, time_at(1.002));
    run.deflection = loop.deflect(run.frame.rendered_views(), time_at(1.004));
    return run;
  };
  const Rigid X_WH = latest.newest()->X_WB;

  SUBCASE("prediction") {
    loop.stages.prediction = false;
    const Run run = run_all();
    CHECK(run.frame.head.X_WB.matrix() == X_WH.matrix());
    CHECK(run.deflection.head_begin.X_WB.matrix() == X_WH.matrix());
    CHECK(run.deflection.eyes[0].deflection.H_SE.matrices().is_identity());
    CHECK(run.frame.issues.none());
  }
  SUBCASE("late latch") {
    loop.stages.late_latch = false;
    Frame frame = loop.begin_frame(time_at(1.001));
    const Frame before = frame;
    latest.publish(steady_head(1.005, Vector3(0, -1, 0)));
    const LateLatch latch = loop.late_latch(frame, time_at(1.006));
    CHECK(latch.turned.radians() == 0.0);
    CHECK(latch.issues.none());
    CHECK(frame.when_latched == HostTime{});
    CHECK(frame.eyes[0].view == before.eyes[0].view);
    CHECK(frame.eyes[1].view == before.eyes[1].view);
  }
  SUBCASE("deflection") {
    loop.stages.deflection = false;
    const Run run = run_all();
    for (const EyeDeflection& eye : run.deflection.eyes) CHECK(eye.deflection.H_SE.matrices().is_identity());
    CHECK(run.deflection.turned.radians() < 1e-14);  // latched from the same measurement, and steady
  }
  SUBCASE("per scanline") {
    const Run with = run_all();
    loop.stages.per_scanline = false;
    const Run without = run_all();
    for (std::size_t i = 0; i < 2; ++i) {
      CHECK_FALSE(with.deflection.eyes[i].deflection.H_SE.is_constant());
      CHECK(without.deflection.eyes[i].deflection.H_SE.is_constant());
      CHECK(worst_difference(with.deflection.eyes[i].deflection.H_SE.middle(),
                             without.deflection.eyes[i].deflection.H_SE.middle()) < 1e-15);
    }
  }
  SUBCASE("lens") {
    CHECK(loop.lens_mode() == LensMode::exact);
    const FieldTangents field = loop.picture(EyeSide::left).tangents;
    loop.stages.lens = false;
    CHECK(loop.lens_mode() == LensMode::uncorrected);
    CHECK(loop.picture(EyeSide::left).tangents == field);
    // What the panel shows without correction is judged, not what it would show with it.
    const Run run = run_all();
    for (const EyeSide side : {EyeSide::left, EyeSide::right}) {
      const FieldOutline shown(loop.eye_model(side), LensMode::uncorrected, loop.display_timing());
      const FieldOutline corrected(loop.eye_model(side), LensMode::exact, loop.display_timing());
      const ScanHomography& H_SE = run.deflection.eye(side).deflection.H_SE;
      CHECK(run.deflection.eye(side).lacking == shown.lacking(loop.picture(side).tangents, H_SE));
      CHECK(run.deflection.eye(side).lacking < corrected.lacking(loop.picture(side).tangents, H_SE) - 1e-3);
    }
  }
  const Run all_on = [&] {
    loop.stages = {};
    return run_all();
  }();
  CHECK_FALSE(all_on.frame.head.X_WB.matrix() == X_WH.matrix());
}

TEST_CASE("what a frame had to make do with is told") {
  const HmdModel hmd = rolling_hmd();
  LatestPose latest;
  const LatestPoseSource source(latest);
  FrameLoop loop(hmd, source);

  SUBCASE("no pose yet") {
    const Run run = run_frame(loop, time_at(1.0), time_at(1.001), time_at(1.002));
    CHECK(run.frame.issues.has(FrameIssue::no_pose));
    CHECK(run.latch.issues.has(FrameIssue::no_pose));
    CHECK(run.deflection.issues.has(FrameIssue::no_pose));
    CHECK(run.frame.head.status != PredictionStatus::ok);
    CHECK(run.frame.eyes[0].X_WE.matrix() == hmd.left.X_HE.matrix());
    CHECK(run.deflection.eyes[0].deflection.H_SE.matrices().is_identity());
    CHECK(run.frame.plan.measured == run.frame.plan.now);
  }
  SUBCASE("no velocity") {
    PoseEstimate e = steady_head(1.0);
    e.velocity.reset();
    latest.publish(e);
    const Run run = run_frame(loop, time_at(1.001), time_at(1.002), time_at(1.003));
    CHECK(run.frame.issues.has(FrameIssue::no_velocity));
    CHECK(run.latch.issues.has(FrameIssue::no_velocity));
    CHECK(run.deflection.issues.has(FrameIssue::no_velocity));
  }
  SUBCASE("a tracker that has stopped") {
    latest.publish(steady_head(1.0));
    const Run run = run_frame(loop, time_at(2.001), time_at(2.002), time_at(2.003));
    CHECK(run.frame.issues.has(FrameIssue::clamped));
    CHECK(run.latch.issues.has(FrameIssue::clamped));
    CHECK(run.deflection.issues.has(FrameIssue::clamped));
    for (const FrameIssues& issues : {run.frame.issues, run.latch.issues, run.deflection.issues}) {
      CHECK(issues.has(FrameIssue::stale));
    }
    // Also when nothing is predicted, so that nothing can be clamped.
    loop.stages.prediction = false;
    const FrameIssues unpredicted = loop.begin_frame(time_at(2.001)).issues;
    CHECK(unpredicted.has(FrameIssue::stale));
    CHECK_FALSE(unpredicted.has(FrameIssue::clamped));
    CHECK_FALSE(loop.begin_frame(time_at(1.099)).issues.has(FrameIssue::stale));
  }
  SUBCASE("clocks mixed") {
    latest.publish(steady_head(1000.0));
    const Run run = run_frame(loop, time_at(1.001), time_at(1.002), time_at(1.003));
    for (const FrameIssues& issues : {run.frame.issues, run.latch.issues, run.deflection.issues}) {
      CHECK(issues.has(FrameIssue::clocks_mixed));
      CHECK(issues.has(FrameIssue::backwards));
    }
    CHECK(run.frame.plan.scan_out_start > time_at(1.001));
    CHECK(run.frame.plan.scan_out_start < time_at(1.1));
  }
  SUBCASE("not finite") {
    const RuntimePoseSource broken([](HostTime) {
      PoseEstimate e;
      e.X_WB = Rigid::translation(Vector3::Constant(std::numeric_limits<double>::quiet_NaN()));
      return std::optional<PoseEstimate>(e);
    });
    FrameLoop bad(hmd, broken);
    const Run run = run_frame(bad, time_at(1.001), time_at(1.002), time_at(1.003));
    CHECK(run.frame.issues.has(FrameIssue::not_finite));
    CHECK(run.deflection.issues.has(FrameIssue::not_finite));
    CHECK(run.frame.eyes[0].view.allFinite());
    CHECK(run.deflection.eyes[0].source.begin.allFinite());
  }
  SUBCASE("not finite after a good one") {
    bool good = true;
    const RuntimePoseSource failing([&](HostTime) {
      PoseEstimate e = steady_head(1.0, Vector3::Zero());
      if (!good) e.X_WB = Rigid::translation(Vector3::Constant(std::numeric_limits<double>::quiet_NaN()));
      return std::optional<PoseEstimate>(e);
    });
    FrameLoop bad(hmd, failing);
    Frame frame = bad.begin_frame(time_at(1.001));
    const Matrix4 view = frame.eyes[0].view;
    good = false;
    // Neither the latch nor the deflection throws a good picture to the world's origin, and the next frame stays near.
    CHECK(bad.late_latch(frame, time_at(1.002)).issues.has(FrameIssue::not_finite));
    CHECK(frame.eyes[0].view == view);
    const FrameDeflection late = bad.deflect(frame.rendered_views(), time_at(1.003));
    CHECK(late.issues.has(FrameIssue::not_finite));
    CHECK(late.eyes[0].deflection.H_SE.matrices().is_identity());
    CHECK(bad.begin_frame(time_at(1.012)).eyes[0].view == view);
  }
  SUBCASE("beyond the overfill, then beyond everything") {
    latest.publish(steady_head(1.0, Vector3::Zero()));
    const Frame frame = loop.begin_frame(time_at(1.001));
    const auto turned_by = [&](int n, Angle yaw) {
      PoseEstimate e = steady_head(1.001 + 0.001 * n, Vector3::Zero());
      e.X_WB = Rigid(so3::exp<double>(Vector3(0, yaw.radians(), 0)), e.X_WB.p());
      latest.publish(e);
      return loop.deflect(frame.rendered_views(), time_at(1.005));
    };
    const Angle budget = loop.settings().budget.yaw;
    const FrameDeflection within = turned_by(1, 0.99 * budget);
    CHECK(within.issues.none());
    CHECK(within.eyes[0].lacking < 0.0);
    const FrameDeflection beyond = turned_by(2, 3.0 * budget);
    CHECK(beyond.issues.has(FrameIssue::not_covered));
    CHECK(beyond.eyes[0].lacking > 0.0);
    const FrameDeflection away = turned_by(3, degrees(120.0));
    CHECK(away.issues.has(FrameIssue::deflection_refused));
    CHECK(away.eyes[0].deflection.problem == DeflectionProblem::turned_beyond_90);
    CHECK(away.eyes[0].deflection.H_SE.matrices().is_identity());
  }
  SUBCASE("a missed scan-out is planned anew") {
    latest.publish(steady_head(1.0));
    const Frame frame = loop.begin_frame(time_at(1.001));
    const FrameDeflection in_time = loop.deflect(frame.rendered_views(), frame.deadline);
    CHECK(in_time.scan_out_start == frame.plan.scan_out_start);
    CHECK_FALSE(in_time.issues.has(FrameIssue::missed_scan_out));
    const FrameDeflection late = loop.deflect(frame.rendered_views(), frame.deadline + Duration(1));
    CHECK(late.issues.has(FrameIssue::missed_scan_out));
    CHECK(late.scan_out_start - frame.plan.scan_out_start == frame.refresh);
    CHECK(late.scan_middle - frame.t() == frame.refresh);
    CHECK(late.head_end.t == late.scan_end);
    // Much too early is not too late.
    const FrameDeflection early = loop.deflect(frame.rendered_views(), frame.deadline - ms(40));
    CHECK(early.scan_out_start == frame.plan.scan_out_start);
  }
  SUBCASE("a picture drawn with a broken pose") {
    latest.publish(steady_head(1.0));
    std::array<RenderedView, 2> views = loop.begin_frame(time_at(1.001)).rendered_views();
    views[0].X_WS = Rigid::translation(Vector3::Constant(std::numeric_limits<double>::infinity()));
    const FrameDeflection late = loop.deflect(views, time_at(1.003));
    CHECK(late.issues.has(FrameIssue::deflection_refused));
    CHECK(late.eyes[0].deflection.problem == DeflectionProblem::view_not_finite);
    CHECK(late.eyes[1].deflection.ok());
    CHECK(late.eyes[0].source.begin.allFinite());
  }
}

TEST_CASE("vsyncs that are observed correct the headset's description") {
  HmdModel hmd = rolling_hmd();  // says 90 Hz from time zero
  LatestPose latest;
  latest.publish(steady_head(1.0));
  const LatestPoseSource source(latest);
  FrameLoop loop(hmd, source);
  DisplayTiming truth = hmd.timing;
  truth.refresh_hz = 89.95;
  truth.first_vsync = HostTime(from_milliseconds(4.2));
  std::mt19937 random(3);  // wake-ups late by 0 to 0.3 ms
  constexpr int observed = 1800;
  for (int i = 0; i < observed; ++i) loop.observe_vsync(vsync_at(truth, i) + Duration(random() % 300000));
  const HostTime now = vsync_at(truth, observed) + ms(1);
  const Frame frame = loop.begin_frame(now);
  CHECK(loop.display_timing().refresh_hz == doctest::Approx(89.95).epsilon(1e-5));
  // What is left of 0.3 ms (timing/vsync_estimator.hpp); the description alone would err by 4.2 ms and 0.05 Hz.
  CHECK(std::abs((frame.plan.scan_out_start - vsync_at(truth, observed + 2)).count()) < 30'000);
  const FrameDeflection late = loop.deflect(frame.rendered_views(), frame.deadline - ms(2));
  CHECK(late.scan_out_start == frame.plan.scan_out_start);
}

TEST_CASE("impossible headsets and settings are refused by name") {
  const HmdModel good = rolling_hmd();
  const FrameLoopSettings settings;
  CHECK_FALSE(problem_of(good, settings).has_value());
  const auto member = [&](const auto& spoil) {
    HmdModel hmd = good;
    FrameLoopSettings s;
    spoil(hmd, s);
    const auto problem = problem_of(hmd, s);
    return problem ? std::string(problem->member) : std::string("none");
  };
  CHECK(member([](auto& hmd, auto&) { hmd.timing.refresh_hz = 0.0; }) == "refresh_hz");
  CHECK(member([](auto& hmd, auto&) { hmd.left.resolution.width = 0; }) == "eye.resolution");
  CHECK(member([](auto& hmd, auto&) { hmd.right.tangents.left = hmd.right.tangents.right; }) == "eye.tangents");
  CHECK(member([](auto&, auto& s) { s.compute_time = Duration(-1); }) == "compute_time");
  CHECK(member([](auto&, auto& s) { s.render_start_phase = std::chrono::seconds(2); }) == "render_start_phase");
  CHECK(member([](auto&, auto& s) { s.warp_time = Duration(-1); }) == "warp_time");
  CHECK(member([](auto&, auto& s) { s.clock_tolerance = Duration(-1); }) == "clock_tolerance");
  CHECK(member([](auto&, auto& s) { s.stale_after = Duration(-1); }) == "stale_after");
  CHECK(member([](auto&, auto& s) { s.scan_out_refreshes = 0; }) == "scan_out_refreshes");
  CHECK(member([](auto&, auto& s) { s.budget.yaw = degrees(-1.0); }) == "budget");
  CHECK(member([](auto&, auto& s) { s.budget.pitch = degrees(80.0); }) == "budget");
  CHECK(member([](auto&, auto& s) { s.clip.planes.near_m = 0.0; }) == "clip.planes");
  CHECK(member([](auto&, auto& s) {
          s.deflection.kind = DeflectionKind::plane;
          s.deflection.plane_distance_m = 0.0;
        }) == "deflection.plane_distance_m");
}

TEST_CASE("the frame's record has every stage's times, by Monado's names") {
  LatestPose latest;
  const LatestPoseSource source(latest);
  FrameLoop loop(rolling_hmd(), source);
  latest.publish(steady_head(1.0));
  Frame frame = loop.begin_frame(time_at(1.001));
  latest.publish(with_turn(steady_head(1.004), Vector3(0.3, 1.6, -0.1)));
  const LateLatch latch = loop.late_latch(frame, time_at(1.005));
  latest.publish(with_turn(steady_head(1.008), Vector3(0.4, 1.5, -0.2)));
  const FrameDeflection late = loop.deflect(frame.rendered_views(), time_at(1.009));
  const FrameLog log = frame_log(frame, &latch, &late);
  std::vector<std::pair<std::string, double>> fields;
  log.for_each_field([&](std::string_view name, auto value) { fields.emplace_back(name, static_cast<double>(value)); });
  const auto field = [&](std::string_view name) {
    for (const auto& [key, value] : fields) {
      if (key == name) return value;
    }
    FAIL("no field " << name);
    return 0.0;
  };
  CHECK(field("frame_id") == 1.0);
  CHECK(field("when_predicted_ns") == 1.001e9);
  CHECK(field("when_measured_ns") == 1.0e9);
  CHECK(field("when_latched_ns") == 1.005e9);
  CHECK(field("when_measured_for_latch_ns") == 1.004e9);
  CHECK(field("when_delivered_ns") == 1.009e9);
  CHECK(field("when_measured_for_deflection_ns") == 1.008e9);
  CHECK(field("predicted_display_time_ns") == static_cast<double>(frame.t().time_since_epoch().count()));
  CHECK(field("display_time_ns") == field("predicted_display_time_ns"));
  CHECK(field("predicted_display_period_ns") == 11111111.0);
  CHECK(field("predicted_wake_up_time_ns") < field("predicted_gpu_done_time_ns"));
  CHECK(field("predicted_gpu_done_time_ns") < field("predicted_display_time_ns"));
  CHECK(field("latch_turned_deg") == doctest::Approx(latch.turned.degrees()));
  CHECK(field("deflection_turned_deg") == doctest::Approx(late.turned.degrees()));
  CHECK(field("issues") == 0.0);
  const FrameLog unfinished = frame_log(frame, nullptr, nullptr);
  CHECK(unfinished.display_time == HostTime{});
  CHECK(unfinished.when_predicted == time_at(1.001));
}

TEST_CASE("a tracker's thread publishes while a render thread runs frames") {
  const auto latest = std::make_unique<LatestPose>();
  const LatestPoseSource source(*latest);
  latest->publish(steady_head(1.0));
  std::atomic<bool> stop{false};
  std::thread tracker([&] {
    for (int i = 1; !stop; ++i) {
      latest->publish(steady_head(1.0 + 1e-6 * i));
      if (i % 32 == 0) std::this_thread::yield();
    }
  });
  FrameLoop loop(rolling_hmd(), source);
  int issues = 0;
  for (int i = 0; i < 300; ++i) {
    const HostTime now = latest->newest()->t + ms(5);
    const Run run = run_frame(loop, now, now + ms(1), now + ms(2));
    if (!run.frame.head.X_WB.is_finite() || !run.deflection.eyes[1].source.end.allFinite()) ++issues;
    FrameIssues all = run.frame.issues;
    all.add(run.latch.issues);
    all.add(run.deflection.issues);
    // The simulated tracker runs ahead of this thread's simulated time: only its clock may be told of.
    for (const FrameIssue issue : frame_issues) {
      if (issue != FrameIssue::clocks_mixed && issue != FrameIssue::backwards && all.has(issue)) ++issues;
    }
  }
  stop = true;
  tracker.join();
  CHECK(issues == 0);
}
