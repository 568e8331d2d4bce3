#include "track_scenarios.hpp"

#include <algorithm>
#include <limits>
#include <numbers>

#include <holdfast/registration/track_output.hpp>
#include <holdfast/registration/track_tuning.hpp>
#include <holdfast/simulation/faults.hpp>
#include <holdfast/simulation/sighting_stream.hpp>

namespace swimlab {

using namespace holdfast;

namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// One stream that methods are compared on.
struct TrackCase {
  std::string name;
  std::vector<BeaconSighting> stream{};
  TrackTuning tuning = TrackTuning::moving;
  bool gate = true, rename = true;
  bool informed = false;  ///< no stream: the tracker asks for what it wants to see
};

class Scenario {
 public:
  Scenario(const TrackRequest& request, const Motion& truth, const std::function<void(const std::string&)>& tell)
      : request_(request), truth_(truth), tell_(tell), simulator_(rig_of(request), truth, request.seed) {}

  [[nodiscard]] std::vector<TrackCaseRow> run() {
    switch (request_.scenario) {
      case TrackScenario::typical:
        compare({"", stream()});
        break;
      case TrackScenario::still:
        compare({"moving tuning", stream({.interval = std::chrono::microseconds(500)})});
        compare({"still tuning", stream({.interval = std::chrono::microseconds(500)}), TrackTuning::still});
        break;
      case TrackScenario::low_rate:
        for (const int rate : {1000, 100, 20, 10}) {
          compare({std::to_string(rate) + " Hz", stream({.interval = from_seconds(1.0 / rate)})});
        }
        break;
      case TrackScenario::simultaneous:
        for (const int group : {1, 3, 10}) compare({std::to_string(group) + " at a time", stream({.group = group})});
        break;
      case TrackScenario::spectra:
        compare({"", stream()});
        break;
      case TrackScenario::ordering:
        compare({"round-robin", stream()});
        compare({"random", stream({.order = SightingOrder::random, .seed = request_.seed})});
        compare({"least recently used", stream({.order = SightingOrder::least_recently_used, .seed = request_.seed})});
        compare({.name = "weakest direction", .informed = true});
        break;
      case TrackScenario::faults: {
        compare({"no faults", stream()});
        std::vector<BeaconSighting> wrong = stream();
        misidentify(wrong, simulator_, 0.2, request_.seed);
        compare({"20 % wrong", wrong});
        compare({.name = "20 %, none renamed", .stream = wrong, .rename = false});
        compare({.name = "20 % wrong, no gate", .stream = wrong, .gate = false});
        break;
      }
      case TrackScenario::cold_start:
        cold_start();
        break;
      case TrackScenario::blocked:
        blocked();
        break;
    }
    return std::move(rows_);
  }

 private:
  [[nodiscard]] static HiBallRig rig_of(const TrackRequest& request) {
    HiBallOptions options;
    options.seed = request.seed;
    options.secondary_views = request.all_views;
    return hiball_rig(options);
  }
  [[nodiscard]] const HiBallRig& rig() const { return simulator_.rig(); }

  [[nodiscard]] std::vector<BeaconSighting> stream(const StreamOptions& options = {}) const {
    return sighting_stream(simulator_, options);
  }

  [[nodiscard]] static std::string told(const std::string& case_name, TrackMethod method) {
    return std::string(name_of(method)) + (case_name.empty() ? "" : ", " + case_name);
  }

  [[nodiscard]] TrackParameters parameters_of(TrackMethod method, TrackTuning tuning = TrackTuning::moving) const {
    return settings_of(method, request_.settings, tuning).value();
  }

  void compare(const TrackCase& c) {
    for (const TrackMethod method : request_.methods) {
      const bool special = !c.gate || !c.rename || c.informed;
      if (special && !is_scaat(method)) continue;  // it has no gate, and cannot ask
      if (c.informed && is_second_run(method)) continue;
      tell_(told(c.name, method));
      TrackParameters parameters = parameters_of(method, c.tuning);
      if (!c.gate) {
        parameters.gate.probability = 1.0;
        parameters.manoeuvre = {};  // or each wrong name would rouse it
      }
      if (!c.rename) parameters.renamed_in_a_row = 0;
      rows_.push_back(measured(c, method, parameters));
    }
  }

