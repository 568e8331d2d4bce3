/// One frame's record: when it was planned, latched and delivered, from which measurements, and how far the late stages
/// moved it.
///
/// Times that Monado's metrics (u_metrics.h, session frames) also record have its names; `for_each_field` hands out all
/// of them as name and number, for a line of JSON or CSV in any format. Times in ns of the host's clock, 0 when a stage
/// did not happen.
#pragma once

#include <cstdint>
#include <string_view>

#include <holdfast/geometry/angle.hpp>
#include <holdfast/pipeline/frame_issues.hpp>
#include <holdfast/timing/clock.hpp>

namespace holdfast {

struct FrameLog {
  std::int64_t frame_id = 0;

  HostTime predicted_wake_up_time{};     ///< when the renderer takes the matrices (FramePlan::render_start)
  HostTime predicted_gpu_done_time{};    ///< when the warp must begin for the scan-out not to be missed
  HostTime predicted_display_time{};     ///< the middle of scan-out that the picture was drawn for
  Duration predicted_display_period{0};  ///< one refresh
  HostTime display_time{};               ///< the middle of scan-out that the picture was deflected for
  HostTime when_predicted{};             ///< begin_frame was called
  HostTime when_latched{};               ///< late_latch was called
  HostTime when_delivered{};             ///< deflect was called

  // Of this library alone: the measurements that begin_frame, late_latch and deflect started from.
  HostTime when_measured{}, when_measured_for_latch{}, when_measured_for_deflection{};
  double latch_turned_rad = 0.0, latch_moved_m = 0.0;            ///< head, by the late latch
  double deflection_turned_rad = 0.0, deflection_moved_m = 0.0;  ///< left eye, drawn against the middle of its scan
  FrameIssues issues;                                            ///< of all stages

  [[nodiscard]] static constexpr std::int64_t ns(HostTime t) { return t.time_since_epoch().count(); }

  /// field(std::string_view name, std::int64_t or double value), in a fixed order.
  template <typename Field>
  void for_each_field(Field&& field) const {
    field(std::string_view("frame_id"), frame_id);
    field(std::string_view("predicted_wake_up_time_ns"), ns(predicted_wake_up_time));
    field(std::string_view("predicted_gpu_done_time_ns"), ns(predicted_gpu_done_time));
    field(std::string_view("predicted_display_time_ns"), ns(predicted_display_time));
    field(std::string_view("predicted_display_period_ns"), std::int64_t{predicted_display_period.count()});
    field(std::string_view("display_time_ns"), ns(display_time));
    field(std::string_view("when_predicted_ns"), ns(when_predicted));
    field(std::string_view("when_latched_ns"), ns(when_latched));
    field(std::string_view("when_delivered_ns"), ns(when_delivered));
    field(std::string_view("when_measured_ns"), ns(when_measured));
    field(std::string_view("when_measured_for_latch_ns"), ns(when_measured_for_latch));
    field(std::string_view("when_measured_for_deflection_ns"), ns(when_measured_for_deflection));
    field(std::string_view("latch_turned_deg"), radians(latch_turned_rad).degrees());
    field(std::string_view("latch_moved_mm"), 1e3 * latch_moved_m);
    field(std::string_view("deflection_turned_deg"), radians(deflection_turned_rad).degrees());
    field(std::string_view("deflection_moved_mm"), 1e3 * deflection_moved_m);
    field(std::string_view("issues"), static_cast<std::int64_t>(issues.bits()));
  }
};

}  // namespace holdfast
