// The model of a database at one version: tree, statistics, graphs and stored states. Immutable, so
// queries share it.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/graph/transition_graph.h"
#include "core/model/answer_calibration.h"
#include "core/model/build_settings.h"
#include "core/model/familiarity.h"
#include "core/model/label_tracks.h"
#include "core/model/marker_distances.h"
#include "core/model/metric_frames.h"
#include "core/model/motion_metric.h"
#include "core/model/motion_prior.h"
#include "core/model/shared_rows.h"
#include "core/motion/execution.h"
#include "core/motion/states.h"
#include "core/tree/feature_scale.h"
#include "core/tree/node_gaussians.h"
#include "core/tree/tree.h"

namespace motiondb::core {

// A clip of a model: consecutive frames.
struct ModelClip {
  std::string id;
  LabelTracks labels;
  std::int32_t first_frame = 0;
  std::int32_t frame_count = 0;
  double leg_length_m = 0;
  std::string subject;  // empty: unknown
  // Frames of kept glitches, relative to first_frame; ascending and disjoint.
  std::vector<FrameSpan> glitches = {};

  // Label of the span of kActionTrack that covers the clip; empty if there is none.
  const std::string& label() const { return labels.Whole(frame_count); }
  // Returns whether the model's frames first to last contain a glitch.
  bool HasGlitch(int first, int last) const;
};

// The labels and the subject of a clip.
struct ClipLabels {
  LabelTracks labels;
  std::string subject;
};

// The parts of a model: result of a build and content of the store.
struct ModelParts {
  BuildSettings settings;
  MarkerSet marker_set;
  std::vector<ModelClip> clips;  // in frame order, without gaps
  // Number of clips in the build; the rest were added by extensions (core/model/model_builder.h).
  // -1: all.
  std::int32_t built_clip_count = -1;
  SharedRows states;   // frames x 6 N_v, scaled
  RootPath root_path;  // frames x 3
  FeatureScale scale;  // divisor of the states
  Tree tree;
  NodeGaussians gaussians;                                    // one for each branch of the tree
  std::vector<TransitionGraph> global_graphs;                 // [layer - 1]
  std::vector<std::shared_ptr<const ClipGraph>> clip_graphs;  // [clip], on the bottom layer
  FamiliarityReference familiarity;
  MotionPrior prior;
  // Sums from which `prior` was fitted, for the calibration after a build; not stored.
  std::shared_ptr<const MotionSums> prior_sums;
  MotionMetric metric;
  RecognitionCalibration recognition;
  PredictionConfidence confidence;
  double build_seconds = 0;  // set by the caller, which has the clock
};

class LabelUnits;

class Model {
 public:
  // DATA_LOSS if the parts are inconsistent. Derived data is computed with `parallel`.
  static absl::StatusOr<Model> Create(ModelParts parts, const ParallelFor& parallel = RunSerially);
  // As above for an extension of `base`. Shares the derived data of `base`.
  static absl::StatusOr<Model> Create(ModelParts parts, const Model& base);

  const BuildSettings& settings() const { return parts_.settings; }
  const MarkerSet& marker_set() const { return parts_.marker_set; }
  const std::vector<ModelClip>& clips() const { return parts_.clips; }
  // Frames x 6 N_v, scaled.
  Eigen::Map<const FrameMatrix> states() const { return parts_.states.view(); }
  const RootPath& root_path() const { return parts_.root_path; }
  const FeatureScale& scale() const { return parts_.scale; }
  const Tree& tree() const { return parts_.tree; }
  const NodeGaussians& gaussians() const { return parts_.gaussians; }
  const TransitionGraph& global_graph(int layer) const { return parts_.global_graphs[layer - 1]; }
  // Returns the stored graph for the bottom layer; graphs of other layers are computed from it.
  std::shared_ptr<const ClipGraph> clip_graph(int layer, int clip) const;
  const FamiliarityReference& familiarity() const { return parts_.familiarity; }
  const MotionPrior& prior() const { return parts_.prior; }
  const MotionMetric& metric() const { return parts_.metric; }
  const MetricFrames& metric_frames() const { return metric_frames_; }
  const ClipIndex& clip_index() const { return clip_index_; }
  const RecognitionCalibration& recognition() const { return parts_.recognition; }
  // REQUIRES: the model is not yet shared.
  void set_recognition(RecognitionCalibration recognition) {
    parts_.recognition = std::move(recognition);
  }
  const PredictionConfidence& confidence() const { return parts_.confidence; }
  // REQUIRES: the model is not yet shared.
  void set_confidence(PredictionConfidence confidence) {
    parts_.confidence = std::move(confidence);
    parts_.prior_sums.reset();
  }
  const RigidTree& rigid_tree() const { return rigid_tree_; }
  // Index of each marker's counterpart on the other side; empty if the markers have no sides.
  const std::vector<int>& other_sides() const { return other_sides_; }
  double build_seconds() const { return parts_.build_seconds; }
  // REQUIRES: the model is not yet shared.
  void set_build_seconds(double seconds) { parts_.build_seconds = seconds; }
  // Returns the model with new labels and subjects, one for each clip. Recognition then names the
  // new labels; metric and calibration stay those learned from the old ones until RefitLabels
  // (core/calibration/calibrate.h) or a build. Shares the stored states; copies the rest.
  // INVALID_ARGUMENT as LabelTracks::Check, naming the clip, or if the number of clips differs.
  absl::StatusOr<Model> WithLabels(std::vector<ClipLabels> labels) const;
  const ModelParts& parts() const { return parts_; }
  // Returns the parts of a model that is no longer used.
  ModelParts TakeParts() && { return std::move(parts_); }

  // Units of kActionTrack; UnitsOf (core/model/label_units.h) also returns those of other tracks.
  const std::shared_ptr<const LabelUnits>& action_units() const { return action_units_; }

  int frame_count() const { return static_cast<int>(parts_.states.rows()); }
  // Clips and frames of the build; the rest were added by extensions.
  int built_clip_count() const {
    return parts_.built_clip_count < 0 ? static_cast<int>(parts_.clips.size())
                                       : parts_.built_clip_count;
  }
  int built_frame_count() const {
    return built_clip_count() == static_cast<int>(parts_.clips.size())
               ? frame_count()
               : parts_.clips[built_clip_count()].first_frame;
  }
  int layer_count() const { return parts_.tree.layer_count(); }
  // Returns the index into clips() of the clip of a frame. O(log clips).
  int clip_of_frame(int frame) const;
  // Returns whether the frames first to last of one clip contain a kept glitch.
  bool HasGlitch(int first, int last) const;
  // Returns the layer of a request; 0 is the bottom layer. OUT_OF_RANGE if it does not exist.
  absl::StatusOr<int> ResolveLayer(int layer) const;

 private:
  Model(ModelParts parts, const MetricFrames& known, const ParallelFor& parallel);
  ModelParts parts_;
  MetricFrames metric_frames_;
  ClipIndex clip_index_;
  RigidTree rigid_tree_;
  std::vector<int> other_sides_;
  std::shared_ptr<const LabelUnits> action_units_;
};

}  // namespace motiondb::core
