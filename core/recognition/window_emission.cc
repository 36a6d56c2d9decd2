#include "core/recognition/window_emission.h"

#include <algorithm>

#include "core/inference/log_sum.h"
#include "core/model/model.h"
#include "core/motion/patience.h"

namespace motiondb::core {

WindowEmission::WindowEmission(const Model& model, int layer, const FrameMatrix& observation,
                               int frames)
    : model_(model), layer_(layer), observation_(observation) {
  log_density_.resize(frames, model.tree().node_count(layer));
}

void WindowEmission::MoveTo(int first, const Cancelled& cancelled) {
  Patience patience(cancelled);
  const auto frames = static_cast<int>(log_density_.rows());
  const int keep = std::clamp(computed_ - first, 0, frames);
  for (int t = 0; t < keep; ++t) log_density_.row(t) = log_density_.row(t + first - first_);
  for (int t = keep; t < frames; ++t) {
    if (patience.IsOver(log_density_.cols() * observation_.cols())) return;
    const float* x = observation_.row(first + t).data();
    for (Eigen::Index node = 0; node < log_density_.cols(); ++node) {
      const int branch = model_.tree().branch(layer_, static_cast<int>(node));
      log_density_(t, node) = model_.gaussians().LogDensity(branch, x);
    }
  }
  first_ = first;
  computed_ = first + frames;
}

double WindowEmission::LogEvidence() const {
  double sum = 0;
  for (Eigen::Index t = 0; t < log_density_.rows(); ++t) sum += LogSum(log_density_.row(t));
  return sum;
}

}  // namespace motiondb::core
