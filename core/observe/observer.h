// Online queries on a stream of frames: current node, labels, familiarity and prediction. Each
// frame is processed on arrival, and answers refer to a moving window. So the cost of a frame does
// not depend on the length of the stream, and memory is bounded by the window.
//
// One thread at a time for each observer. The model must outlive its observers, or be replaced.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/inference/lattice.h"
#include "core/model/build_settings.h"
#include "core/motion/execution.h"
#include "core/motion/marker_set.h"
#include "core/motion/matrix.h"
#include "core/observe/node_filter.h"
#include "core/observe/observed_states.h"
#include "core/observe/window_recognizer.h"
#include "core/prediction/predict.h"
#include "core/recognition/recognize.h"

namespace motiondb::core {

class ClipMask;
class Model;

struct ObserverOptions {
  double window_seconds = 0.4;          // for labels and familiarity
  double history_seconds = 0.4;         // prediction
  std::vector<double> horizon_seconds;  // empty: no prediction
  int layer = 0;                        // of the node estimate; 0: the bottom layer
  double transition_floor = 1e-6;
  std::shared_ptr<const ClipMask> mask = nullptr;  // clips to use; null: all. See Replace.
  std::string track = {};                          // of the labels; empty: kActionTrack
};

// INVALID_ARGUMENT, naming the field, if an option is out of range for models of these settings.
absl::Status CheckOptions(const ObserverOptions& options, const BuildSettings& settings);

struct Observed {
  std::int64_t frame = 0;  // number of the newest frame in the answer
  int layer = 0;
  NodeState state;                 // the most probable current node, given all frames so far
  std::vector<LabelScore> labels;  // most probable first
  std::optional<double> unknown_probability;  // as RecognizedWindow::unknown_probability
  double familiarity = 0;                     // as RecognizedWindow::familiarity
  std::vector<PredictedFrame> horizons;       // in the order of the request
  std::vector<TrackAnswer> other_tracks;      // as RecognizedWindow::other_tracks
};

class Observer {
 public:
  // `marker_names` and `frame_rate_hz` describe the incoming frames. The scheme, of the model's
  // marker set, maps them to the model's markers. Other frame rates are resampled
  // (observed_states.h). Without `leg_length_m`, it is the median over the first second, and
  // estimated from the frames so far until then. INVALID_ARGUMENT for options out of range (naming
  // the field), another marker set, or names without a mapping; OUT_OF_RANGE for an unknown layer.
  static absl::StatusOr<std::unique_ptr<Observer>> Create(
      const Model& model, const MarkerScheme& scheme, const std::vector<std::string>& marker_names,
      double frame_rate_hz, std::optional<double> leg_length_m, const ObserverOptions& options);

  // Adds frames numbered first_frame, first_frame + 1, ...: frames x 3 markers, m, world, z up; a
  // marker with any NaN is missing. Frames not newer than the newest are late: ignored and counted.
  // Skipped numbers count as frames without markers; a gap longer than the window restarts the
  // observation. INVALID_ARGUMENT, without adding frames, if the width does not fit the names, a
  // number is infinite or beyond 100 km, or frame numbers overflow. CANCELLED, with some of the
  // frames added. Does not allocate after the first second for complete frames at the model's rate.
  absl::Status Append(std::int64_t first_frame, const FrameMatrix& positions_m,
                      const Cancelled& cancelled = {});

  // Returns the answer for the frames so far; nullopt until a frame has both hips and the leg
  // length is known. Labels and familiarity are those of Recognize for the last `window_seconds`,
  // horizons those of Predict for the last `history_seconds`. CANCELLED.
  absl::StatusOr<std::optional<Observed>> Answer(const Cancelled& cancelled = {});

  // Switches to another model of the same database. The kept frames (window, at least one second)
  // are processed again with it, as if they were the first. `mask`: clips of the new model to use;
  // null: all. If the model lacks the requested layer,
  // its bottom layer is used, see Observed::layer. INVALID_ARGUMENT, without any change, for
  // another marker set or frame rate.
  absl::Status Replace(const Model& model, std::shared_ptr<const ClipMask> mask = nullptr);

  std::int64_t late_frames() const { return late_frames_; }
  // Number of skipped frame numbers.
  std::int64_t missing_frames() const { return missing_frames_; }
  // Number of kept frames, at the model's rate, that Replace processes again.
  int kept_frames() const { return states_.kept(); }
  // Leg length (m); absent until it is known.
  std::optional<double> leg_length_m() const;
  // Positions of the newest frame of the answer, 3 for each marker of the model (m, world; NaN:
  // missing); absent until there is one.
  std::optional<Eigen::RowVectorXf> NewestPositions() const;

 private:
  Observer(const Model& model, MarkerSet set, MarkerStream stream, double frame_rate_hz,
           std::optional<double> leg_length_m, const ObserverOptions& options, int layer);

  absl::Status Check(std::int64_t first_frame, const FrameMatrix& positions_m) const;
  // Handles frame numbers between the newest frame and `number`.
  void PassGap(std::int64_t number);
  void RestartStream();
  void Forget();
  void UseModel(const Model& model, std::shared_ptr<const ClipMask> mask, int layer);
  // Processes the frames that the stream has ready.
  void ProcessReady();
  void Process(const Eigen::Ref<const Eigen::RowVectorXf>& positions_m);
  void ReprocessKept();
  void MeasureLeg();
  // Returns one frame's state, scaled as the model's.
  const float* Scaled(std::int64_t frame);
  absl::Status PredictInto(const Cancelled& cancelled, Observed& observed) const;

  const Model* model_;
  std::shared_ptr<const ClipMask> mask_;
  ObserverOptions options_;
  const double frame_rate_hz_;  // of the incoming frames
  const MarkerSet set_;
  MarkerStream stream_;
  ObservedStates states_;
  std::unique_ptr<NodeFilter> filter_;
  std::unique_ptr<WindowRecognizer> recognizer_;
  bool has_leg_length_ = false;
  bool is_measuring_ = false;  // the leg length may still change
  bool is_fresh_ = false;      // frames were processed since newest_in_states_ was set
  bool has_newest_ = false;
  std::int64_t newest_ = 0;            // number of the newest frame
  std::int64_t newest_in_states_ = 0;  // number of the newest frame in the states
  std::int64_t late_frames_ = 0;
  std::int64_t missing_frames_ = 0;
  FrameMatrix scaled_;
};

}  // namespace motiondb::core
