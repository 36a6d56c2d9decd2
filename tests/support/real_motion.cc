#include "tests/support/real_motion.h"

#include <catch2/catch.hpp>

#include "core/format/marker_set_file.h"
#include "core/mapping/fit_scheme.h"

namespace motiondb::tests {
namespace fs = std::filesystem;

core::MotionFile LoadMotion(const fs::path& path) {
  auto file = ReadMotion(path);
  INFO(file.status());
  REQUIRE(file.ok());
  return *std::move(file);
}

core::StateSequence LoadStates(const fs::path& path, double frame_rate_hz,
                               core::Cleaning cleaning) {
  const core::MotionFile file = LoadMotion(path);
  const auto fitted = core::FitScheme(core::StandardScheme(), file.motion,
                                      cleaning ? core::FitFor::kClip : core::FitFor::kQuery);
  INFO(path << ": " << fitted.status());
  REQUIRE(fitted.ok());
  auto states = core::Represent(*fitted, file.motion, frame_rate_hz, cleaning);
  INFO(path << ": " << states.status());
  REQUIRE(states.ok());
  return *std::move(states);
}

std::vector<ListedClip> ReadList(const fs::path& list) {
  auto clips = ReadClipList(list);
  INFO(clips.status());
  REQUIRE(clips.ok());
  return *std::move(clips);
}

core::Model BuildFromList(const fs::path& list, const core::BuildSettings& settings) {
  std::vector<core::BuildInput> inputs;
  for (const ListedClip& clip : ReadList(list)) {
    inputs.push_back(
        {clip.path.stem().string(), clip.label, LoadStates(clip.path, settings.frame_rate_hz)});
  }
  auto model = core::BuildModel(settings, core::StandardScheme().set, std::move(inputs),
                                core::RunSerially, {});
  INFO(model.status());
  REQUIRE(model.ok());
  return *std::move(model);
}

}  // namespace motiondb::tests
