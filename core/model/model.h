// A model: what one database knows at one version. Immutable once made, so queries share it freely
// and keep scratch of their own.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/graph/transition_graph.h"
#include "core/model/build_settings.h"
#include "core/model/clip_index.h"
#include "core/model/familiarity.h"
#include "core/model/metric_frames.h"
#include "core/model/motion_metric.h"
#include "core/model/motion_prior.h"
#include "core/model/prediction_confidence.h"
#include "core/model/recognition_calibration.h"
#include "core/model/rigid_tree.h"
#include "core/model/shared_rows.h"
#include "core/motion/states.h"
#include "core/tree/feature_scale.h"
#include "core/tree/node_gaussians.h"
#include "core/tree/parallel.h"
#include "core/tree/tree.h"

namespace motiondb::core {

// A clip as the model knows it: a run of frames.
struct ModelClip {
  std::string id;
  std::string label;
  std::int32_t first_frame = 0;
  std::int32_t frame_count = 0;
  double leg_length_m = 0;
  std::string subject;  // empty where it is not known
  // Frames of glitches that were kept, from 0 at first_frame; in order and apart.
  std::vector<FrameSpan> glitches = {};

  // Whether one is in any of the model's frames first ... last.
  bool HasGlitch(int first, int last) const;
};

// Everything a model is made of, as a builder makes it and a store gives it back.
struct ModelParts {
  BuildSettings settings;
  MarkerSet marker_set;
  std::vector<ModelClip> clips;  // in frame order, without gaps
  // The first so many clips are those that the model was built from, the others were added since
  // (core/model/extend_model.h). -1: all.
  std::int32_t built_clip_count = -1;
  SharedRows states;   // frames x 6 N_v, scaled
  RootPath root_path;  // frames x 3
  FeatureScale scale;  // what states were divided by
  Tree tree;
  NodeGaussians gaussians;                                    // one for each branch of the tree
  std::vector<TransitionGraph> global_graphs;                 // [layer - 1]
  std::vector<std::shared_ptr<const ClipGraph>> clip_graphs;  // [clip], on the bottom layer
  FamiliarityReference familiarity;
  MotionPrior prior;
  // What `prior` was fitted to, for the calibration of a built model; it is not stored.
  std::shared_ptr<const MotionSums> prior_sums;
  MotionMetric metric;
  RecognitionCalibration recognition;
  PredictionConfidence confidence;
  double build_seconds = 0;  // set by whoever holds the clock
};

class Model {
 public:
  // DATA_LOSS if the parts do not fit each other. What is derived from them is made on the threads
  // that are lent.
  static absl::StatusOr<Model> Create(ModelParts parts, const ParallelFor& parallel = RunSerially);
  // The same for a model that extends `base`: what was derived from base's frames is shared.
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
  // That on the bottom layer is kept, those on others are put together from it.
  std::shared_ptr<const ClipGraph> clip_graph(int layer, int clip) const;
  const FamiliarityReference& familiarity() const { return parts_.familiarity; }
  const MotionPrior& prior() const { return parts_.prior; }
  const MotionMetric& metric() const { return parts_.metric; }
  const MetricFrames& metric_frames() const { return metric_frames_; }
  const ClipIndex& clip_index() const { return clip_index_; }
  const RecognitionCalibration& recognition() const { return parts_.recognition; }
  // For the calibration, before the model is shared.
  void set_recognition(RecognitionCalibration recognition) {
    parts_.recognition = std::move(recognition);
  }
  const PredictionConfidence& confidence() const { return parts_.confidence; }
  // For the calibration, before the model is shared.
  void set_confidence(PredictionConfidence confidence) {
    parts_.confidence = std::move(confidence);
    parts_.prior_sums.reset();
  }
  const RigidTree& rigid_tree() const { return rigid_tree_; }
  // Index of each marker's other side; empty where the markers have no sides.
  const std::vector<int>& other_sides() const { return other_sides_; }
  double build_seconds() const { return parts_.build_seconds; }
  // For whoever holds the clock, before the model is shared.
  void set_build_seconds(double seconds) { parts_.build_seconds = seconds; }
  const ModelParts& parts() const { return parts_; }

  int frame_count() const { return static_cast<int>(parts_.states.rows()); }
  // Clips and frames that the model was built from; the others were added since.
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
  // Index into clips() of the clip that holds a frame. O(log clips).
  int clip_of_frame(int frame) const;
  // Whether a kept glitch is in any of the frames first ... last, which are of one clip.
  bool HasGlitch(int first, int last) const;
  // The layer that a request means: 0 is the bottom. OUT_OF_RANGE names the layers there are.
  absl::StatusOr<int> ResolveLayer(int layer) const;

 private:
  Model(ModelParts parts, const MetricFrames& known, const ParallelFor& parallel);
  ModelParts parts_;
  MetricFrames metric_frames_;
  ClipIndex clip_index_;
  RigidTree rigid_tree_;
  std::vector<int> other_sides_;
};

}  // namespace motiondb::core
