// A frame allocates nothing, on any thread's path: counted by replacing the global operator new of this test program,
// and forbidden to Eigen itself.
#include <cstddef>
#include <vector>

#include <doctest/doctest.h>

#include "allocation_counter.hpp"
#include "pipeline/pipeline_heads.hpp"

using namespace holdfast;
using namespace holdfast::test;

TEST_CASE("publishing, reading and every stage of a frame allocate nothing, whatever the kind and the issues") {
  LatestPose latest;
  const LatestPoseSource source(latest);
  HmdModel hmd = rolling_hmd();
  hmd.left.lens_red = RadialLens{0.18};
  std::vector<FrameLoop> loops;
  loops.reserve(deflection_kinds.size());
  for (const DeflectionKind kind : deflection_kinds) {
    FrameLoopSettings settings;
    settings.deflection.kind = kind;
    loops.emplace_back(hmd, source, settings);
  }
  double sum = 0.0;
  std::size_t issues = 0;
  const auto some_frames = [&](FrameLoop& loop, double t) {
    for (int i = 0; i < 20; ++i) {
      const HostTime now = time_at(t + 0.011 * i);
      loop.observe_vsync(vsync_at(hmd.timing, next_vsync_number(hmd.timing, now) - 1));
      Frame frame = loop.begin_frame(now + from_milliseconds(1));
      latest.publish(steady_head(t + 0.011 * i));
      const LateLatch latch = loop.late_latch(frame, now + from_milliseconds(3));
      const FrameDeflection late = loop.deflect(frame.rendered_views(), now + from_milliseconds(i < 10 ? 5 : 30));
      const FrameLog log = frame_log(frame, &latch, &late);
      log.for_each_field([&](std::string_view, auto value) { sum += static_cast<double>(value); });
      issues += log.issues.none() ? 0 : 1;
      sum += late.eyes[0].source.middle.sum() + frame.eyes[1].projection.sum() + latest.newest()->covariance.sum();
    }
  };

#ifdef EIGEN_RUNTIME_NO_MALLOC
  Eigen::internal::set_is_malloc_allowed(false);
#endif
  const std::size_t before = test::allocations();
  double t = 1.0;
  for (FrameLoop& loop : loops) some_frames(loop, t += 1.0);
  const std::size_t after = test::allocations();
#ifdef EIGEN_RUNTIME_NO_MALLOC
  Eigen::internal::set_is_malloc_allowed(true);
#endif
  CHECK(after == before);
  CHECK(std::isfinite(sum));
  CHECK(issues > 0);  // the way of what goes wrong was tried as well
  CHECK(test::counts_allocations());
}
