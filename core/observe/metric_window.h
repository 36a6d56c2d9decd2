// The frames of a moving window as recognition compares them with stored motion, each worked on
// once. Not thread-safe.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/observe/observed_states.h"
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

}  // namespace motiondb::core
