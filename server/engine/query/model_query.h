// Reads models: their statistics, and the nodes, poses, transitions and map of a layer.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "core/model/build_settings.h"
#include "core/view/model_picture.h"
#include "storage/records.h"

namespace motiondb::core {
struct ClipGraph;
class Model;
class TransitionGraph;
}  // namespace motiondb::core

namespace motiondb::server {

class Engine;
struct Snapshot;
struct WorkOptions;

// Statistics of models. `current`: the current model of the database; null: none.
struct ListedModels {
  std::vector<storage::ModelRecord> records;  // newest first
  core::BuildSettings settings;
  std::shared_ptr<const Snapshot> current;
};

// Returns one model; `version` 0: the current one. NOT_FOUND; FAILED_PRECONDITION if there is none.
absl::StatusOr<ListedModels> DescribeModel(Engine& engine, const std::string& database, int version,
                                           const WorkOptions& terms);

// Returns at most `limit` stored models below version `before`; 0: from the newest. NOT_FOUND.
absl::StatusOr<ListedModels> ListStoredModels(Engine& engine, const std::string& database,
                                              int before, int limit, const WorkOptions& terms);

// Identifies a model. The version does not suffice, because a model that is not stored yet has the
// version of an earlier one.
struct ModelStamp {
  int version = 0;
  std::int64_t create_time_us = 0;  // 0: none
};

ModelStamp StampOf(const Snapshot& snapshot);

// Returns the current model, by name (`version` 0) or version. Older models cannot be read:
// NOT_FOUND, or FAILED_PRECONDITION with reason MODEL_SUPERSEDED. FAILED_PRECONDITION if there is
// no model.
absl::StatusOr<std::shared_ptr<const Snapshot>> FindReadableModel(Engine& engine,
                                                                  const std::string& database,
                                                                  int version,
                                                                  const WorkOptions& terms);

// A layer to read, of all clips or of one.
struct LayerRequest {
  std::string database;
  int version = 0;   // of the model; 0: the current one
  int layer = 0;     // 0: the bottom layer
  std::string clip;  // id; empty: all
  // The model that the list began with; none: it begins.
  ModelStamp listed = {};
};

struct ModelLayer {
  std::shared_ptr<const Snapshot> snapshot;
  int layer = 0;
  int clip = -1;  // index into Model::clips(); -1: all

  const core::Model& model() const;
};

// Codes: those of FindReadableModel; ABORTED with reason MODEL_REPLACED if the model is not the one
// that the list began with; INVALID_ARGUMENT naming the layer; NOT_FOUND with reason
// CLIP_NOT_FOUND.
absl::StatusOr<ModelLayer> FindLayer(Engine& engine, const LayerRequest& request,
                                     const WorkOptions& terms);

struct NodePose {
  int node = 0;
  core::MeanPose pose;
};

struct NodePoses {
  int layer = 0;
  std::vector<NodePose> poses;
};

// Returns the mean poses of nodes, at most 1000 and 3 MiB. Codes: those of FindLayer;
// INVALID_ARGUMENT naming node_ids.
absl::StatusOr<NodePoses> ReadNodePoses(Engine& engine, const LayerRequest& request,
                                        std::span<const int> nodes, const WorkOptions& terms);

// A transition between nodes of a layer.
struct Transition {
  int from = 0;
  int to = 0;
  std::int32_t count = 0;
  double probability = 0;
};

// The transitions of a layer, of all clips or of one clip, in order of (from, to).
class TransitionList {
 public:
  // The model must outlive the list.
  explicit TransitionList(const ModelLayer& layer);

  int edge_count() const;
  Transition At(int edge) const;

 private:
  const std::shared_ptr<const core::ClipGraph> clip_;  // null: global graph
  const core::TransitionGraph& graph_;
};

// The map of a layer: what ReadStateMap sends, one part after the other. Used by one thread at a
// time.
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