  /// Whether the output's noise is what the scenario is about: sightings come evenly then.
  [[nodiscard]] bool about_noise() const {
    const TrackScenario scenario = request_.scenario;
    return scenario == TrackScenario::spectra || scenario == TrackScenario::ordering ||
           scenario == TrackScenario::low_rate || scenario == TrackScenario::still;
  }

  [[nodiscard]] TrackCaseRow measured(const TrackCase& c, TrackMethod method, const TrackParameters& parameters) const {
    TrackCurves curves(truth_, about_noise());
    TrackCaseRow result{c.name, {}, {}, {}};
    const auto run = [&](const TrackObserver& observe) {
      const TrackObserver with_curves = [&](const TrackMoment& m) {
        curves.add(m);
        if (observe) observe(m);
      };
      const TrackObserver& observer = request_.curves ? with_curves : observe;
      result.row = c.informed ? run_informed(method, parameters, simulator_, observer, request_.start)
                              : run_method(method, parameters, rig(), truth_, c.stream, observer, request_.start);
      if (request_.curves) result.curves = curves.curves();
    };
    switch (request_.scenario) {
      case TrackScenario::still: {
        const HostTime begin = truth_.begin(), tenth = begin + truth_.duration() / 10,
                       last = truth_.end() - truth_.duration() / 10;
        ThreePointError early, late;
        run([&](const TrackMoment& m) {
          if (m.fresh && m.sighting.t < tenth) early.add(m.tracker.X_WB(), m.X_WB);
          if (m.fresh && m.sighting.t >= last) late.add(m.tracker.X_WB(), m.X_WB);
        });
        result.more = {{"first_tenth_mm", 1e3 * early.rms()}, {"last_tenth_mm", 1e3 * late.rms()}};
        break;
      }
      case TrackScenario::spectra:
      case TrackScenario::ordering: {
        OutputNoise noise(1000.0);
        run([&](const TrackMoment& m) { noise.add(m); });
        const auto mm = [](std::optional<double> m) { return m ? std::optional(1e3 * *m) : std::nullopt; };
        result.more = {{"noise_above_100_hz_mm", mm(noise.above(100.0))},
                       {"held_noise_above_100_hz_mm", mm(noise.held_above(100.0))},
                       {"peak_over_median", noise.peak_above(100.0)}};
        break;
      }
      case TrackScenario::faults: {
        long good = 0, good_gated = 0, wrong = 0, wrong_gated = 0, put_right = 0;
        run([&](const TrackMoment& m) {
          const bool is_wrong = m.sighting.faults.wrong_beacon;
          ++(is_wrong ? wrong : good);
          if (m.tracker.turned_away()) ++(is_wrong ? wrong_gated : good_gated);
          if (is_wrong && m.tracker.renamed() == m.sighting.faults.true_beacon) ++put_right;
        });
        result.more = {{"good_gated_pct", percent(good_gated, good)},
                       {"wrong_gated_pct", percent(wrong_gated, wrong)},
                       {"renamed_pct", percent(put_right, wrong)}};
        break;
      }
      default:
        run({});
    }
    return result;
  }

  [[nodiscard]] static std::optional<double> percent(long part, long whole) {
    if (whole == 0) return std::nullopt;
    return 100.0 * static_cast<double>(part) / static_cast<double>(whole);
  }

  /// Times to be right again, as figures.
  [[nodiscard]] static std::vector<MoreFigure> recovery_figures(const std::vector<std::optional<Duration>>& times) {
    std::vector<double> ms;
    long in_time = 0;
    for (const std::optional<Duration>& time : times) {
      if (time) ms.push_back(1e3 * to_seconds(*time));
      in_time += time && *time <= milliseconds(50);
    }
    std::ranges::sort(ms);
    const std::size_t middle = times.size() / 2;
    const auto trials = static_cast<long>(times.size());
    return {{"trials", static_cast<double>(trials)},
            {"within_50_ms_pct", percent(in_time, trials)},
            {"median_ms", middle < ms.size() ? std::optional(ms[middle]) : std::nullopt},
            {"recovered_pct", percent(static_cast<long>(ms.size()), trials)}};
  }

