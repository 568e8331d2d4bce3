/// The experiments of `swimlab track hiball`: what differs between their cases, and what is measured beside the usual row.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <holdfast/registration/track_types.hpp>

#include "track_curves.hpp"

namespace swimlab {

enum class TrackScenario { typical, still, cold_start, blocked, low_rate, simultaneous, spectra, ordering, faults };

struct TrackScenarioName {
  TrackScenario scenario;
  std::string_view name, about;
};

inline constexpr std::array track_scenarios{
    TrackScenarioName{TrackScenario::typical, "typical", "1000 sightings a second (002 6.2.3, 6.2.4)"},
    TrackScenarioName{TrackScenario::still, "still", "at rest, 2000 a second, tuned for motion and for rest (6.2.10)"},
    TrackScenarioName{TrackScenario::cold_start, "cold-start", "40 starts without any idea of the pose (6.2.7)"},
    TrackScenarioName{TrackScenario::blocked, "blocked", "nothing seen for two of every six seconds (6.2.8)"},
    TrackScenarioName{TrackScenario::low_rate, "low-rate", "1000, 100, 20 and 10 sightings a second (6.2.9)"},
    TrackScenarioName{TrackScenario::simultaneous, "simultaneous", "1, 3 and 10 sightings of one time (6.2.5)"},
    TrackScenarioName{TrackScenario::spectra, "spectra", "noise above 100 Hz (figures 6.7 to 6.9)"},
    TrackScenarioName{TrackScenario::ordering, "ordering", "which camera and beacon come next (figure 6.10)"},
    TrackScenarioName{TrackScenario::faults, "faults", "one sighting in five names a wrong beacon"}};

/// A figure that only some scenarios have: its key in the JSON, and nothing when it is undefined.
using MoreFigure = std::pair<std::string, std::optional<double>>;

struct TrackCaseRow {
  std::string case_name;
  holdfast::TrackRow row;
  std::vector<MoreFigure> more;
  std::vector<TrackCurve> curves;  ///< none unless asked for
};

/// Whose settings methods run with: their own, those of found_values or those of 002 (registration/track_tuning.hpp).
enum class TrackSettings { own, found, dissertation };

/// Nothing where there are none for this method.
[[nodiscard]] std::optional<holdfast::TrackParameters> settings_of(
    holdfast::TrackMethod method, TrackSettings settings, holdfast::TrackTuning tuning = holdfast::TrackTuning::moving);

struct TrackRequest {
  TrackScenario scenario = TrackScenario::typical;
  std::vector<holdfast::TrackMethod> methods;
  TrackSettings settings = TrackSettings::own;  ///< that all methods have
  std::uint64_t seed = 1;
  bool all_views = false;  ///< 26 in place of six
  holdfast::StartKnowledge start;
  bool curves = false;  ///< whether rows are to have them
};

/// Methods that the scenario can show, of those it is usually shown with.
[[nodiscard]] std::vector<holdfast::TrackMethod> usual_methods(TrackScenario scenario);
/// Whether this method can do it at all.
[[nodiscard]] bool can_show(TrackScenario scenario, holdfast::TrackMethod method);

/// `tell` is called before each row with what is being done.
[[nodiscard]] std::vector<TrackCaseRow> run_scenario(const TrackRequest& request, const holdfast::Motion& truth,
                                                     const std::function<void(const std::string&)>& tell);

}  // namespace swimlab
