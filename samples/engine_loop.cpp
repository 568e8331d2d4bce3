// An engine's loop on Holdfast's pipeline, without a window: a tracker publishes poses; each frame is planned,
// predicted, latched late, drawn, and deflected just before its scan-out. Time is simulated, so that every run prints
// the same figures: swim and registration error with the stages switched on one after another, and with each switched
// off alone. The left eye of some frames is really drawn, warped and measured, to hold the figures against pictures.
//   sample_engine_loop [--motion M5] [--seconds 4] [--draw-every 120] [--log FILE] [--check]
//   sample_engine_loop --live SECONDS [--draw-every 0]
// --draw-every 0 draws nothing. --log writes a line of JSON per frame of the last row. --check: exit code 1 if a stage
// makes things worse, or a picture disagrees. --live: real clock and a tracker's thread; prints each frame's record.
// Exit code 2: wrong use, or no OpenGL to draw with.
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <type_traits>
#include <vector>

#include <holdfast/motion/generators.hpp>
#include <holdfast/pipeline/pipeline.hpp>
#include <holdfast/rendering/rendering.hpp>
#include <holdfast/tracking/backward_difference.hpp>

#include "engine_loop_observer.hpp"
#include "engine_loop_renderer.hpp"

using namespace holdfast;
using namespace engine_loop;
using std::chrono::microseconds;
using std::chrono::milliseconds;

namespace {

const RegistrationScene& scene() {
  static const RegistrationScene instance = default_registration_scene();
  return instance;
}

struct Options {
  std::string motion = "M5";
  double seconds = 4.0;
  int draw_every = 120;
  std::string log;
  bool check = false;
  double live_seconds = 0.0;
};

/// What an ideal tracker without gyro says: a pose, and the velocity from one 8 ms before.
PoseEstimate measure(const Motion& motion, HostTime t) {
  const HostTime before = t - milliseconds(8);
  return backward_difference({before, motion.at(before).X_WB}, {t, motion.at(t).X_WB});
}

/// Publishes a pose every millisecond, 2 ms after it was measured.
class SimulatedTracker {
 public:
  SimulatedTracker(const Motion& motion, LatestPose& latest) : motion_(&motion), latest_(&latest) {}

  void run_until(HostTime now) {
    for (; next_ + milliseconds(2) <= now; next_ += milliseconds(1)) latest_->publish(measure(*motion_, next_), now);
  }

