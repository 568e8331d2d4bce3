/// Multiple constraints at a time (MCAAT): the same filter as SCAAT, fed with N measurements in one update.
///
/// SCAAT's rival (002 sections 3.7 and E.3.1): measurements are collected until there are N, and taken as ones of the time of the
/// newest: the simultaneity assumption. All are linearised at the same predicted state, which makes them one stacked
/// measurement; as their noise is independent, the stacked update is done one after another, each residual less what the
/// ones before have moved. With N = 1 it is SCAAT. Sources are calibrated as there.
/// `Sources` is a DeviceTable, or anything with its `for_sighting` and `store`.
/// Nothing here allocates. Bad input: a measurement that the state cannot give is left out of the window's update, and
/// McaatStatus tells when nothing could be updated.
#pragma once

#include <array>
#include <optional>

#include <holdfast/tracking/advance.hpp>
#include <holdfast/tracking/device_estimate.hpp>
#include <holdfast/tracking/innovation.hpp>
#include <holdfast/tracking/measurement.hpp>
#include <holdfast/tracking/observation_window.hpp>

namespace holdfast {

enum class McaatStatus {
  collecting,      ///< the window is not full yet
  updated,         ///< there is a new estimate
  time_backwards,  ///< older than the last estimate: ignored
  nothing_seen,    ///< the state could give none of the window's measurements
  refused          ///< no measurement of the window could correct: nothing changed but the time
};

template <int Order, Measurement M, int Capacity = 16>
class McaatFilter {
 public:
  static_assert(M::sensor_size == 0, "sensors are not calibrated here");

  McaatFilter(const TargetState<Order>& start, const ProcessModel<Order>& model, const WindowShape& shape)
      : window_(shape), state_(start), model_(model) {}

  template <typename Sources>
  [[nodiscard]] McaatStatus add(HostTime t, const M& measurement, int source, Sources& sources) {
    if (t < state_.t) return McaatStatus::time_backwards;
    if (!window_.add({measurement, source})) return McaatStatus::collecting;
    advance(state_, model_, t);
    return update(sources);
  }

  [[nodiscard]] const TargetState<Order>& state() const { return state_; }

 private:
  struct Observation {
    M measurement;
    int source = 0;
  };

  /// A measurement as it looked from the window's predicted state.
  struct Frozen {
    static constexpr int size = M::size, state_size = M::state_size, source_size = M::source_size, sensor_size = 0;

    const TargetState<Order>* predicted = nullptr;
    int source = 0;
    DeviceParameters<M::source_size> source_parameters;
    Linearization<M> linear;

    template <int SameOrder>
    [[nodiscard]] bool linearize(const TargetState<SameOrder>& state,
                                 const DeviceParameters<M::source_size>& parameters,
                                 const DeviceParameters<0>& /*sensor*/, Linearization<Frozen>& out) const {
      out = linear;
      const typename TargetState<Order>::Error moved = predicted->error_of(state);
      out.residual -= linear.H.lazyProduct(moved.template head<M::state_size>());
      out.residual -= linear.H_source.lazyProduct(parameters - source_parameters);
      return true;
    }
  };

  template <typename Sources>
  [[nodiscard]] McaatStatus update(Sources& sources) {
    const TargetState<Order> predicted = state_;
    std::array<Frozen, Capacity> seen;
    std::size_t count = 0;
    for (const Observation& observation : window_.observations()) {
      Frozen& frozen = seen[count];
      frozen.predicted = &predicted;
      frozen.source = observation.source;
      frozen.source_parameters = sources.for_sighting(observation.source).x;
      if (observation.measurement.linearize(predicted, frozen.source_parameters, {}, frozen.linear)) ++count;
    }
    if (count == 0) return McaatStatus::nothing_seen;
    bool corrected = false;
    for (std::size_t i = 0; i < count; ++i) {
      auto source = sources.for_sighting(seen[i].source);
      const std::optional<Innovation<Order, Frozen>> innovation = extended_innovation(state_, seen[i], source);
      NoDevice none;
      if (!innovation || !correct(state_, *innovation, source, none)) continue;
      sources.store(seen[i].source, source);
      corrected = true;
    }
    return corrected ? McaatStatus::updated : McaatStatus::refused;
  }

  ObservationWindow<Observation, Capacity> window_;
  TargetState<Order> state_;
  ProcessModel<Order> model_;
};

}  // namespace holdfast
