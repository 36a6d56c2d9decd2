// Converts models, nodes, transitions and states to messages.
#pragma once

#include <memory>

#include "core/graph/transition_graph.h"
#include "server/engine/snapshot.h"

namespace motiondb::core {
class Model;
}  // namespace motiondb::core

namespace motiondb::v1 {
class Model;
class Node;
class Transition;
class ReadStatesResponse;
}  // namespace motiondb::v1

namespace motiondb::server {

// Sets the statistics of a stored or current model. `snapshot` is the current model of the
// database, or null.
void SetModel(const storage::ModelRecord& record, const core::BuildSettings& settings,
              const Snapshot* snapshot, v1::Model& message);

// REQUIRES: `layer` and `node` are in the model.
void SetNode(const core::Model& model, int layer, int node, v1::Node& message);

// Sets the states of the frames [first_frame, end_frame).
void SetStates(const core::Model& model, int first_frame, int end_frame,
               v1::ReadStatesResponse& message);

// The transitions of a layer, of all clips or of one clip, in order of (from, to).
class TransitionList {
 public:
  // `clip`: index into Model::clips(), or -1 for the global graph. The model must outlive the list.
  TransitionList(const core::Model& model, int layer, int clip);

  int edge_count() const { return graph_.edge_count(); }
  void SetTransition(int edge, v1::Transition& message) const;

 private:
  int NodeOf(int state) const { return clip_ == nullptr ? state : clip_->nodes[state]; }

  const std::shared_ptr<const core::ClipGraph> clip_;  // null: global graph
  const core::TransitionGraph& graph_;
};

}  // namespace motiondb::server