  /// A SCAAT tracker that never searches: what the filter alone can do.
  static void forbid_search(ScaatSettings& settings, ReacquisitionSettings& again) {
    settings.gate.lost_after = std::numeric_limits<int>::max();
    again.longest_gap = std::chrono::hours(1);
  }

  /// Trials of 0.3 s, from a tracker that knows nothing, or that starts 4 m off with any heading.
  void cold_start() {
    const std::vector<BeaconSighting> all = stream();
    for (const TrackMethod method : request_.methods) {
      for (const bool search : {true, false}) {
        const std::string name = search ? "search" : "no search, 4 m off";
        tell_(told(name, method));
        rows_.push_back(cold_starts(all, method, name, search));
      }
    }
  }

  [[nodiscard]] TrackCaseRow cold_starts(const std::vector<BeaconSighting>& all, TrackMethod method,
                                         const std::string& name, bool search) const {
    constexpr int trials = 40;
    constexpr std::size_t sightings = 300;
    const TrackParameters parameters = parameters_of(method);
    std::vector<std::optional<Duration>> times;
    TrackRow row;
    RecoveryCurves curves;
    if (all.size() <= sightings) return {name, row, recovery_figures(times), {}};
    for (int trial = 0; trial < trials; ++trial) {
      KeyedNumbers numbers(request_.seed, {trial, 17});
      const auto first = static_cast<std::size_t>(numbers.below(static_cast<int>(all.size() - sightings)));
      const auto part = std::span(all).subspan(first, sightings);
      DeviceTable<3> beacons = beacon_table(rig(), parameters.beacons, parameters.autocalibrate);
      ScaatSettings settings{.gate = parameters.gate, .manoeuvre = parameters.manoeuvre};
      ReacquisitionSettings again;
      if (!search) forbid_search(settings, again);
      ScaatTracker tracker =
          search ? ScaatTracker(rig(), beacons, parameters.process, settings, again)
                 : ScaatTracker(rig(), beacons, far_off(part.front().t, numbers), parameters.process, settings, again);
      RecoveryTime recovery(part.front().t);
      curves.begin(part.front().t);
      row = run_tracker(tracker, part, truth_, [&](const TrackMoment& m) {
        recovery.add(m);
        if (request_.curves) curves.add(m);
      });
      times.push_back(recovery.time());
    }
    row.method = method;
    return {name, row, recovery_figures(times), request_.curves ? curves.curves() : std::vector<TrackCurve>{}};
  }

  /// 4 m from the truth in a random direction, and turned anyhow (002 6.2.7's covariance: 2 m^2, and 180 deg).
  [[nodiscard]] TargetState<2> far_off(HostTime t, KeyedNumbers& numbers) const {
    const Vector2 a = numbers.normal_pair(), b = numbers.normal_pair(), c = numbers.normal_pair(),
                  d = numbers.normal_pair();
    TargetState<2> state = starting_state(truth_, t);
    const Vector3 direction(a.x(), a.y(), b.x());
    const Quaternion q(b.y(), c.x(), c.y(), d.x());
    state.X_WB = Rigid(q.normalized(), state.X_WB.p() + 4.0 * direction.normalized());
    state.P.diagonal().head<3>().setConstant(16.0 / 3.0);
    state.P.diagonal().segment<3>(3).setConstant(std::numbers::pi * std::numbers::pi);
    return state;
  }

  /// From the second second on, every six seconds nothing is seen for two.
  void blocked() {
    std::vector<BeaconSighting> seen = stream();
    std::vector<HostTime> ends;
    for (HostTime begin = truth_.begin() + seconds(1); begin + seconds(3) <= truth_.end(); begin += seconds(6)) {
      ends.push_back(begin + seconds(2));
      block_cameras(seen, {begin, ends.back()});
    }
    for (const TrackMethod method : request_.methods) {
      for (const bool search : {true, false}) {
        const std::string name = search ? "search" : "no search";
        tell_(told(name, method));
        rows_.push_back(recoveries(seen, ends, method, name, search));
      }
    }
  }

