#include "tests/support/real_motion.h"

#include <catch2/catch.hpp>
#include <sstream>

#include "core/format/marker_set_file.h"
#include "tests/support/real_data.h"

namespace motiondb::tests {
namespace fs = std::filesystem;

namespace {

fs::path SkeletonOf(const fs::path& amc) {
  fs::path best;
  for (const auto& entry : fs::directory_iterator(amc.parent_path())) {
    const fs::path& path = entry.path();
    if (path.extension() == ".asf" && amc.stem().string().starts_with(path.stem().string()) &&
        path.stem().string().size() > best.stem().string().size()) {
      best = path;
    }
  }
  return best;
}

}  // namespace

core::MotionFile LoadMotion(const fs::path& path) {
  const auto format = core::FormatOfPath(path.string());
  REQUIRE(format.ok());
  const std::string name = path.filename().string();
  const std::string bytes = ReadFile(path);
  std::string skeleton_bytes;
  std::optional<core::SourceFile> skeleton;
  if (*format == core::FileFormat::kAmc) {
    skeleton_bytes = ReadFile(SkeletonOf(path));
    skeleton = core::SourceFile{"skeleton.asf", skeleton_bytes};
  }
  auto file = core::ReadMotionFile(*format, {name, bytes}, skeleton);
  INFO(file.status());
  REQUIRE(file.ok());
  return *std::move(file);
}

core::StateSequence LoadStates(const fs::path& path, double frame_rate_hz, core::Gaps gaps) {
  auto states =
      core::Represent(core::StandardScheme(), LoadMotion(path).motion, frame_rate_hz, gaps);
  INFO(path << ": " << states.status());
  REQUIRE(states.ok());
  return *std::move(states);
}

std::vector<ListedClip> ReadList(const fs::path& list) {
  std::istringstream lines(ReadFile(list));
  std::vector<ListedClip> clips;
  std::string line;
  std::getline(lines, line);  // header
  while (std::getline(lines, line)) {
    const std::size_t tab = line.find('\t');
    if (tab == std::string::npos) continue;
    clips.push_back({list.parent_path() / line.substr(0, tab), line.substr(tab + 1)});
  }
  return clips;
}

core::Model BuildFromList(const fs::path& list, const core::BuildSettings& settings) {
  std::vector<core::BuildInput> inputs;
  for (const ListedClip& clip : ReadList(list)) {
    inputs.push_back(
        {clip.path.stem().string(), clip.label, LoadStates(clip.path, settings.frame_rate_hz)});
  }
  auto model =
      core::BuildModel(settings, core::StandardScheme().set, std::move(inputs), core::Serially, {});
  INFO(model.status());
  REQUIRE(model.ok());
  return *std::move(model);
}

}  // namespace motiondb::tests
