#include "import/scene/scene_timing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <numeric>

#include "core/format/conventions.h"
#include "core/format/text_scanner.h"
#include "core/motion/error.h"

namespace motiondb::importer {

namespace {

constexpr double kDefaultTicksPerSecond = 25;
constexpr double kSparse_hz = 10;
constexpr double kUsual_hz = 30;
constexpr double kDensest_hz = 250;  // of irregular keys

// The times of the keys of a take, in ticks.
struct KeyTimes {
  double first = std::numeric_limits<double>::infinity();
  double last = -std::numeric_limits<double>::infinity();
  std::vector<double> densest;  // of the component with most keys
};

template <typename Key>
void AddKeyTimes(const Key* keys, unsigned count, KeyTimes& times) {
  if (count < 2) return;  // constant
  times.first = std::min(times.first, keys[0].mTime);
  times.last = std::max(times.last, keys[count - 1].mTime);
  if (count <= times.densest.size()) return;
  times.densest.clear();
  for (unsigned k = 0; k < count; ++k) times.densest.push_back(keys[k].mTime);
}

KeyTimes FindKeyTimes(const std::vector<JointTrack>& tracks) {
  KeyTimes times;
  for (const JointTrack& track : tracks) {
    for (const TrackPart& part : track.parts) {
      if (part.channel == nullptr) continue;
      AddKeyTimes(part.channel->mPositionKeys, part.channel->mNumPositionKeys, times);
      AddKeyTimes(part.channel->mRotationKeys, part.channel->mNumRotationKeys, times);
      AddKeyTimes(part.channel->mScalingKeys, part.channel->mNumScalingKeys, times);
    }
  }
  return times;
}

// How the keys of a component follow each other, in seconds.
struct KeySpacing {
  double median_s = 0;
  double mean_s = 0;   // of those near the median: exact if times are rounded to milliseconds
  double small_s = 0;  // 5 % are smaller
  bool is_regular = false;
};

KeySpacing MeasureSpacing(const std::vector<double>& ticks, double ticks_per_second) {
  constexpr double kSameSpacing = 0.05;
  constexpr double kSameTime_s = 1e-6;
  std::vector<double> steps;
  for (std::size_t k = 1; k < ticks.size(); ++k) {
    const double step = (ticks[k] - ticks[k - 1]) / ticks_per_second;
    if (step > kSameTime_s) steps.push_back(step);
  }
  KeySpacing spacing;
  if (steps.empty()) return spacing;
  std::sort(steps.begin(), steps.end());
  const std::size_t count = steps.size();
  spacing.median_s = steps[count / 2];
  spacing.small_s = steps[count / 20];
  const auto is_near = [&](double step) {
    return std::abs(step - spacing.median_s) <= kSameSpacing * spacing.median_s;
  };
  spacing.is_regular = is_near(spacing.small_s) && is_near(steps[count - 1 - count / 20]);
  const auto first_near = std::find_if(steps.begin(), steps.end(), is_near);
  const auto after_near = std::find_if_not(first_near, steps.end(), is_near);
  spacing.mean_s = std::accumulate(first_near, after_near, 0.0) /
                   static_cast<double>(std::distance(first_near, after_near));
  return spacing;
}

double RateOfKeys(const KeySpacing& spacing, std::vector<std::string>& notes) {
  const double mean_hz = 1 / spacing.mean_s;
  if (spacing.is_regular && mean_hz >= kSparse_hz) {
    const double rate_hz = core::SnapFrameRate(mean_hz, notes);
    notes.push_back(fmt::format("frame rate {:.8g} Hz deduced from the keys", rate_hz));
    return rate_hz;
  }
  const double small_hz = 1 / spacing.small_s;
  const bool is_usual = small_hz >= kSparse_hz && small_hz <= kDensest_hz;
  const double rate_hz = is_usual ? core::SnapFrameRate(small_hz, notes) : kUsual_hz;
  notes.push_back(fmt::format("keys are {} (every {:.4g} s): sampled at {:.8g} Hz",
                              spacing.is_regular ? "sparse" : "irregular", spacing.median_s,
                              rate_hz));
  return rate_hz;
}

}  // namespace

double TicksPerSecond(const aiAnimation& animation) {
  return animation.mTicksPerSecond == 0 ? kDefaultTicksPerSecond : animation.mTicksPerSecond;
}

absl::StatusOr<SceneTiming> TimeTake(std::string_view file_name, const SceneTake& take,
                                     const std::vector<JointTrack>& tracks,
                                     const StatedRates& stated, std::vector<std::string>& notes) {
  const std::string where = fmt::format("{}: take '{}'", file_name, core::Shown(take.name));
  const double ticks_per_second = TicksPerSecond(*take.animation);
  KeyTimes times = FindKeyTimes(tracks);
  if (times.densest.empty() && stated.keys_hz) {
    return SceneTiming{.ticks_per_frame = ticks_per_second / *stated.keys_hz,
                       .rate_hz = *stated.keys_hz,
                       .frames = 1};
  }
  if (times.densest.empty()) {
    return core::InvalidArgument("{}: no joint has more than one key: it does not move", where);
  }
  if (times.first < 0 && times.last > 0) times.first = 0;
  const double seconds = (times.last - times.first) / ticks_per_second;
  const KeySpacing spacing = MeasureSpacing(times.densest, ticks_per_second);
  if (!(seconds > 0) || !(spacing.median_s > 0)) {
    return core::InvalidArgument("{}: lasts {:.3g} s, from its first to its last key", where,
                                 std::max(0.0, seconds));
  }
  SceneTiming timing{.first_tick = times.first};
  constexpr double kCloseRate = 1.001;
  const auto reaches_keys = [&](const std::optional<double>& rate_hz) {
    return rate_hz && *rate_hz * kCloseRate >= 1 / spacing.mean_s;
  };
  const bool is_stated = reaches_keys(stated.keys_hz);
  if (is_stated) {
    timing.rate_hz = *stated.keys_hz;
  } else if (reaches_keys(stated.display_hz) && *stated.display_hz >= kSparse_hz) {
    timing.rate_hz = core::SnapFrameRate(*stated.display_hz, notes);
  } else {
    timing.rate_hz = RateOfKeys(spacing, notes);
  }
  if (!core::IsFrameRate(timing.rate_hz)) {
    return core::InvalidArgument("{}: expected keys at 0.001 to 100000 Hz, found {:.4g} Hz", where,
                                 timing.rate_hz);
  }
  // Rounding may put the last key just before its frame; single precision of long takes further.
  const double rounding = is_stated ? 0.5 : 0.01;  // of a frame
  const double frames = std::floor(seconds * timing.rate_hz + rounding) + 1;
  if (!(frames * static_cast<double>(tracks.size()) <= kMaxJointPoses)) {
    return core::InvalidArgument(
        "{}: {:.0f} frames of {} joints at {:.8g} Hz are more than {:.0f} joint poses", where,
        frames, tracks.size(), timing.rate_hz, kMaxJointPoses);
  }
  timing.frames = static_cast<int>(frames);
  timing.ticks_per_frame = ticks_per_second / timing.rate_hz;
  return timing;
}

}  // namespace motiondb::importer
