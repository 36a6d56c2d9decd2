#include "core/planning/contacts.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <optional>

#include "core/model/model.h"
#include "core/motion/samples.h"

namespace motiondb::core {
namespace {

// Lengths are in leg lengths, speeds in leg lengths per second.

constexpr int kContactFrames = 4000;
constexpr int kMaxSampledClips = 50;

// Markers move together if the standard deviation of their distance is below this: above that of
// markers computed from several joints, below that of markers separated by a joint.
constexpr float kRigidDeviation = 0.02f;
// Minimum distance of a segment's marker from both ends, as a fraction of the segment.
constexpr float kSegmentMargin = 0.15f;
constexpr float kSegmentBreadth = 0.15f;  // maximum distance from the segment, leg lengths
constexpr float kFootReach = 0.4f;        // from the ankle
// Maximum mean height of a foot marker above the ankle.
constexpr float kAboveAnkle = 0.02f;

constexpr float kRestSpeed = 0.25f;
constexpr std::size_t kMinAtRest = 5;  // frames
// Rest height as a quantile of the heights at rest: low, so that a foot at rest does not count as
// sunken.
constexpr double kRestQuantile = 0.1;
constexpr double kLowQuantile = 0.05;
// Maximum height at rest above the low quantile: excludes a foot held still in the air.
constexpr float kRestBand = 0.08f;

// Hysteresis: a contact begins below the first and ends above the second.
constexpr float kBeginHeight = 0.05f;  // above rest
constexpr float kEndHeight = 0.07f;
constexpr float kBeginSpeed = 0.4f;
constexpr float kEndSpeed = 0.6f;
// A motion has its own floor height if it differs from the typical one by at most this.
constexpr float kFloorDoubt = 0.12f;
constexpr double kMinGapSeconds = 0.05;
constexpr double kMinContactSeconds = 0.08;
// Speeds are central differences over this time to both sides, if the rate is high enough.
constexpr double kSpeedSpanSeconds = 1.0 / 60;

// A sample of stored frames, unscaled.
struct Sample {
  FrameMatrix states;                    // leg lengths, leg lengths per second
  std::vector<Eigen::Index> first_rows;  // of each sampled clip, and the number of rows
};

// Index of the i-th of `some` samples spread evenly over `all`.
int EvenIndex(int i, int some, int all) {
  return static_cast<int>(static_cast<std::int64_t>(i) * all / some);
}

Sample TakeSample(const Model& model) {
  const auto clip_count = static_cast<int>(model.clips().size());
  const int clips = std::min(clip_count, kMaxSampledClips);
  std::vector<int> frames;
  Sample sample;
  for (int c = 0; c < clips; ++c) {
    const ModelClip& clip = model.clips()[EvenIndex(c, clips, clip_count)];
    const int count = std::min(clip.frame_count, kContactFrames / clips);
    sample.first_rows.push_back(static_cast<Eigen::Index>(frames.size()));
    for (int i = 0; i < count; ++i) {
      frames.push_back(clip.first_frame + EvenIndex(i, count, clip.frame_count));
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

// Whether a marker is near the segment between two others and fixed to it.
bool IsOnSegment(const FrameMatrix& states, int marker, int from, int to) {
  const FrameMatrix along = states.middleCols<3>(6 * to) - states.middleCols<3>(6 * from);
  const FrameMatrix to_marker = states.middleCols<3>(6 * marker) - states.middleCols<3>(6 * from);
  const Eigen::ArrayXf shares =
      along.cwiseProduct(to_marker).rowwise().sum().array() / along.rowwise().squaredNorm().array();
  const FrameMatrix perpendicular = to_marker - shares.matrix().asDiagonal() * along;
  const float share = shares.mean();
  return share > kSegmentMargin && share < 1 - kSegmentMargin &&
         perpendicular.rowwise().norm().mean() < kSegmentBreadth &&
         DistanceSpread(states, marker, from).deviation < kRigidDeviation &&
         DistanceSpread(states, marker, to).deviation < kRigidDeviation;
}

bool IsOfFoot(const FrameMatrix& states, int marker, int ankle) {
  const Spread spread = DistanceSpread(states, marker, ankle);
  const float above = (states.col(6 * marker + 2) - states.col(6 * ankle + 2)).mean();
  return spread.mean < kFootReach && spread.deviation < kRigidDeviation && above < kAboveAnkle;
}

// Estimates the height of a standing marker from its heights and speeds: from frames in which it is
// slow and low. Nothing if it is rarely slow.
std::optional<float> RestHeight(const Eigen::ArrayXf& heights, const Eigen::ArrayXf& speeds) {
  std::vector<float> slow;
  for (Eigen::Index t = 0; t < heights.size(); ++t) {
    if (speeds[t] < kRestSpeed && std::isfinite(heights[t])) slow.push_back(heights[t]);
  }
  if (slow.size() < kMinAtRest) return std::nullopt;
  const float max_height = Quantile(slow, kLowQuantile) + kRestBand;
  std::erase_if(slow, [&](float height) { return height > max_height; });
  return Quantile(slow, kRestQuantile);
}

// Returns the median of the clips' rest heights, because floors differ between recordings. For a
// marker that never rests, a low quantile of all heights.
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
  if (!rests.empty()) return Quantile(rests, 0.5);
  std::vector<float> all(heights.begin(), heights.end());
  return Quantile(all, kLowQuantile);
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

Feet FeetIn(const MarkerSet& set, const Sample& sample) {
  Feet feet;
  for (const auto& leg : set.landmarks.legs) feet.push_back(FindFoot(sample, leg));
  return feet;
}

using Flags = Eigen::Array<bool, Eigen::Dynamic, 1>;

// Inverts runs of `value` shorter than `shortest` frames. Keeps runs at the ends of the
// motion, which may be longer.
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

// Speeds of a marker, in leg lengths per second.
Eigen::ArrayXf Speeds(const FrameMatrix& positions_m, int marker, double rate_hz, double leg_m) {
  const Eigen::Index last = positions_m.rows() - 1;
  const auto span = std::max<Eigen::Index>(1, std::lround(kSpeedSpanSeconds * rate_hz));
  Eigen::ArrayXf speeds = Eigen::ArrayXf::Zero(last + 1);
  for (Eigen::Index t = 0; t <= last && last > 0; ++t) {
    const Eigen::Index before = std::max<Eigen::Index>(0, t - span);
    const Eigen::Index after = std::min(last, t + span);
    const float distance = (positions_m.row(after).segment<3>(3 * marker) -
                            positions_m.row(before).segment<3>(3 * marker))
                               .norm();
    speeds[t] = distance * static_cast<float>(rate_hz / leg_m) / static_cast<float>(after - before);
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
  DropShortRuns(false, std::lround(kMinGapSeconds * rate_hz), stands);
  DropShortRuns(true, std::lround(kMinContactSeconds * rate_hz), stands);
  return stands;
}

}  // namespace

Feet FindFeet(const Model& model) { return FeetIn(model.marker_set(), TakeSample(model)); }

Feet FindFeet(const MarkerSet& set, const Eigen::Ref<const FrameMatrix>& states) {
  Sample sample;
  sample.states = states(SpreadEvenly(states.rows(), kContactFrames), Eigen::all);
  sample.first_rows = {0, sample.states.rows()};
  return FeetIn(set, sample);
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
