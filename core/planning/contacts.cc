#include "core/planning/contacts.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <optional>

#include "core/model/model.h"

namespace motiondb::core {
namespace {

// Lengths are in leg lengths, speeds in leg lengths a second.

constexpr int kContactFrames = 4000;
constexpr int kClipsLookedAt = 50;

// A marker moves with another while their distance varies less than this (standard deviation):
// more than markers made from several joints do, less than any joint between the two allows.
constexpr float kRigidDeviation = 0.02f;
// A marker of a segment is at least this part of its length inside both ends.
constexpr float kSegmentMargin = 0.15f;
constexpr float kSegmentBreadth = 0.15f;  // how far beside it, leg lengths
constexpr float kFootReach = 0.4f;        // from the ankle
// A part of the foot is on average no further above the ankle than this.
constexpr float kAboveAnkle = 0.02f;

constexpr float kRestSpeed = 0.25f;
constexpr std::size_t kFewestAtRest = 5;  // frames
// Of the heights at rest: below most of them, so that a foot at rest is not taken to be sunken.
constexpr double kRestQuantile = 0.1;
constexpr double kLowQuantile = 0.05;
// Above the low ones: a foot held still in the air is not at rest.
constexpr float kRestBand = 0.08f;

// A contact begins below the first and ends above the second.
constexpr float kBeginHeight = 0.05f;  // above rest
constexpr float kEndHeight = 0.07f;
constexpr float kBeginSpeed = 0.4f;
constexpr float kEndSpeed = 0.6f;
// A run has its own floor if it is this near to the usual one.
constexpr float kFloorDoubt = 0.12f;
constexpr double kShortestGapSeconds = 0.05;
constexpr double kShortestRunSeconds = 0.08;
// Speeds are taken over a sixtieth of a second to either side, at any rate that has it.
constexpr double kSpeedSpanSeconds = 1.0 / 60;

float Quantile(std::vector<float> values, double share) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// Frames that are looked at, as they were before scaling.
struct Sample {
  FrameMatrix states;                    // leg lengths, leg lengths a second
  std::vector<Eigen::Index> first_rows;  // of each clip looked at; then how many rows there are
};

// So many of so many, evenly: which is the i-th.
int Evenly(int i, int some, int all) {
  return static_cast<int>(static_cast<std::int64_t>(i) * all / some);
}

Sample TakeSample(const Model& model) {
  const auto clip_count = static_cast<int>(model.clips().size());
  const int clips = std::min(clip_count, kClipsLookedAt);
  std::vector<int> frames;
  Sample sample;
  for (int c = 0; c < clips; ++c) {
    const ModelClip& clip = model.clips()[Evenly(c, clips, clip_count)];
    const int count = std::min(clip.frame_count, kContactFrames / clips);
    sample.first_rows.push_back(static_cast<Eigen::Index>(frames.size()));
    for (int i = 0; i < count; ++i) {
      frames.push_back(clip.first_frame + Evenly(i, count, clip.frame_count));
    }
  }
  sample.first_rows.push_back(static_cast<Eigen::Index>(frames.size()));
  sample.states = model.states()(frames, Eigen::all);
  model.scale().Revert(sample.states);
  return sample;
}

struct Spread {
  float mean = 0;
  float deviation = 0;
};

Spread DistanceSpread(const FrameMatrix& states, int a, int b) {
  const Eigen::ArrayXf distances =
      (states.middleCols<3>(6 * a) - states.middleCols<3>(6 * b)).rowwise().norm();
  const float mean = distances.mean();
  return {mean, std::sqrt((distances - mean).square().mean())};
}

// Whether a marker is beside the segment between two others and keeps its place there.
bool IsOnSegment(const FrameMatrix& states, int marker, int from, int to) {
  const FrameMatrix along = states.middleCols<3>(6 * to) - states.middleCols<3>(6 * from);
  const FrameMatrix there = states.middleCols<3>(6 * marker) - states.middleCols<3>(6 * from);
  const Eigen::ArrayXf shares =
      along.cwiseProduct(there).rowwise().sum().array() / along.rowwise().squaredNorm().array();
  const FrameMatrix aside = there - shares.matrix().asDiagonal() * along;
  const float share = shares.mean();
  return share > kSegmentMargin && share < 1 - kSegmentMargin &&
         aside.rowwise().norm().mean() < kSegmentBreadth &&
         DistanceSpread(states, marker, from).deviation < kRigidDeviation &&
         DistanceSpread(states, marker, to).deviation < kRigidDeviation;
}

bool IsOfFoot(const FrameMatrix& states, int marker, int ankle) {
  const Spread spread = DistanceSpread(states, marker, ankle);
  const float above = (states.col(6 * marker + 2) - states.col(6 * ankle + 2)).mean();
  return spread.mean < kFootReach && spread.deviation < kRigidDeviation && above < kAboveAnkle;
}

// How high a marker is when it stands, from its heights and speeds in a run of frames: of those
// where it is slow and low. Nothing if it hardly ever is slow.
std::optional<float> RestHeight(const Eigen::ArrayXf& heights, const Eigen::ArrayXf& speeds) {
  std::vector<float> slow;
  for (Eigen::Index t = 0; t < heights.size(); ++t) {
    if (speeds[t] < kRestSpeed && std::isfinite(heights[t])) slow.push_back(heights[t]);
  }
  if (slow.size() < kFewestAtRest) return std::nullopt;
  const float highest = Quantile(slow, kLowQuantile) + kRestBand;
  std::erase_if(slow, [&](float height) { return height > highest; });
  return Quantile(std::move(slow), kRestQuantile);
}

// The middle one of the clips' rest heights, for floors differ a little between recordings. Where a
// marker never rests, a low height of all frames.
float TypicalRestHeight(const Sample& sample, int marker) {
  const Eigen::ArrayXf heights = sample.states.col(6 * marker + 2);
  const Eigen::ArrayXf speeds = sample.states.middleCols<3>(6 * marker + 3).rowwise().norm();
  std::vector<float> rests;
  for (std::size_t c = 0; c + 1 < sample.first_rows.size(); ++c) {
    const Eigen::Index first = sample.first_rows[c];
    const Eigen::Index count = sample.first_rows[c + 1] - first;
    const auto rest = RestHeight(heights.segment(first, count), speeds.segment(first, count));
    if (rest) rests.push_back(*rest);
  }
  if (!rests.empty()) return Quantile(std::move(rests), 0.5);
  return Quantile({heights.begin(), heights.end()}, kLowQuantile);
}

Foot FindFoot(const Sample& sample, const std::array<int, 3>& leg) {
  const FrameMatrix& states = sample.states;
  const auto [hip, knee, ankle] = leg;
  Foot foot{.leg = leg};
  foot.foot_markers.push_back(ankle);
  for (int m = 0; m < states.cols() / 6; ++m) {
    if (m == hip || m == knee || m == ankle) continue;
    if (IsOfFoot(states, m, ankle)) {
      foot.foot_markers.push_back(m);
      foot.contact_markers.push_back(m);
    } else if (IsOnSegment(states, m, hip, knee)) {
      foot.thigh_markers.push_back(m);
    } else if (IsOnSegment(states, m, knee, ankle)) {
      foot.shin_markers.push_back(m);
    }
  }
  if (foot.contact_markers.empty()) foot.contact_markers.push_back(ankle);

  std::vector<std::pair<float, int>> by_height;
  for (const int m : foot.contact_markers) by_height.emplace_back(TypicalRestHeight(sample, m), m);
  std::sort(by_height.begin(), by_height.end());
  for (std::size_t i = 0; i < by_height.size(); ++i) {
    foot.contact_markers[i] = by_height[i].second;
    foot.rest_heights.push_back(by_height[i].first);
  }
  return foot;
}

using Flags = Eigen::Array<bool, Eigen::Dynamic, 1>;

// Makes runs of `value` that are shorter than `shortest` frames the opposite. Runs that the ends of
// the motion cut off are kept, for they may be longer.
void DropShortRuns(bool value, Eigen::Index shortest, Flags& runs) {
  Eigen::Index begin = 0;
  for (Eigen::Index t = 1; t <= runs.size(); ++t) {
    if (t < runs.size() && runs[t] == runs[begin]) continue;
    const bool whole = begin > 0 && t < runs.size();
    if (runs[begin] == value && whole && t - begin < shortest) {
      runs.segment(begin, t - begin).setConstant(!value);
    }
    begin = t;
  }
}

// Speeds of a marker, in leg lengths a second.
Eigen::ArrayXf Speeds(const FrameMatrix& positions_m, int marker, double rate_hz, double leg_m) {
  const Eigen::Index last = positions_m.rows() - 1;
  const auto span = std::max<Eigen::Index>(1, std::lround(kSpeedSpanSeconds * rate_hz));
  Eigen::ArrayXf speeds = Eigen::ArrayXf::Zero(last + 1);
  for (Eigen::Index t = 0; t <= last && last > 0; ++t) {
    const Eigen::Index before = std::max<Eigen::Index>(0, t - span);
    const Eigen::Index after = std::min(last, t + span);
    const float way = (positions_m.row(after).segment<3>(3 * marker) -
                       positions_m.row(before).segment<3>(3 * marker))
                          .norm();
    speeds[t] = way * static_cast<float>(rate_hz / leg_m) / static_cast<float>(after - before);
  }
  return speeds;
}

Flags MarkerContacts(const FrameMatrix& positions_m, int marker, float usual_rest, double rate_hz,
                     double leg_m) {
  const Eigen::ArrayXf speeds = Speeds(positions_m, marker, rate_hz, leg_m);
  const Eigen::ArrayXf heights =
      positions_m.col(3 * marker + 2).array() / static_cast<float>(leg_m);
  float rest = RestHeight(heights, speeds).value_or(usual_rest);
  if (std::abs(rest - usual_rest) > kFloorDoubt) rest = usual_rest;
  Flags stands(heights.size());
  bool standing = false;
  for (Eigen::Index t = 0; t < heights.size(); ++t) {
    // A comparison with NaN is false.
    standing = heights[t] - rest < (standing ? kEndHeight : kBeginHeight) &&
               speeds[t] < (standing ? kEndSpeed : kBeginSpeed);
    stands[t] = standing;
  }
  DropShortRuns(false, std::lround(kShortestGapSeconds * rate_hz), stands);
  DropShortRuns(true, std::lround(kShortestRunSeconds * rate_hz), stands);
  return stands;
}

}  // namespace

Feet FindFeet(const Model& model) {
  const Sample sample = TakeSample(model);
  Feet feet;
  for (const auto& leg : model.marker_set().landmarks.legs) feet.push_back(FindFoot(sample, leg));
  return feet;
}

ContactMatrix DetectContacts(const Feet& feet, const FrameMatrix& positions_m, double frame_rate_hz,
                             double leg_length_m) {
  const std::size_t markers = std::accumulate(
      feet.begin(), feet.end(), std::size_t{0},
      [](std::size_t sum, const Foot& foot) { return sum + foot.contact_markers.size(); });
  ContactMatrix contacts(positions_m.rows(), static_cast<Eigen::Index>(markers));
  Eigen::Index column = 0;
  for (const Foot& foot : feet) {
    for (std::size_t i = 0; i < foot.contact_markers.size(); ++i) {
      contacts.col(column++) = MarkerContacts(positions_m, foot.contact_markers[i],
                                              foot.rest_heights[i], frame_rate_hz, leg_length_m);
    }
  }
  return contacts;
}

}  // namespace motiondb::core
