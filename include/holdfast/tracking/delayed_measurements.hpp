/// Measurements that come late or out of order: go back, put them in at their time, and replay what followed.
///
///     using Event = UpdateEvent<CameraSighting, AngularRate>;       // what may arrive
///     DelayedFilter<ScaatFilter<2>, Event> tracker(filter, 200);    // remembers 200 events
///     tracker.update(Event(t, sighting, {beacons, index}));         // at any time, in any order
///     PoseEstimate head = tracker.filter().pose_estimate();         // the newest, never held back
/// Filters refuse what is older than their state, and waiting for stragglers would delay everybody. Here each of the newest
/// events is kept with the filter as it was before and with the record of each device it touches. A late event takes back
/// those after it, newest first, is put in, and they are applied again: the result is that of the same events in order,
/// bit by bit, gate, counters and devices included, as long as nothing comes later than the history reaches back.
/// Events of one time are applied by rising `order`, and those of one order as they came.
/// Everything is allocated at the start: per event one copy of the filter (some 3.5 kB for ScaatFilter<2>), twice the
/// device records, and the measurement. Cost: an event in time is an update and a copy; one with k newer ones costs k + 1
/// of that. The filter's counters tell of the events as finally ordered.
/// Bad input: an event older than what was forgotten is refused, and counted: `time_backwards`. One that the filter finds
/// too far ahead (`gap_too_long`) is not remembered, so a wrong time stamp does no harm. What a filter refuses is
/// remembered, for in another order it might be good.
#pragma once

#include <concepts>
#include <utility>
#include <variant>
#include <vector>

#include <holdfast/tracking/scaat_filter.hpp>

namespace holdfast {

/// Something that happened at a time, can be applied to a filter and, whatever came of it, taken back from what is not
/// inside the filter.
template <typename E, typename Filter>
concept ReversibleEvent = requires(E& event, const E& constant, Filter& filter) {
  { constant.time() } -> std::same_as<HostTime>;
  { constant.order() } -> std::convertible_to<std::int64_t>;
  { event.apply(filter) } -> std::same_as<UpdateStatus>;
  event.take_back();
};

/// A measurement with its devices. `order`, if given, tells apart those of one time.
template <Measurement M>
class MeasurementEvent {
 public:
  using Source = DeviceSlot<M::source_size>;
  using Sensor = DeviceSlot<M::sensor_size>;

  MeasurementEvent(HostTime t, const M& measurement, const Source& source, const Sensor& sensor, std::int64_t order = 0)
      : t_(t), order_(order), measurement_(measurement), source_(source), sensor_(sensor) {}

  [[nodiscard]] HostTime time() const { return t_; }
  [[nodiscard]] std::int64_t order() const { return order_; }

  template <typename Filter>
  UpdateStatus apply(Filter& filter) {
    has_devices_ = source_.exists() && sensor_.exists();
    if (has_devices_) {
      source_before_ = source_.keep();
      sensor_before_ = sensor_.keep();
    }
    return filter.update(t_, measurement_, source_, sensor_);
  }
  void take_back() const {
    if (!has_devices_) return;
    source_.put_back(source_before_);
    sensor_.put_back(sensor_before_);
  }

 private:
  HostTime t_;
  std::int64_t order_;
  M measurement_;
  Source source_;
  Sensor sensor_;
  bool has_devices_ = false;
  typename Source::Kept source_before_;
  typename Sensor::Kept sensor_before_;
};

/// A measurement of any of these kinds.
template <Measurement... Ms>
class UpdateEvent {
 public:
  template <Measurement M>
  UpdateEvent(HostTime t, const M& measurement, std::type_identity_t<DeviceSlot<M::source_size>> source,
              std::type_identity_t<DeviceSlot<M::sensor_size>> sensor, std::int64_t order = 0)
      : event_(MeasurementEvent<M>(t, measurement, source, sensor, order)) {}
  template <Measurement M>
  requires(M::sensor_size == 0)
      UpdateEvent(HostTime t, const M& measurement, std::type_identity_t<DeviceSlot<M::source_size>> source,
                  std::int64_t order = 0)
      : UpdateEvent(t, measurement, source, DeviceSlot<0>(), order) {}
  template <Measurement M>
  requires(M::source_size == 0 && M::sensor_size == 0)
      UpdateEvent(HostTime t, const M& measurement, std::int64_t order = 0)
      : UpdateEvent(t, measurement, DeviceSlot<0>(), DeviceSlot<0>(), order) {}

