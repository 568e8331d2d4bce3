// The code of docs/pipeline.md, as it stands there.
#include <array>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>

#include <doctest/doctest.h>

#include <holdfast/pipeline/pipeline.hpp>

using namespace holdfast;

namespace {

struct Engine {
  int drawn = 0, warped = 0, logged = 0;
  void simulate(HostTime) {}
  void draw(const Matrix4&, const Matrix4&, PixelSize size) { drawn += size.width > 0 ? 1 : 0; }
  [[nodiscard]] int texture(int number) const { return number; }
  void warp(const SourceMatrices& l, const SourceMatrices& r) { warped += l.is_identity() || r.is_identity() ? 0 : 1; }
  void log(const FrameIssues&) { ++logged; }
};

}  // namespace

TEST_CASE("the page's first example") {
  const HmdModel hmd = default_hmd();
  const FrameLoopSettings settings;
  Engine engine;
  HostTime time = time_at(1.0);
  const auto now = [&] { return time += std::chrono::milliseconds(1); };

  LatestPose latest;                // the tracker's thread: latest.publish(estimate, now())
  LatestPoseSource source(latest);  // the newest pose, carried on at constant velocity
  FrameLoop loop(hmd, source, settings);
  PoseEstimate estimate;
  estimate.t = time;
  estimate.velocity = Twist{};
  CHECK(latest.publish(estimate, now()) == PublishResult::published);

  Frame frame = loop.begin_frame(now());  // when will these pixels glow, and where will the eyes be then?
  engine.simulate(frame.t());
  loop.late_latch(frame, now());  // last thing before the matrices are used: the newest pose replaces them
  for (const EyeView& eye : frame.eyes) engine.draw(eye.projection, eye.view, eye.viewport);

  RenderedPicture left(frame.eyes[0].rendered_view(), engine.texture(0));  // a picture keeps its view
  RenderedPicture right(frame.eyes[1].rendered_view(), engine.texture(1));
  FrameDeflection late = loop.deflect(left, right, now());  // where will the eyes be while the lines light?
  engine.warp(late.eyes[0].source, late.eyes[1].source);
  if (!late.issues.none()) engine.log(late.issues);

  CHECK(engine.drawn == 2);
  CHECK(engine.warped == 1);
  CHECK(engine.logged == 0);
}

TEST_CASE("the page's second example") {
  const auto locate_head = [](HostTime t) {
    PoseEstimate e;
    e.t = t;
    return e;
  };
  RuntimePoseSource source([&](HostTime t) -> std::optional<PoseEstimate> { return locate_head(t); });
  CHECK(source.newest(time_at(1.0)).has_value());
}

TEST_CASE("the page explains every issue") {
  std::ifstream file(HOLDFAST_SOURCE_DIR "/docs/pipeline.md");
  std::stringstream page;
  page << file.rdbuf();
  for (const FrameIssue issue : frame_issues) {
    CAPTURE(to_string(issue));
    CHECK(page.str().find("| `" + std::string(to_string(issue)) + "` |") != std::string::npos);
  }
}
