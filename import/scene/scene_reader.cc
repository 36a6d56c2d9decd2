#include "import/scene/scene_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "core/format/conventions.h"
#include "core/motion/error.h"
#include "core/motion/motion.h"
#include "import/scene/scene_conventions.h"
#include "import/scene/scene_file.h"
#include "import/scene/scene_motion.h"
#include "import/scene/scene_nodes.h"
#include "import/scene/scene_skeleton.h"
#include "import/scene/scene_timing.h"
#include "import/scene/scene_tracks.h"

namespace motiondb::importer {

namespace {

bool HasChannels(const aiScene& scene) {
  return std::any_of(scene.mAnimations, scene.mAnimations + scene.mNumAnimations,
                     [](const aiAnimation* animation) { return animation->mNumChannels > 0; });
}

std::vector<core::TakeInfo> InfoOfTakes(const std::vector<SceneTake>& takes) {
  std::vector<core::TakeInfo> infos;
  infos.reserve(takes.size());
  for (const SceneTake& take : takes) {
    infos.push_back({take.name, take.animation->mDuration / TicksPerSecond(*take.animation)});
  }
  return infos;
}

// Estimates the conventions from the figure, in the file's unit.
absl::StatusOr<core::DeducedConventions> DeduceFromTake(const SceneSkeleton& skeleton,
                                                        const TakeSampler& sampler,
                                                        double scene_units_per_unit) {
  std::vector<std::string> names;
  std::vector<core::Joint> joints;
  for (const SceneJoint& joint : skeleton.joints) {
    names.push_back(joint.name);
    joints.push_back({.name = joint.name, .parent = joint.parent});
  }
  MOTIONDB_ASSIGN_OR_RETURN(const core::Skeleton hierarchy,
                            core::Skeleton::Create(names.front(), std::move(joints)));
  core::FrameMatrix positions = sampler.SamplePositions();
  positions /= static_cast<float>(scene_units_per_unit);
  return core::DeduceConventions(names, positions, &hierarchy);
}

void DecideSceneConventions(const core::ReadOptions& options, const StatedConventions& stated,
                            const core::DeducedConventions& deduced, double usual_unit,
                            core::SourceReport& report) {
  core::DecideUnit(options.metres_per_unit, stated.metres_per_unit, deduced, usual_unit, report);
  core::DecideUpAxis({.given = options.up_axis,
                      .stated = stated.up_axis,
                      .deduced = deduced.up_axis,
                      .fallback = core::UpAxis::kY},
                     report);
  constexpr double kLeastStature_m = 0.5;
  constexpr double kGreatestStature_m = 3;
  if (!deduced.stature || report.unit_provenance != core::Provenance::kStated) return;
  const double stature_m = *deduced.stature * report.metres_per_unit;
  if (stature_m < kLeastStature_m || stature_m > kGreatestStature_m) {
    report.notes.push_back(fmt::format(
        "the stated unit gives a stature of {:.3g} m: give the unit if it is wrong", stature_m));
  }
}

}  // namespace

absl::StatusOr<core::MotionFile> ReadScene(core::FileFormat format, core::SourceFile file,
                                           const core::ReadOptions& options) {
  MOTIONDB_ASSIGN_OR_RETURN(SceneFile loaded, LoadScene(format, file));
  const aiScene& scene = *loaded.scene;
  const std::vector<SceneNode> nodes = SceneNodes(scene);
  if (!HasChannels(scene)) {
    return core::InvalidArgument("{}: has no animation: {}{}", file.name,
                                 SceneContent(scene, nodes),
                                 loaded.notes.empty() ? "" : "; " + loaded.notes.front());
  }
  core::MotionFile read;
  core::SourceReport& report = read.report;
  report.notes = std::move(loaded.notes);
  const NodePlaces places = FindPlaces(nodes);
  const std::vector<NodeUse> uses = UsesOfNodes(scene, nodes, places);
  MOTIONDB_ASSIGN_OR_RETURN(const SceneSkeleton skeleton,
                            FindSkeleton(file.name, scene, nodes, uses, report.notes));
  const std::vector<SceneTake> takes = FindTakes(scene, places, uses);
  MOTIONDB_ASSIGN_OR_RETURN(const SceneTake take, ChooseTake(file.name, takes, options.take));
  MOTIONDB_ASSIGN_OR_RETURN(
      const std::vector<JointTrack> tracks,
      FindTracks(file.name, format, nodes, places, skeleton, take, loaded.curves));
  MOTIONDB_ASSIGN_OR_RETURN(const StatedConventions stated,
                            FindStatedConventions(format, file, scene, report.notes));
  MOTIONDB_ASSIGN_OR_RETURN(
      const SceneTiming timing,
      TimeTake(file.name, take, tracks, {stated.frame_rate_hz, loaded.key_rate_hz}, report.notes));

  TakeSampler sampler({file.name, skeleton, tracks, timing});
  MOTIONDB_RETURN_IF_ERROR(sampler.Measure());
  MOTIONDB_ASSIGN_OR_RETURN(const core::DeducedConventions deduced,
                            DeduceFromTake(skeleton, sampler, stated.scene_units_per_unit));
  constexpr double kColladaUnit_m = 1;
  DecideSceneConventions(options, stated, deduced, kColladaUnit_m, report);
  MOTIONDB_ASSIGN_OR_RETURN(
      core::JointMotion motion,
      sampler.Motion(report, report.metres_per_unit / stated.scene_units_per_unit));
  if (options.frame_rate_hz) motion.frame_rate_hz = *options.frame_rate_hz;
  read.motion = std::move(motion);
  if (!options.take.empty()) read.take = take.name;
  if (takes.size() > 1) read.takes = InfoOfTakes(takes);
  return read;
}

}  // namespace motiondb::importer