 private:
  const Motion* motion_;
  LatestPose* latest_;
  HostTime next_ = time_at(0.1);
};

struct Row {
  std::string name;
  FrameStages stages;
  DeflectionKind kind = DeflectionKind::rotation;
};

/// The stages one after another, then all of them but one.
std::vector<Row> rows() {
  const FrameStages none{false, false, false, false, true};
  FrameStages predicted = none, latched = none, deflected = none;
  predicted.prediction = latched.prediction = deflected.prediction = true;
  latched.late_latch = deflected.late_latch = true;
  deflected.deflection = true;
  const FrameStages all;
  FrameStages no_prediction = all, no_latch = all, no_deflection = all, no_lens = all;
  no_prediction.prediction = no_latch.late_latch = no_deflection.deflection = no_lens.lens = false;
  return {{"none", none},
          {"prediction", predicted},
          {"+ late latch", latched},
          {"+ deflection", deflected},
          {"+ per scanline", all},
          {"+ depth", all, DeflectionKind::depth},
          {"all but prediction", no_prediction},
          {"all but late latch", no_latch},
          {"all but deflection", no_deflection},
          {"all but lens", no_lens}};
}

FrameLoopSettings settings_of(const Row& row) {
  FrameLoopSettings settings;
  settings.compute_time = milliseconds(2);
  settings.warp_time = milliseconds(1);
  settings.clip.planes = EyeRenderer::clip;
  settings.deflection.kind = row.kind;
  settings.budget = {degrees(6.0), degrees(6.0), degrees(3.0), 0.01, 0.4};
  settings.stages = row.stages;
  return settings;
}

struct Figures {
  double swim_deg_s = 0.0, registration_px = 0.0;
  int frames = 0, frames_with_issues = 0;
  PictureCheck pictures;
};

void write(std::FILE* file, const FrameLog& log) {
  const char* separator = "{";
  log.for_each_field([&](std::string_view name, auto value) {
    std::fprintf(file, "%s\"%.*s\":", separator, static_cast<int>(name.size()), name.data());
    if constexpr (std::is_integral_v<decltype(value)>)
      std::fprintf(file, "%lld", static_cast<long long>(value));
    else
      std::fprintf(file, "%.6g", value);
    separator = ",";
  });
  std::fputs("}\n", file);
}

/// A frame whose picture is finished and waits for its scan-out.
struct Finished {
  Frame frame;
  LateLatch latch;
  std::optional<Picture> left;  // when it was really drawn
};

Figures simulate(const Row& row, const HmdModel& hmd, const Motion& motion, const Options& options,
                 rendering::Context* context, std::FILE* log) {
  LatestPose latest;
  SimulatedTracker tracker(motion, latest);
  const LatestPoseSource source(latest, Predictor::constant_velocity);
  FrameLoop loop(hmd, source, settings_of(row));
  std::optional<EyeRenderer> renderer;
  if (context != nullptr) renderer.emplace(*context, scene(), hmd.left, loop.picture(EyeSide::left), loop.lens_mode());
  Observer observer(motion, scene());
  Figures figures;

  const auto deflect = [&](const Finished& finished, HostTime now) {
    tracker.run_until(now);
    const FrameDeflection late = loop.deflect(finished.frame.rendered_views(), now);
    ++figures.frames;
    const FrameLog record = frame_log(finished.frame, &finished.latch, &late);
    figures.frames_with_issues += record.issues.none() ? 0 : 1;
    if (log != nullptr) write(log, record);
    for (const EyeSide side : {EyeSide::left, EyeSide::right}) {
      const Shown shown{&hmd.eye(side),
                        loop.lens_mode(),
                        finished.frame.eye(side).rendered_view(),
                        &late.eye(side),
                        settings_of(row).deflection.kind,
                        late.scan_middle,
                        hmd.timing};
      observer.look(static_cast<std::size_t>(figures.frames), shown);
      if (!finished.left || side == EyeSide::right) continue;
      const io::Image seen = renderer->seen(*finished.left, late.eye(side), shown.kind, hmd.timing).read_rgba();
      figures.pictures.look(shown, renderer->picture_eye(), scene(), {seen.rgba, seen.width, seen.height, 4});
    }
  };

  std::optional<Finished> waiting;
  const std::int64_t first = next_vsync_number(hmd.timing, time_at(0.3));
  const auto count = static_cast<std::int64_t>(options.seconds * hmd.timing.refresh_hz);
  for (std::int64_t n = first; n < first + count; ++n) {
    const HostTime vsync = vsync_at(hmd.timing, n), next_vsync = vsync_at(hmd.timing, n + 1);
    loop.observe_vsync(vsync);
    // The next frame begins: when will it be seen, and from where?
    tracker.run_until(vsync + microseconds(500));
    Finished next;
    next.frame = loop.begin_frame(vsync + microseconds(500));
    // Meanwhile the frame before waits for its scan-out; 3 ms before it begins the finished picture is corrected.
    if (waiting) deflect(*waiting, next_vsync - milliseconds(3));
    // The matrices are submitted just before the renderer starts: the newest pose replaces them.
    tracker.run_until(next_vsync - microseconds(200));
    next.latch = loop.late_latch(next.frame, next_vsync - microseconds(200));
    const bool is_drawn = renderer && options.draw_every > 0 && (n - first) % options.draw_every == 0;
    if (is_drawn) next.left = renderer->draw(next.frame.eye(EyeSide::left), rendering::disc_measuring_style());
    waiting = next;
  }
  figures.swim_deg_s = observer.swim_deg_s();
  figures.registration_px = observer.registration_px();
  return figures;
}

/// The loop by the clock on the wall, with the tracker on a thread of its own; prints each frame's record. Drawn by the
/// processor, pictures miss their scan-outs, which the records tell; without context nothing is drawn, and none misses.
void run_live(const HmdModel& hmd, const Motion& motion, double seconds, rendering::Context* context) {
  const auto start = std::chrono::steady_clock::now();
  const auto now = [&] { return HostTime(std::chrono::steady_clock::now() - start); };
  LatestPose latest;
  std::atomic<bool> stop{false};
  std::thread tracker([&] {
    while (!stop) {
      latest.publish(measure(motion, now()), now());
      std::this_thread::sleep_for(milliseconds(1));
    }
  });
  const LatestPoseSource source(latest);
  const Row row{"live", {}, DeflectionKind::rotation};
  FrameLoop loop(hmd, source, settings_of(row));
  std::vector<EyeRenderer> eyes;
  for (const EyeSide side : {EyeSide::left, EyeSide::right}) {
    if (context != nullptr) eyes.emplace_back(*context, scene(), hmd.eye(side), loop.picture(side), loop.lens_mode());
  }
  const auto drawn = [&](const Frame& frame, EyeSide side) {
    const EyeView& view = frame.eye(side);
    if (eyes.empty()) return Picture(view.rendered_view(), nullptr);
    return eyes[index_of(side)].draw(view, rendering::virtual_style());
  };
  while (now() < time_at(seconds)) {
    Frame frame = loop.begin_frame(now());
    std::this_thread::sleep_until(start + (frame.plan.render_start - microseconds(200)).time_since_epoch());
    const LateLatch latch = loop.late_latch(frame, now());
    const Picture left = drawn(frame, EyeSide::left), right = drawn(frame, EyeSide::right);
    std::this_thread::sleep_until(start + (frame.deadline - milliseconds(2)).time_since_epoch());
    const FrameDeflection late = loop.deflect(left, right, now());
    for (EyeRenderer& eye : eyes) {
      const std::size_t i = &eye == eyes.data() ? 0 : 1;
      eye.panel(i == 0 ? left : right, late.eyes[i], row.kind, hmd.timing);
    }
    if (context != nullptr) context->gl().Finish();
    write(stdout, frame_log(frame, &latch, &late));
  }
  stop = true;
  tracker.join();
  const LatestPoseCounters counters = latest.counters();
  std::fprintf(stderr, "tracker: %llu poses published, %llu refused\n",
               static_cast<unsigned long long>(counters.published),
               static_cast<unsigned long long>(counters.refused()));
}

/// Prints the table and holds it against what must be; the number of lines that do not hold.
int print(const std::vector<Row>& all, const std::vector<std::array<Figures, 2>>& figures, const Options& options) {
  std::printf("Motion %s, %.3g s; swim and registration error are RMS over the discs of the scene, both eyes.\n\n",
              options.motion.c_str(), options.seconds);
  std::printf("| stages on          | global: deg/s |     px | rolling: deg/s |     px |\n");
  std::printf("|--------------------|--------------:|-------:|---------------:|-------:|\n");
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto& [global, rolling] = figures[i];
    std::printf("| %-18s | %13.3f | %6.3f | %14.3f | %6.3f |\n", all[i].name.c_str(), global.swim_deg_s,
                global.registration_px, rolling.swim_deg_s, rolling.registration_px);
  }
  int wrong = 0;
  const auto hold = [&](bool holds, const std::string& what) {
    if (holds) return;
    std::printf("does not hold: %s\n", what.c_str());
    ++wrong;
  };
  std::printf("\n");
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t display = 0; display < 2; ++display) {
      const Figures& f = figures[i][display];
      const std::string where = all[i].name + (display == 0 ? ", global" : ", rolling");
      hold(f.frames_with_issues == 0, where + ": " + std::to_string(f.frames_with_issues) + " frames with issues");
      if (f.pictures.discs() > 0) {
        hold(f.pictures.rms_px() < 0.1, where + ": pictures differ by " + std::to_string(f.pictures.rms_px()) + " px");
      }
      if (i == 0 || i > 5) continue;
      const Figures& before = figures[i - 1][display];
      // A stage that has nothing to do leaves rounding; one that helps may not harm the other figure by a hundredth.
      hold(f.swim_deg_s <= 1.01 * before.swim_deg_s, where + ": more swim than with " + all[i - 1].name);
      hold(f.registration_px <= 1.01 * before.registration_px, where + ": worse than with " + all[i - 1].name);
    }
  }
  double squares = 0.0;
  std::size_t discs = 0;
  for (const auto& row : figures) {
    for (const Figures& f : row) {
      if (f.pictures.discs() == 0) continue;
      squares += f.pictures.rms_px() * f.pictures.rms_px() * static_cast<double>(f.pictures.discs());
      discs += f.pictures.discs();
    }
  }
  if (discs > 0) {
    std::printf("Discs in pictures of the left eye against these figures: %zu, %.3f px RMS.\n", discs,
                std::sqrt(squares / static_cast<double>(discs)));
  }
  return wrong;
}

