/// Handles and results of the coordinate-system graph (graph.hpp).
///
/// A FrameId or EdgeId is a small number that belongs to the graph that gave it; one made by default belongs to none
/// and is answered by `unknown_frame`. A Lookup is T_AB at a time together with how good it is.
#pragma once

#include <cstdint>

#include <holdfast/frames/pose_history.hpp>
#include <holdfast/geometry/vqs.hpp>
#include <holdfast/timing/clock.hpp>

namespace holdfast {

class FrameId {
 public:
  FrameId() = default;
  explicit FrameId(std::int32_t index) : index_(index) {}
  [[nodiscard]] std::int32_t index() const { return index_; }
  [[nodiscard]] bool valid() const { return index_ >= 0; }
  friend bool operator==(const FrameId&, const FrameId&) = default;

 private:
  std::int32_t index_ = -1;
};

/// An independent transform of the graph. The id of a removed edge never names another one.
class EdgeId {
 public:
  EdgeId() = default;
  EdgeId(std::int32_t index, std::uint32_t generation) : index_(index), generation_(generation) {}
  [[nodiscard]] std::int32_t index() const { return index_; }
  [[nodiscard]] std::uint32_t generation() const { return generation_; }
  [[nodiscard]] bool valid() const { return index_ >= 0; }
  friend bool operator==(const EdgeId&, const EdgeId&) = default;

 private:
  std::int32_t index_ = -1;
  std::uint32_t generation_ = 0;
};

enum class LookupStatus : std::uint8_t {
  ok,              ///< every dynamic transform was known at the time asked for
  held,            ///< at least one dynamic transform is its newest sample, held; `age` says how old
  unknown_frame,   ///< a frame is not of this graph
  no_path,         ///< the frames are in components that no edge connects
  no_data,         ///< a dynamic transform on the way has no sample yet
  before_history,  ///< the time lies before the oldest sample of a dynamic transform on the way
  too_old,         ///< a dynamic transform's newest sample is older than it may be held
  gap,             ///< a dynamic transform has no samples near the time, on one side or the other
  stale_chain,     ///< the graph was changed after the chain was made: make it again
};

[[nodiscard]] inline const char* to_string(LookupStatus status) {
  switch (status) {
    case LookupStatus::ok:
      return "ok";
    case LookupStatus::held:
      return "held";
    case LookupStatus::unknown_frame:
      return "unknown frame";
    case LookupStatus::no_path:
      return "no path";
    case LookupStatus::no_data:
      return "no data";
    case LookupStatus::before_history:
      return "before history";
    case LookupStatus::too_old:
      return "too old";
    case LookupStatus::gap:
      return "gap";
    case LookupStatus::stale_chain:
      return "stale chain";
  }
  return "?";
}

[[nodiscard]] inline const char* to_string(PushStatus status) {
  switch (status) {
    case PushStatus::accepted:
      return "accepted";
    case PushStatus::out_of_order:
      return "out of order";
    case PushStatus::duplicate:
      return "duplicate";
    case PushStatus::future:
      return "future";
    case PushStatus::not_finite:
      return "not finite";
    case PushStatus::not_dynamic:
      return "not dynamic";
  }
  return "?";
}

[[nodiscard]] inline LookupStatus lookup_status(SampleStatus status) {
  switch (status) {
    case SampleStatus::interpolated:
      return LookupStatus::ok;
    case SampleStatus::held:
      return LookupStatus::held;
    case SampleStatus::too_old:
      return LookupStatus::too_old;
    case SampleStatus::before_history:
      return LookupStatus::before_history;
    case SampleStatus::gap:
      return LookupStatus::gap;
    case SampleStatus::empty:
      return LookupStatus::no_data;
  }
  return LookupStatus::no_data;
}

/// T_AB at a time: p_A = T_AB * p_B.
struct Lookup {
  Vqs T_AB;         ///< the identity unless usable()
  Duration age{0};  ///< the oldest age of the dynamic transforms used; 0 when all were interpolated
  LookupStatus status = LookupStatus::ok;
  EdgeId edge;  ///< the edge that is oldest or at fault; none when every transform was known at the time

  [[nodiscard]] bool usable() const { return status == LookupStatus::ok || status == LookupStatus::held; }
  explicit operator bool() const { return usable(); }
};

}  // namespace holdfast
