// The map of a layer: what ReadStateMap sends, one part after the other.
#pragma once

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "core/view/node_summary.h"
#include "core/view/state_axes.h"
#include "server/engine/query/model_query.h"

namespace motiondb::server {

// Used by one thread at a time.
class StateMap {
 public:
  // `max_points`: frames to show, spread evenly; at most 100,000 are. Codes: those of FindLayer and
  // ModelView::Axes; INVALID_ARGUMENT naming max_points.
  static absl::StatusOr<std::shared_ptr<StateMap>> Open(Engine& engine, const LayerRequest& request,
                                                        int max_points, const WorkOptions& terms);
  StateMap(const StateMap&) = delete;
  StateMap& operator=(const StateMap&) = delete;

  const Snapshot& snapshot() const { return *layer_.snapshot; }
  const core::Model& model() const { return layer_.model(); }
  // Version of the model; 0: it is not stored yet.
  int model_version() const;
  const core::StateAxes& axes() const { return *axes_; }
  int layer() const { return layer_.layer; }
  const TransitionList& transitions() const { return transitions_; }
  int node_count() const { return static_cast<int>(nodes_.size()); }
  int point_count() const { return static_cast<int>(points_.size()); }

  // Returns the next nodes: at most `max_count`, with so few frames that summarizing them is short
  // work. Empty: there are no more; also below.
  std::span<const int> TakeNodes(std::size_t max_count);
  core::NodeSummary Summarize(int node) { return summaries_.Summarize(layer_.layer, node); }
  // Returns the first and the end of the next edges of transitions().
  std::pair<int, int> TakeTransitions(int max_count);
  // Returns the next frames of the model.
  std::span<const int> TakePoints(std::size_t max_count);

 private:
  StateMap(ModelLayer layer, std::shared_ptr<const core::StateAxes> axes, int max_points);

  const ModelLayer layer_;
  const std::shared_ptr<const core::StateAxes> axes_;
  const std::vector<int> nodes_;
  const TransitionList transitions_;
  const std::vector<int> points_;
  core::NodeSummaries summaries_;
  std::size_t node_ = 0;
  int edge_ = 0;
  std::size_t point_ = 0;
};

}  // namespace motiondb::server