[[noreturn]] void usage(const std::string& problem) {
  std::fprintf(stderr,
               "sample_engine_loop: %s\nusage: sample_engine_loop [--motion M0..M8] [--seconds S] [--draw-every N] "
               "[--log FILE] [--check] [--live SECONDS]\n",
               problem.c_str());
  std::exit(2);
}

Options parse(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    if (name == "--check") {
      options.check = true;
      continue;
    }
    if (i + 1 == argc) usage("'" + name + "' is unknown or wants a value");
    const std::string value = argv[++i];
    const auto number = [&](double least, double most) {
      char* end = nullptr;
      const double x = std::strtod(value.c_str(), &end);
      if (end == value.c_str() || *end != '\0' || !(x >= least && x <= most)) {
        usage(name + " " + value + ": expected " + std::to_string(least) + " to " + std::to_string(most));
      }
      return x;
    };
    if (name == "--motion")
      options.motion = value;
    else if (name == "--seconds")
      options.seconds = number(0.1, 20.0);
    else if (name == "--draw-every")
      options.draw_every = static_cast<int>(number(0, 1e6));
    else if (name == "--log")
      options.log = value;
    else if (name == "--live")
      options.live_seconds = number(0.1, 1000.0);
    else
      usage("unknown argument '" + name + "'");
  }
  return options;
}

