// What goes on in a stream of frames, told while it comes in: where the motion is in the tree, what
// it is called, how familiar it is and what comes next. Each frame is worked on when it comes, and
// the questions are put to a window that moves along: a frame costs the same however long the
// stream is, and memory is bounded by the window.
//
// An observer belongs to one thread at a time; several may share a model, which must outlive them
// (or be replaced).
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
#include "core/motion/cancellation.h"
#include "core/motion/marker_set.h"
#include "core/motion/matrix.h"
#include "core/observe/node_filter.h"
#include "core/observe/observed_states.h"
#include "core/observe/window_recognizer.h"
#include "core/prediction/predict.h"
#include "core/recognition/recognize.h"

namespace motiondb::core {

class Model;

struct ObserverOptions {
  double window_seconds = 0.4;          // labels and familiarity
  double history_seconds = 0.4;         // prediction
  std::vector<double> horizon_seconds;  // empty: no prediction
  int layer = 0;                        // of the node estimate; 0 is the bottom layer
  double transition_floor = 1e-6;
};

// INVALID_ARGUMENT naming the field if an option is out of range for models of these settings.
absl::Status CheckOptions(const ObserverOptions& options, const BuildSettings& settings);

struct Observed {
  std::int64_t frame = 0;  // number of the newest observed frame it rests on
  int layer = 0;
  NodeState state;                       // the most probable node now, given all frames so far
  std::vector<LabelScore> labels;        // most probable first; they sum to 1
  double familiarity = 0;                // as RecognizedWindow::familiarity
  std::vector<PredictedFrame> horizons;  // in the order asked for
};

class Observer {
 public:
  // `marker_names`: of the frames that come, in their order, `frame_rate_hz` a second. The scheme,
  // whose set is the model's, brings them to the model's markers. Frames at another rate than the
  // model's are resampled as observed_states.h says. `leg_length_m` absent: the median of the
  // frames so far, until one second has come, and kept then. INVALID_ARGUMENT for settings out of
  // range (naming the field), a scheme of another marker set or names that it has no mapping for;
  // OUT_OF_RANGE for a layer that is not there.
  static absl::StatusOr<std::unique_ptr<Observer>> Create(
      const Model& model, const MarkerScheme& scheme, const std::vector<std::string>& marker_names,
      double frame_rate_hz, std::optional<double> leg_length_m, const ObserverOptions& options);

  // Takes frames numbered first_frame, first_frame + 1, ...: frames x 3 markers, m, world, z up,
  // NaN where a marker is missing (in one of its numbers is enough). Numbers not above the newest
  // taken are late: passed over and counted. Numbers left out count as frames in which all is
  // missing; where they last longer than the window, the observation starts anew. INVALID_ARGUMENT,
  // and nothing is taken, if the width is not that of the names, a number is infinite or beyond 100
  // km, or the frames' numbers overflow. CANCELLED, with some of the frames taken. No allocation
  // for frames at the model's rate that lack no marker, after the first second.
  absl::Status Append(std::int64_t first_frame, const FrameMatrix& positions_m,
                      const Cancelled& cancelled = {});

  // What the frames so far say; nullopt while there was none with both hips and a size. The labels
  // and the familiarity are those of Recognize for the last `window_seconds`, the horizons those of
  // Predict for the last `history_seconds`. The answer's vectors are its own. CANCELLED.
  absl::StatusOr<std::optional<Observed>> Answer(const Cancelled& cancelled = {});

  // Takes over another model of the same database from the next frame on; the frames of the window
  // (of the last second at least) are gone through again under it, as if they were the first. A
  // model without the layer that was asked for answers by its bottom layer, as Observed::layer
  // says. INVALID_ARGUMENT for a model of another marker set or frame rate; nothing changes then.
  absl::Status Replace(const Model& model);

  std::int64_t late_frames() const { return late_frames_; }
  // Numbers left out so far.
  std::int64_t missing_frames() const { return missing_frames_; }
  // Frames at the model's rate that are kept and go over to another model.
  int kept_frames() const { return states_.kept(); }
  // What lengths are divided by; absent while it is not known.
  std::optional<double> leg_length_m() const;

 private:
  Observer(const Model& model, MarkerSet set, MarkerStream stream, double frame_rate_hz,
           std::optional<double> leg_length_m, const ObserverOptions& options, int layer);

  absl::Status Check(std::int64_t first_frame, const FrameMatrix& positions_m) const;
  // Numbers between the newest taken and `number`.
  void PassGap(std::int64_t number);
  void StartAnew();
  void Forget();
  void Under(const Model& model, int layer);
  // Frames at the model's rate that the stream has ready.
  void TakeReady();
  void Follow(const Eigen::Ref<const Eigen::RowVectorXf>& positions_m);
  void GoOverKept();
  void MeasureLeg();
  // Of one frame, scaled as the model's.
  const float* Scaled(std::int64_t frame);
  absl::Status PredictInto(const Cancelled& cancelled, Observed& observed) const;

  const Model* model_;
  const ObserverOptions options_;
  const double frame_rate_hz_;  // of the frames that come
  const MarkerSet set_;
  MarkerStream stream_;
  ObservedStates states_;
  std::unique_ptr<NodeFilter> filter_;
  std::unique_ptr<WindowRecognizer> recognizer_;
  bool has_leg_length_ = false;
  bool is_measuring_ = false;  // the leg length may change yet
  bool is_fresh_ = false;      // frames were taken since newest_told_ was set
  bool has_newest_ = false;
  std::int64_t newest_ = 0;       // number of the newest frame taken
  std::int64_t newest_told_ = 0;  // of the newest that the states rest on
  std::int64_t late_frames_ = 0;
  std::int64_t missing_frames_ = 0;
  FrameMatrix scaled_;
};

}  // namespace motiondb::core