  [[nodiscard]] HostTime time() const {
    return std::visit([](const auto& event) { return event.time(); }, event_);
  }
  [[nodiscard]] std::int64_t order() const {
    return std::visit([](const auto& event) { return event.order(); }, event_);
  }
  template <typename Filter>
  UpdateStatus apply(Filter& filter) {
    return std::visit([&](auto& event) { return event.apply(filter); }, event_);
  }
  void take_back() const {
    std::visit([](const auto& event) { event.take_back(); }, event_);
  }

 private:
  std::variant<MeasurementEvent<Ms>...> event_;
};

template <typename Filter, typename Event>
requires ReversibleEvent<Event, Filter>
class DelayedFilter {
 public:
  struct Counters {
    std::uint64_t late = 0;           ///< put in before others
    std::uint64_t replayed = 0;       ///< updates that were done again for these
    std::uint64_t too_old = 0;        ///< refused: the history does not reach back
    std::uint64_t too_far_ahead = 0;  ///< refused by the filter, and not remembered
  };

  /// Remembers `capacity` events: as many as arrive within the longest delay. Precondition: capacity >= 1.
  DelayedFilter(const Filter& filter, int capacity) : filter_(filter), capacity_(static_cast<std::size_t>(capacity)) {
    HOLDFAST_ASSERT(capacity >= 1, "a history holds at least one event");
    steps_.assign(capacity_ + 1, Step{std::nullopt, filter});
  }

  /// The status is that of the event itself; later ones may change theirs when it is late.
  UpdateStatus update(const Event& event) {
    const Key key{event.time(), event.order()};
    if (forgotten_ && key < *forgotten_) {
      ++counters_.too_old;
      return UpdateStatus::time_backwards;
    }
    const std::size_t place = place_of(key);
    for (std::size_t k = count_; k > place; --k) at(k - 1).event->take_back();
    if (place < count_) filter_ = at(place).before;
    for (std::size_t k = count_; k > place; --k) at(k).event = std::move(at(k - 1).event);
    at(place).event = event;
    const UpdateStatus status = apply(place);
    if (place == count_ && status == UpdateStatus::gap_too_long) {
      filter_ = at(place).before;
      ++counters_.too_far_ahead;
      return status;
    }
    for (std::size_t k = place + 1; k <= count_; ++k) (void)apply(k);
    counters_.late += place < count_ ? 1 : 0;
    counters_.replayed += count_ - place;
    if (++count_ > capacity_) forget_oldest();
    return status;
  }

  /// The newest estimate.
  [[nodiscard]] const Filter& filter() const { return filter_; }
  [[nodiscard]] const Counters& counters() const { return counters_; }
  [[nodiscard]] int remembered() const { return static_cast<int>(count_); }

  /// Goes on with another filter, as after losing track, and forgets what was before its state's time.
  void restart(const Filter& filter) {
    filter_ = filter;
    count_ = 0;
    forgotten_.reset();
  }

 private:
  using Key = std::pair<HostTime, std::int64_t>;
  struct Step {
    std::optional<Event> event;
    Filter before;
  };

  /// The k-th oldest; `count_` is the next, for which there is always room.
  [[nodiscard]] Step& at(std::size_t k) { return steps_[(first_ + k) % steps_.size()]; }

  [[nodiscard]] std::size_t place_of(const Key& key) {
    std::size_t place = count_;
    while (place > 0 && key < Key{at(place - 1).event->time(), at(place - 1).event->order()}) --place;
    return place;
  }
  UpdateStatus apply(std::size_t k) {
    Step& step = at(k);
    step.before = filter_;
    return step.event->apply(filter_);
  }
  void forget_oldest() {
    forgotten_ = Key{at(0).event->time(), at(0).event->order()};
    first_ = (first_ + 1) % steps_.size();
    --count_;
  }

  Filter filter_;
  std::size_t capacity_;
  std::vector<Step> steps_;  ///< a ring
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  std::optional<Key> forgotten_;  ///< the newest event that was dropped
  Counters counters_;
};

}  // namespace holdfast
