/// T_AB of one pair of frames, resolved once and evaluated every frame.
///
/// Source: Robinett & Holloway 1994, section 6.1 (course 11): "the leftmost five transforms are static and can
/// therefore be precomputed once". A Chain folds every run of static edges into one transform and keeps the dynamic
/// edges between them:
///   T_AB(t) = S_0 D_1(t) S_1 D_2(t) ... D_n(t) S_n.
/// Making one allocates; `at` does not, and neither locks nor throws. A chain points to its graph, which must outlive
/// it. When an edge of the graph is added, removed or set, `at` answers `stale_chain`: make the chain again. New
/// samples do not make it stale.
#pragma once

#include <cstddef>
#include <cstdint>
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
    for (const PathStep& step : *path) append(step);
    transforms_ = path->size();
  }

  /// T_AB at time t.
  [[nodiscard]] Lookup at(HostTime t) const {
    Lookup result;
    result.status = status_;
    if (status_ != LookupStatus::ok) return result;
    if (version_ != graph_->version()) {
      result.status = LookupStatus::stale_chain;
      return result;
    }
    Vqs T = last_;
    bool is_identity = !last_counts_;
    for (std::size_t i = links_.size(); i-- > 0;) {
      const Link& link = links_[i];
      const PoseHistory::Sample sample = graph_->edge(link.edge)->history.at(t);
      detail::take_in(result, sample, link.edge);
      if (!result) return result;
      const Vqs D = link.inverted ? sample.T_AB.inverse() : sample.T_AB;
      T = is_identity ? D : D * T;
      if (link.static_counts) T = link.static_before * T;
      is_identity = false;
    }
    result.T_AB = T;
    return result;
  }

  /// Edges of the path, and how many of them are dynamic and hence evaluated by `at`.
  [[nodiscard]] std::size_t transforms() const { return transforms_; }
  [[nodiscard]] std::size_t dynamic_transforms() const { return links_.size(); }
  /// False when the graph has changed since, or there was no path: `at` will not give a transform.
  [[nodiscard]] bool valid() const { return status_ == LookupStatus::ok && version_ == graph_->version(); }

 private:
  /// One dynamic edge and the folded static run to its left.
  struct Link {
    Vqs static_before;
    EdgeId edge;
    bool inverted = false;
    bool static_counts = false;
  };

  void append(const PathStep& step) {
    const FrameGraph::Edge& e = *graph_->edge(step.edge);
    if (e.kind == EdgeKind::dynamic) {
      links_.push_back({last_, step.edge, step.inverted, last_counts_});
      last_ = Vqs();
      last_counts_ = false;
      return;
    }
    last_ = last_ * (step.inverted ? e.T_AB.inverse() : e.T_AB);
    last_counts_ = true;
  }

  const FrameGraph* graph_ = nullptr;
  std::uint64_t version_ = 0;
  std::vector<Link> links_;
  Vqs last_;                  // the static run at the right end
  bool last_counts_ = false;  // it is more than the identity
  std::size_t transforms_ = 0;
  LookupStatus status_ = LookupStatus::no_path;
};

inline Chain FrameGraph::chain(FrameId A, FrameId B) const {
  return Chain(*this, A, B);
}

}  // namespace holdfast
