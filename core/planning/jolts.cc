#include "core/planning/jolts.h"

#include <algorithm>
#include <cmath>

#include "core/model/model.h"
#include "core/planning/synthesis.h"

namespace motiondb::core {
namespace {

constexpr int kFramesLookedAt = 4000;
constexpr double kUsual = 0.99;
constexpr float kTooMuch = 2;

}  // namespace

Jolts::Jolts(const Model& model)
    : model_(model), known_(static_cast<std::size_t>(model.frame_count()), Known::kNo) {
  const int every = std::max(1, model.frame_count() / kFramesLookedAt);
  std::vector<float> jerks;
  for (int f = 0; f < model.frame_count(); f += every) jerks.push_back(Jerk(f));
  const auto usual =
      jerks.begin() + static_cast<std::ptrdiff_t>(kUsual * static_cast<double>(jerks.size() - 1));
  std::nth_element(jerks.begin(), usual, jerks.end());
  limit_ = kTooMuch * *usual;
}

float Jolts::Jerk(int frame) const {
  const ModelClip& clip = model_.clips()[model_.clip_of_frame(frame)];
  if (clip.frame_count < 4) return 0;
  // The four frames about it, or the clip's first or last four.
  const int first =
      std::clamp(frame - 1, clip.first_frame, clip.first_frame + clip.frame_count - 4);
  const auto at = [&](int f) {
    const auto root = model_.root_path().row(f);
    return OnFloor(PositionsOf(model_.states().row(f).cwiseProduct(model_.scale().divisor)), 1,
                   {root[0] / clip.leg_length_m, root[1] / clip.leg_length_m, root[2]});
  };
  const Eigen::RowVectorXf jerk = at(first + 3) - 3 * at(first + 2) + 3 * at(first + 1) - at(first);
  return jerk.reshaped<Eigen::RowMajor>(jerk.size() / 3, 3).rowwise().norm().maxCoeff();
}

bool Jolts::At(int frame) {
  Known& known = known_[frame];
  if (known == Known::kNo) known = Jerk(frame) > limit_ ? Known::kJolt : Known::kSmooth;
  return known == Known::kJolt;
}

bool Jolts::Within(int first, int last) {
  for (int f = first; f <= last; ++f) {
    if (At(f)) return true;
  }
  return false;
}

}  // namespace motiondb::core
