// The frames of a moving window as recognition compares them with stored motion, each worked on
// once. Not thread-safe.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "core/observe/observed_states.h"
#include "core/recognition/clip_alignment.h"
#include "core/recognition/shortlist.h"

namespace motiondb::core {

class Model;

struct MetricFrame {
  // Of what it was made: it is made anew once the frame is finished.
  std::int64_t version = -1;
  FrameMatrix state;              // 1 x D, scaled; what was missing is filled in
  Eigen::VectorXf projected;      // K
  float squared_norm = 0;         // of it
  std::vector<NearClip> near;     // clips whose nodes it comes near; none where all are listed
  int nearest = -1;               // the stored frame that `difference` is to
  double squared_difference = 0;  // whitened, summed over the dimensions
};

class MetricWindow {
 public:
  // The model, which has a metric, must outlive it. A window has at most so many frames.
  MetricWindow(const Model& model, int window_frames);

  // A frame of the window that ends with the newest of `states`.
  const MetricFrame& At(const ObservedStates& states, std::int64_t frame);
  // One that At gave.
  const MetricFrame& Kept(std::int64_t frame) const { return frames_[Place(frame)]; }
  // Its squared whitened difference to a stored frame, summed over the dimensions.
  double SquaredDifference(std::int64_t frame, int stored_frame);
  void Restart();

 private:
  std::size_t Place(std::int64_t frame) const {
    return static_cast<std::size_t>(frame) % frames_.size();
  }
  void Make(const ObservedStates& states, std::int64_t frame, MetricFrame& made);

  const Model& model_;
  NearClipFinder finder_;
  std::vector<MetricFrame> frames_;  // a frame is at its number % size
  Eigen::RowVectorXf distances_;
  Eigen::RowVectorXf difference_;
  Eigen::RowVectorXf whitened_;
};

// One stored clip beside the frames of a moving window: each distance is computed once. Not
// thread-safe.
class Model;

class KeptClip {
 public:
  // Takes a clip of the model, and forgets what it had. A window has at most so many frames.
  void Take(const Model& model, int clip, int window_frames);
  int clip() const { return clip_; }

  // Sees the window's frame (`ring`: its number % the window's frames), if it has not yet, and says
  // which of the clip's frames is nearest.
  const NearestFrame& See(const Model& model, std::size_t ring, const MetricFrame& frame);

  // As AlignToClip for the frames at `rings`, in their order, all of them seen. False where only
  // AlignToClip itself can tell; `paths` is scratch.
  bool LogEvidence(std::span<const std::size_t> rings, PathSum& paths, double& log_evidence) const;
  // It is at most this.
  double LogEvidenceAtMost(std::span<const std::size_t> rings) const;

  std::int64_t last_asked = 0;  // for its owner

 private:
  int clip_ = -1;
  std::vector<std::int64_t> version_;  // of the frame seen at each place of the ring
  std::vector<NearestFrame> nearest_;
  Eigen::ArrayXXf roots_;  // clip's frames x ring: PathSum::Roots
  Eigen::ArrayXf distances_;
};

}  // namespace motiondb::core