  [[nodiscard]] TrackCaseRow recoveries(const std::vector<BeaconSighting>& seen, const std::vector<HostTime>& ends,
                                        TrackMethod method, const std::string& name, bool search) const {
    const TrackParameters parameters = parameters_of(method);
    DeviceTable<3> beacons = beacon_table(rig(), parameters.beacons, parameters.autocalibrate);
    ScaatSettings settings{.gate = parameters.gate, .manoeuvre = parameters.manoeuvre};
    ReacquisitionSettings again;
    if (!search) forbid_search(settings, again);
    ScaatTracker tracker(rig(), beacons, starting_state(truth_, seen.front().t, request_.start), parameters.process,
                         settings, again);
    TrackCurves whole(truth_);
    RecoveryCurves after;
    std::size_t trials = 0;
    std::vector<RecoveryTime> recoveries;
    for (const HostTime end : ends) recoveries.emplace_back(end);
    TrackRow row = run_tracker(tracker, seen, truth_, [&](const TrackMoment& m) {
      for (std::size_t i = 0; i < ends.size(); ++i) {
        if (m.sighting.t >= ends[i] && m.sighting.t < ends[i] + seconds(1)) recoveries[i].add(m);
      }
      if (!request_.curves) return;
      whole.add(m);
      if (trials < ends.size() && m.sighting.t >= ends[trials]) after.begin(ends[trials++]);
      after.add(m);
    });
    std::vector<std::optional<Duration>> times;
    for (const RecoveryTime& recovery : recoveries) times.push_back(recovery.time());
    row.method = method;
    row.accepted = row.updates;
    if (parameters.autocalibrate) row.beacons = beacon_errors(rig(), beacons);
    TrackCaseRow result{name, row, recovery_figures(times), {}};
    if (request_.curves) {
      result.curves = whole.curves();
      for (TrackCurve& curve : after.curves()) result.curves.push_back(std::move(curve));
    }
    return result;
  }

  const TrackRequest& request_;
  const Motion& truth_;
  const std::function<void(const std::string&)>& tell_;
  HiBallSimulator simulator_;
  std::vector<TrackCaseRow> rows_;
};

}  // namespace

std::optional<TrackParameters> settings_of(TrackMethod method, TrackSettings settings, TrackTuning tuning) {
  if (settings == TrackSettings::dissertation) return dissertation_parameters(method);
  const TrackParameters own = track_parameters(method, tuning);
  if (settings == TrackSettings::own) return own;
  const std::vector<double> found = found_values(method);
  return found.empty() ? std::nullopt : std::optional(with_tuned(own, found));
}

std::vector<TrackMethod> usual_methods(TrackScenario scenario) {
  switch (scenario) {
    case TrackScenario::typical:
    case TrackScenario::simultaneous:
    case TrackScenario::spectra:
      return {track_methods.begin(), track_methods.end()};
    case TrackScenario::cold_start:
    case TrackScenario::blocked:
      return {TrackMethod::scaat_autocal};
    case TrackScenario::ordering:
    case TrackScenario::faults:
      return {TrackMethod::scaat_autocal, TrackMethod::joint};
    case TrackScenario::still:
      return {TrackMethod::scaat_autocal, TrackMethod::scaat_autocal_2, TrackMethod::joint, TrackMethod::joint_models,
              TrackMethod::collinearity10};
    case TrackScenario::low_rate:
      return {TrackMethod::scaat_autocal, TrackMethod::scaat_autocal_2};
  }
  return {};
}

bool can_show(TrackScenario scenario, TrackMethod method) {
  const bool searches = scenario == TrackScenario::cold_start || scenario == TrackScenario::blocked;
  return !searches || method == TrackMethod::scaat || method == TrackMethod::scaat_autocal;
}

std::vector<TrackCaseRow> run_scenario(const TrackRequest& request, const Motion& truth,
                                       const std::function<void(const std::string&)>& tell) {
  return Scenario(request, truth, tell).run();
}

}  // namespace swimlab
