#include "core/model/label_units.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <set>

#include "core/model/clip_mask.h"
#include "core/model/model.h"
#include "core/motion/samples.h"

namespace motiondb::core {

LabelUnits::LabelUnits(const std::vector<ModelClip>& clips, double frame_rate_hz,
                       std::string_view track, const ClipMask* mask) {
  std::set<std::string_view> labels;
  std::set<std::string_view> others;
  const auto is_used = [&](std::size_t c) { return Allows(mask, static_cast<int>(c)); };
  for (std::size_t c = 0; c < clips.size(); ++c) {
    if (!is_used(c)) continue;
    for (const auto& [name, spans] : clips[c].labels.tracks()) {
      if (name != track) {
        others.insert(name);
        continue;
      }
      for (const LabelSpan& span : spans) labels.insert(span.label);
    }
  }
  labels_.assign(labels.begin(), labels.end());
  other_tracks_.assign(others.begin(), others.end());

  const int stride = FrameStride(frame_rate_hz);
  int first_row = 0;  // of the clip
  begin_.reserve(clips.size() + 1);
  for (std::size_t c = 0; c < clips.size(); ++c) {
    begin_.push_back(static_cast<int>(units_.size()));
    const ModelClip& clip = clips[c];
    const auto add = [&](int label, int first, int end) {
      if (first == end) return;
      const int end_row = (end + stride - 1) / stride;
      const int row = std::min((first + stride - 1) / stride, end_row - 1);
      units_.push_back({static_cast<int>(c),
                        label,
                        clip.first_frame + first,
                        end - first,
                        {first_row + row, end_row - row}});
    };
    if (is_used(c)) {
      int next = 0;
      for (const LabelSpan& span : clip.labels.Of(track)) {
        const auto label = std::ranges::lower_bound(labels_, span.label) - labels_.begin();
        add(-1, next, span.first_frame);
        next = span.frame_count == LabelSpan::kToEnd ? clip.frame_count
                                                     : span.first_frame + span.frame_count;
        add(static_cast<int>(label), span.first_frame, next);
      }
      add(-1, next, clip.frame_count);
    }
    first_row += (clip.frame_count + stride - 1) / stride;
  }
  begin_.push_back(static_cast<int>(units_.size()));
}

std::shared_ptr<const LabelUnits> UnitsOf(const Model& model, std::string_view track,
                                          const ClipMask* mask) {
  if (track.empty() || track == kActionTrack) {
    return mask == nullptr ? model.action_units() : mask->action_units();
  }
  return std::make_shared<const LabelUnits>(model.clips(), model.settings().frame_rate_hz, track,
                                            mask);
}

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
