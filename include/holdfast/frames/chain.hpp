/// T_AB of one pair of frames, resolved once and evaluated every frame.
///
/// Source: Robinett & Holloway 1994, section 6.1 (course 11): "the leftmost five transforms are static and can
/// therefore be precomputed once". A Chain keeps the folded static runs at both ends and where its dynamic edges hang,
/// so that `at` neither searches nor checks what cannot have changed. Asked first at a time, `at` evaluates those edges
/// in one sweep; asked again at that time, by any chain or lookup of the graph, it uses what the graph remembers, as
/// `lookup` does. `at` does not allocate, lock or throw. A chain points to its graph, which must outlive it, and shares
/// its thread. When an edge of the graph is added, removed or set, `at` answers `stale_chain`: make the chain again.
/// New samples do not make it stale.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <holdfast/frames/graph.hpp>

namespace holdfast {

class Chain {
 public:
  /// A chain of no graph; `at` answers no_path.
  Chain() = default;

  /// When there is no path, `at` answers `no_path` or `unknown_frame` as the graph's lookup does.
  Chain(const FrameGraph& graph, FrameId A, FrameId B) : graph_(&graph), version_(graph.version()) {
    if (!graph.contains(A) || !graph.contains(B)) {
      status_ = LookupStatus::unknown_frame;
      return;
    }
    const std::optional<std::vector<PathStep>> path = graph.path(A, B);
    if (!path) return;
    status_ = LookupStatus::ok;
    transforms_ = path->size();
    A_ = A;
    B_ = B;
    resolve(*path);
  }

  /// T_AB at time t.
  [[nodiscard]] Lookup at(HostTime t) const {
    if (!valid()) return refusal();
    if (graph_->asked_t_ == t) return graph_->lookup(A_, B_, t);  // others ask at this time too: share with them
    graph_->asked_t_ = t;
    Lookup result;
    detail::RawVqs T = T_C_B_;
    for (std::size_t begin = 0; begin < steps_.size(); begin += block) {
      const std::size_t end = std::min(begin + block, steps_.size());
      if (!apply(begin, end, t, result, T)) return graph_->lookup(A_, B_, t);
    }
    result.T_AB = to_vqs(T);
    return result;
  }

  /// Edges of the path, and how many of them are dynamic and hence evaluated by `at`.
  [[nodiscard]] std::size_t transforms() const { return transforms_; }
  [[nodiscard]] std::size_t dynamic_transforms() const { return steps_.size(); }
  /// False when the graph has changed since, or there was no path: `at` will not give a transform.
  [[nodiscard]] bool valid() const { return status_ == LookupStatus::ok && version_ == graph_->version(); }

 private:
  /// A dynamic edge with the static run on its left: T_static T_edge, or T_static T_edge^-1.
  struct Step {
    const PoseHistory* history;  // stays in its place while the chain is valid
    EdgeId edge;
    bool inverted;
    bool has_static;
    detail::RawVqs T_static;
  };

  /// So many edges are interpolated one after another before any is multiplied. By turns it takes half as long again:
  /// the processor then waits for each product before it looks at the next history.
  static constexpr std::size_t block = 8;

  /// T = (steps begin to end, exclusive) T; false when a transform of theirs is not known.
  bool apply(std::size_t begin, std::size_t end, HostTime t, Lookup& result, detail::RawVqs& T) const {
    std::array<detail::RawVqs, block> T_edge;
    for (std::size_t i = begin; i < end; ++i) {
      const PoseHistory::RawSample sample = steps_[i].history->at(t, T_edge[i - begin]);
      if (sample.status == SampleStatus::interpolated) continue;
      if (sample.status != SampleStatus::held) return false;
      detail::take_in(result, sample.age, LookupStatus::held, steps_[i].edge);
    }
    for (std::size_t i = begin; i < end; ++i) {
      const Step& step = steps_[i];
      const detail::RawVqs& T_i = T_edge[i - begin];
      if (step.inverted) {
        divide(T_i, T, T);
      } else if (i == 0 && !ends_static_) {
        T = T_i;
      } else {
        multiply(T_i, T, T);
      }
      if (step.has_static) multiply(step.T_static, T, T);
    }
    return true;
  }

  void resolve(const std::vector<PathStep>& path) {
    detail::RawVqs run = Vqs();
    bool has_run = false;
    for (const PathStep& step : path) {
      const FrameGraph::Edge& edge = *graph_->edge(step.edge);
      if (edge.kind == EdgeKind::dynamic) {
        steps_.push_back({&edge.history, step.edge, step.inverted, has_run, run});
        run = Vqs();
        has_run = false;
      } else {
        multiply(run, step.inverted ? edge.T_AB.inverse() : edge.T_AB, run);
        run = to_vqs(run);
        has_run = true;
      }
    }
    T_C_B_ = run;
    ends_static_ = has_run;
    std::reverse(steps_.begin(), steps_.end());
  }

  [[nodiscard]] Lookup refusal() const {
    Lookup result;
    result.status = status_ == LookupStatus::ok ? LookupStatus::stale_chain : status_;
    return result;
  }

  const FrameGraph* graph_ = nullptr;
  std::uint64_t version_ = 0;
  FrameId A_, B_;
  std::vector<Step> steps_;       // B's first
  detail::RawVqs T_C_B_ = Vqs();  // the static run at B's end
  bool ends_static_ = false;      // there is one
  std::size_t transforms_ = 0;
  LookupStatus status_ = LookupStatus::no_path;
};

inline Chain FrameGraph::chain(FrameId A, FrameId B) const {
  return Chain(*this, A, B);
}

}  // namespace holdfast
