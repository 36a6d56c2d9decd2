// Peer of prediction: adds the displacements of the stored futures with the most similar past to
// the present pose. Compares world poses, so the root's pose must be removed from the motion.
#pragma once

#include <vector>

#include "tests/eval/peers/frame_distances.h"
#include "tests/eval/predictors/predictor.h"

namespace motiondb::tests {

struct ExemplarOptions {
  int lags = 1;            // past frames that are compared, including the present one
  double step_weight = 0;  // weight of frame-to-frame steps relative to positions
  int exemplars = 1;       // weighted by closeness if more than one
  double step_decay = 0;   // per frame: fraction of the present step's difference that continues
};

class NearestExemplar : public Predictor {
 public:
  // Chooses the options of each horizon by leaving out each training clip in turn, every tenth
  // frame.
  absl::Status Fit(const ClipSet& training, const std::vector<double>& horizons) override;
  // Uses these options for every horizon, without tuning.
  void Learn(const ClipSet& training, const ExemplarOptions& options);

  // `horizons` must be those of Fit.
  absl::StatusOr<Forecast> Predict(const core::MarkerMotion& past,
                                   const std::vector<double>& horizons) const override;
  std::string chosen() const override { return chosen_; }
  double model_bytes() const override;

 private:
  struct Past;  // distances of observed frames to all stored frames
  struct Exemplar {
    double weight = 0;  // sum to 1 over a set
    int frame = 0;
  };

  void Store(const ClipSet& training);
  Past Compare(const core::FrameMatrix& observed) const;
  // Returns the stored frames most similar to the last observed one, at least `furthest` frames
  // before the end of their clip. Excludes the clip `left_out`; -1 excludes none.
  std::vector<Exemplar> Exemplars(const Past& past, const ExemplarOptions& options, int furthest,
                                  int left_out) const;
  // Returns the pose `ahead` frames after the last observed frame: 3 N_v.
  Eigen::RowVectorXf Future(const core::FrameMatrix& observed,
                            const std::vector<Exemplar>& exemplars, double step_decay,
                            int ahead) const;

  std::vector<ExemplarOptions> options_;  // one per horizon, or one for all
  std::string chosen_ = "given";
  StoredFrames positions_;
  StoredFrames steps_;           // from the previous frame; 0 at the beginning of a clip
  std::vector<int> clip_begin_;  // and the end of the last clip
};

}  // namespace motiondb::tests
