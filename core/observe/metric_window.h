// The frames of a moving window, projected into the recognition metric, and their distances to
// stored clips. Each is computed once. Not thread-safe.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "core/observe/observed_states.h"
#include "core/recognition/clip_alignment.h"
#include "core/recognition/shortlist.h"

namespace motiondb::core {

class ClipMask;
class Model;

struct MetricFrame {
  // Version of its input: it is recomputed when the frame is finished.
  std::int64_t version = -1;
  bool has_near = false;          // `near` has been found
  FrameMatrix state;              // 1 x D, scaled; missing values are filled in
  Eigen::VectorXf projected;      // K
  float squared_norm = 0;         // of `projected`
  std::vector<NearClip> near;     // clips with near nodes; empty if all clips are listed
  int nearest = -1;               // the stored frame of `squared_difference`
  double squared_difference = 0;  // whitened, summed over the dimensions
};

class MetricWindow {
 public:
  // The model must have a metric. `mask`: the clips to use; null: all. Both must outlive this
  // object. `window_frames`: maximum length.
  MetricWindow(const Model& model, const ClipMask* mask, int window_frames);

  // Returns a frame of the window that ends with the newest of `states`; without `near`, unless it
  // was found before.
  const MetricFrame& Projected(const ObservedStates& states, std::int64_t frame);
  // Returns the same with `near`.
  const MetricFrame& At(const ObservedStates& states, std::int64_t frame);
  // Returns a frame that At has returned before.
  const MetricFrame& Kept(std::int64_t frame) const { return frames_[Place(frame)]; }
  // Returns a frame's squared whitened difference from the NearestState of a stored frame, summed
  // over the dimensions.
  double SquaredDifference(std::int64_t frame, int stored_frame);
  void Restart();

 private:
  std::size_t Place(std::int64_t frame) const {
    return static_cast<std::size_t>(frame) % frames_.size();
  }
  void Make(const ObservedStates& states, std::int64_t frame, MetricFrame& made);
  void FindNear(MetricFrame& made);

  const Model& model_;
  const ClipMask* const mask_;
  const ClipIndex& index_;  // of the allowed clips
  NearClipFinder finder_;
  std::vector<MetricFrame> frames_;  // ring: index is the frame number % size
  Eigen::RowVectorXf distances_;
  Eigen::RowVectorXf difference_;
  Eigen::RowVectorXf whitened_;
};

// Distances of one stored clip to the frames of a moving window, each computed once. Not
// thread-safe.
class Model;

class CachedClip {
 public:
  // Starts with another clip of the model. `window_frames`: maximum length of a window.
  void Take(const Model& model, int clip, int window_frames);
  int clip() const { return clip_; }

  // Compares the clip with a frame of the window (`ring`: its number % window frames), unless done
  // before. Returns the clip's nearest frame.
  const NearestFrame& Compare(const Model& model, std::size_t ring, const MetricFrame& frame);

  // As AlignToClip of `rows` of the clip for the frames at `rings`, in order, all of them compared.
  // Returns false if the result is inexact and AlignToClip is needed. `paths` is scratch.
  bool LogEvidence(RowRange rows, std::span<const std::size_t> rings, PathSum& paths,
                   double& log_evidence) const;
  // Returns an upper bound of LogEvidence of any `count` rows.
  double LogEvidenceBound(int count, std::span<const std::size_t> rings) const;

  std::int64_t last_used = 0;  // used by the owner

 private:
  int clip_ = -1;
  int first_row_ = 0;
  std::vector<std::int64_t> version_;  // of the frame at each index of the ring
  std::vector<NearestFrame> nearest_;
  Eigen::ArrayXXf roots_;  // clip's frames x ring: PathSum::Roots
  Eigen::ArrayXf distances_;
};

}  // namespace motiondb::core
