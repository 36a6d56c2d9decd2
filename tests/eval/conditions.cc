#include "tests/eval/conditions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "core/motion/error.h"
#include "tests/eval/observations.h"

namespace motiondb::tests {
namespace {

using Change = std::function<absl::StatusOr<core::StateSequence>(const EvalClip&)>;
using States = std::vector<core::StateSequence>;

constexpr float kMissing = std::numeric_limits<float>::quiet_NaN();

// Limbs of standard34 below the trunk.
const std::vector<std::string> kRightArm = {"RUpperArm", "RElbow", "RForearm", "RWrist", "RHand"};
const std::vector<std::string> kLeftLeg = {"LThigh", "LKnee", "LShin", "LAnkle", "LHeel", "LToe"};

// Seeded by FNV-1a: equal on every machine.
std::mt19937 RandomFor(const EvalClip& clip, int part = 0) {
  std::uint32_t hash = 2166136261U;
  for (const char c : clip.name + "#" + std::to_string(part)) {
    hash = (hash ^ static_cast<unsigned char>(c)) * 16777619U;
  }
  return std::mt19937(hash);
}

bool Happens(double probability, std::mt19937& random) {
  return static_cast<double>(random()) < probability * 4294967296.0;
}

// Applies the change, whole or cut into windows afterwards.
Condition Changed(std::string name, const Change& change) {
  const auto in_parts = [change](Extent extent) {
    return [change, extent](const EvalClip& clip) -> absl::StatusOr<States> {
      MOTIONDB_ASSIGN_OR_RETURN(const core::StateSequence states, change(clip));
      return SplitIntoParts(states, extent);
    };
  };
  return {std::move(name), in_parts(Extent::kWhole), in_parts(Extent::kWindow)};
}

// Changes marker positions at the states' frame rate, before states are computed.
Condition ChangedMarkers(std::string name, const core::MarkerSet& set,
                         const std::function<void(const EvalClip&, core::FrameMatrix&)>& change) {
  return Changed(
      std::move(name), [set, change](const EvalClip& clip) -> absl::StatusOr<core::StateSequence> {
        MOTIONDB_ASSIGN_OR_RETURN(core::MarkerMotion markers,
                                  core::Resample(clip.markers, clip.states.frame_rate_hz));
        change(clip, markers.positions_m);
        return core::ComputeStates(set, markers, clip.states.leg_length_m);
      });
}

Condition MissingFrames(const core::MarkerSet& set, int percent) {
  return ChangedMarkers(fmt::format("{} % of markers missing, drawn for each frame", percent), set,
                        [percent](const EvalClip& clip, core::FrameMatrix& positions) {
                          std::mt19937 random = RandomFor(clip);
                          for (Eigen::Index t = 0; t < positions.rows(); ++t) {
                            for (Eigen::Index m = 0; m < positions.cols() / 3; ++m) {
                              if (Happens(percent / 100.0, random)) {
                                positions.row(t).segment<3>(3 * m).setConstant(kMissing);
                              }
                            }
                          }
                        });
}

// Masking states is equal to masking positions before the states are computed, unless hips or
// neighbouring frames of the marker are involved.
void Mask(int marker, core::StateSequence& states) {
  states.states.middleCols<6>(6 * marker).setConstant(kMissing);
}

Condition MissingThroughout(const core::MarkerSet& set, int percent) {
  const auto in_parts = [set, percent](Extent extent) {
    return [set, percent, extent](const EvalClip& clip) -> absl::StatusOr<States> {
      std::vector<int> markers;
      for (int m = 0; m < set.marker_count(); ++m) {
        if (m != set.landmarks.left_hip && m != set.landmarks.right_hip) markers.push_back(m);
      }
      const auto missing =
          static_cast<std::size_t>(std::lround(percent / 100.0 * set.marker_count()));
      States parts = SplitIntoParts(clip.states, extent);
      for (std::size_t p = 0; p < parts.size(); ++p) {
        std::mt19937 random = RandomFor(clip, static_cast<int>(p) + 1);
        for (std::size_t i = 0; i < missing; ++i) {  // a partial shuffle
          std::swap(markers[i], markers[i + random() % (markers.size() - i)]);
          Mask(markers[i], parts[p]);
        }
      }
      return parts;
    };
  };
  return {fmt::format("{} % of markers missing throughout", percent), in_parts(Extent::kWhole),
          in_parts(Extent::kWindow)};
}

Condition MissingLimb(std::string name, const core::MarkerSet& set,
                      const std::vector<std::string>& limb) {
  return Changed(std::move(name),
                 [set, limb](const EvalClip& clip) -> absl::StatusOr<core::StateSequence> {
                   core::StateSequence states = clip.states;
                   for (const std::string& marker : limb) {
                     const auto at = std::find(set.markers.begin(), set.markers.end(), marker);
                     if (at == set.markers.end())
                       return core::NotFound("marker set has no marker {}", marker);
                     Mask(static_cast<int>(at - set.markers.begin()), states);
                   }
                   return states;
                 });
}

Condition Noise(const core::MarkerSet& set, int centimetres) {
  return ChangedMarkers(fmt::format("marker noise of {} cm", centimetres), set,
                        [centimetres](const EvalClip& clip, core::FrameMatrix& positions) {
                          std::mt19937 random = RandomFor(clip);
                          std::normal_distribution<float> noise(
                              0, 0.01F * static_cast<float>(centimetres));
                          for (float& position : positions.reshaped()) position += noise(random);
                        });
}

Condition FrameRate(const core::MarkerSet& set, int rate_hz) {
  return Changed(fmt::format("resampled to {} Hz", rate_hz),
                 [set, rate_hz](const EvalClip& clip) -> absl::StatusOr<core::StateSequence> {
                   MOTIONDB_ASSIGN_OR_RETURN(const core::MarkerMotion resampled,
                                             core::Resample(clip.markers, rate_hz));
                   return StatesOf(set, resampled, clip.states.frame_rate_hz,
                                   clip.states.leg_length_m);
                 });
}

}  // namespace

std::vector<Condition> HardConditions(const core::MarkerSet& set) {
  std::vector<Condition> conditions{
      {"clean", Unchanged(Extent::kWhole), Unchanged(Extent::kWindow)}};
  for (const int percent : {10, 30, 50}) conditions.push_back(MissingFrames(set, percent));
  for (const int percent : {10, 30, 50}) conditions.push_back(MissingThroughout(set, percent));
  conditions.push_back(MissingLimb("right arm missing", set, kRightArm));
  conditions.push_back(MissingLimb("left leg missing", set, kLeftLeg));
  for (std::size_t c = 1; c < conditions.size(); ++c) conditions[c].markers_missing = true;
  for (const int centimetres : {1, 2, 5}) conditions.push_back(Noise(set, centimetres));
  for (const int rate_hz : {30, 60, 100, 120}) conditions.push_back(FrameRate(set, rate_hz));
  return conditions;
}

}  // namespace motiondb::tests
