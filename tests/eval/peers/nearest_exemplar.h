// Peer of prediction: the displacement of the stored futures whose past is most like what was
// observed, added to the present pose. Compares poses as the world tells them, so it is for motion
// with the root's pose removed.
#pragma once

#include <vector>

#include "tests/eval/peers/frame_distances.h"
#include "tests/eval/predictors/predictor.h"

namespace motiondb::tests {

struct ExemplarOptions {
  int lags = 1;            // frames of the past that are compared, the present one included
  double step_weight = 0;  // of differences of frame-to-frame steps, beside those of positions
  int exemplars = 1;       // weighted by closeness if more than one
  double step_decay = 0;   // a frame: share of what the present step differs by that goes on
};

class NearestExemplar : public Predictor {
 public:
  // Chooses the options for each horizon by holding out each training clip in turn, every tenth
  // frame.
  absl::Status Fit(const ClipSet& training, const std::vector<double>& horizons) override;
  // With these options for every horizon, without choosing.
  void Learn(const ClipSet& training, const ExemplarOptions& options);

  // The horizons are those of Fit.
  absl::StatusOr<Forecast> Predict(const core::MarkerMotion& past,
                                   const std::vector<double>& horizons) const override;
  std::string chosen() const override { return chosen_; }
  double model_bytes() const override;

 private:
  struct Past;  // distances of observed frames to all that are stored
  struct Exemplar {
    double weight = 0;  // a set's sum to 1
    int frame = 0;
  };

  void Store(const ClipSet& training);
  Past Compare(const core::FrameMatrix& observed) const;
  // The stored frames that are most like the last one observed, at least `furthest` frames before
  // their clip's end, those of `left_out` (a clip, -1 for none) not among them.
  std::vector<Exemplar> Exemplars(const Past& past, const ExemplarOptions& options, int furthest,
                                  int left_out) const;
  // The pose `ahead` frames after the last of the observed frames: 3 N_v.
  Eigen::RowVectorXf Future(const core::FrameMatrix& observed,
                            const std::vector<Exemplar>& exemplars, double step_decay,
                            int ahead) const;

  std::vector<ExemplarOptions> options_;  // one a horizon, or one for all
  std::string chosen_ = "given";
  StoredFrames positions_;
  StoredFrames steps_;           // from the frame before; 0 at the beginning of a clip
  std::vector<int> clip_begin_;  // and the end of the last
};

}  // namespace motiondb::tests
