#include "core/model/frame_pairs.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>

#include "core/model/even_spread.h"
#include "core/model/label_units.h"

namespace motiondb::core {
namespace {

constexpr int kMaxUnits = 256;
constexpr Eigen::Index kMaxFrames = 512;  // 17 s
constexpr int kStarts = 4;
constexpr float kLateStartCost = 0.05F;  // for each dimension and frame
constexpr int kSteps = 3;                // 0, 1 or 2 reference frames
constexpr float kNever = std::numeric_limits<float>::infinity();

}  // namespace

std::vector<IndexPair> UnitPairs(const std::vector<LabelUnit>& units, int max_references) {
  std::map<int, std::vector<int>> of_label;
  std::vector<std::size_t> place(units.size());  // index among the units of its label
  for (std::size_t u = 0; u < units.size(); ++u) {
    if (units[u].label < 0) continue;
    auto& same = of_label[units[u].label];
    place[u] = same.size();
    same.push_back(static_cast<int>(u));
  }
  std::vector<int> paired;
  for (std::size_t u = 0; u < units.size(); ++u) {
    if (units[u].label >= 0 && of_label[units[u].label].size() > 1) {
      paired.push_back(static_cast<int>(u));
    }
  }
  std::vector<IndexPair> pairs;
  for (const int i : SpreadEvenly(std::ssize(paired), kMaxUnits)) {
    const int unit = paired[i];
    const auto& same = of_label[units[unit].label];
    for (const int k : SpreadEvenly(std::ssize(same) - 1, max_references)) {
      pairs.push_back({unit, same[(place[unit] + 1 + k) % same.size()]});
    }
  }
  return pairs;
}

std::vector<IndexPair> AlignFrames(const FrameMatrix& observed, const FrameMatrix& reference,
                                   Eigen::Index dimensions) {
  const Eigen::Index frames = std::min(observed.rows(), kMaxFrames);
  const Eigen::Index places = std::min(reference.rows(), (kSteps - 1) * frames + kStarts);
  const auto compared = reference.topRows(places);
  const FrameMatrix cost =
      SquaredDistances(observed.topRows(frames), compared, compared.rowwise().squaredNorm());
  const float late_cost = kLateStartCost * static_cast<float>(dimensions);

  Eigen::Matrix<std::int8_t, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> step(frames, places);
  Eigen::RowVectorXf total(places);
  for (Eigen::Index j = 0; j < places; ++j) {
    total[j] = j < kStarts ? late_cost * static_cast<float>(j) + cost(0, j) : kNever;
  }
  Eigen::RowVectorXf before(places);
  for (Eigen::Index i = 1; i < frames; ++i) {
    before.swap(total);
    for (Eigen::Index j = 0; j < places; ++j) {
      int best = 0;
      for (int s = 1; s < kSteps && s <= j; ++s) {
        if (before[j - s] < before[j - best]) best = s;
      }
      step(i, j) = static_cast<std::int8_t>(best);
      total[j] = before[j - best] + cost(i, j);
    }
  }
  Eigen::Index j = 0;
  if (!(total.minCoeff(&j) < kNever)) return {};
  std::vector<IndexPair> pairs(frames);
  for (Eigen::Index i = frames - 1; i >= 0; --i) {
    pairs[i] = {static_cast<int>(i), static_cast<int>(j)};
    if (i > 0) j -= step(i, j);
  }
  return pairs;
}

}  // namespace motiondb::core