int run(int argc, char** argv) {
  const Options options = parse(argc, argv);
  const std::unique_ptr<Motion> motion = make_motion(options.motion);
  if (!motion) usage("no motion '" + options.motion + "'; there are M0 to M8");
  if (0.5 + options.seconds > to_seconds(motion->duration())) usage("the motion is shorter than that");

  std::array<HmdModel, 2> hmds{default_hmd(), default_hmd()};  // global, rolling
  hmds[1].timing.scan_out = ScanOut::rolling;
  hmds[1].timing.scan_duration = microseconds(11100);

  std::unique_ptr<rendering::Context> context;
  if (options.draw_every > 0) context = rendering::make_context();
  if (options.live_seconds > 0.0) {
    run_live(hmds[1], *motion, options.live_seconds, context.get());
    return 0;
  }
  std::FILE* log = options.log.empty() ? nullptr : std::fopen(options.log.c_str(), "w");
  if (!options.log.empty() && log == nullptr) usage("cannot write " + options.log);

  const std::vector<Row> all = rows();
  std::vector<std::array<Figures, 2>> figures(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t display = 0; display < 2; ++display) {
      const bool is_last = i + 1 == all.size() && display == 1;
      figures[i][display] = simulate(all[i], hmds[display], *motion, options, context.get(), is_last ? log : nullptr);
    }
  }
  if (log != nullptr) std::fclose(log);
  const int wrong = print(all, figures, options);
  return options.check && wrong > 0 ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {  // no OpenGL, for one
    std::fprintf(stderr, "sample_engine_loop: %s\n", error.what());
    return 2;
  }
}
