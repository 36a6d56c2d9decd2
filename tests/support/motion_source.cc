#include "tests/support/motion_source.h"

#include <fstream>
#include <optional>
#include <sstream>

#include "core/motion/error.h"

namespace motiondb::tests {
namespace fs = std::filesystem;

namespace {

absl::StatusOr<fs::path> SkeletonOf(const fs::path& amc) {
  fs::path best;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(amc.parent_path(), error)) {
    const fs::path& path = entry.path();
    if (path.extension() == ".asf" && amc.stem().string().starts_with(path.stem().string()) &&
        path.stem().string().size() > best.stem().string().size()) {
      best = path;
    }
  }
  if (best.empty())
    return core::NotFound("{}: expected its skeleton (.asf) in the same folder", amc.string());
  return best;
}

}  // namespace

absl::StatusOr<std::string> ReadBytes(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return core::NotFound("{}: cannot read the file", path.string());
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

absl::StatusOr<core::MotionFile> ReadMotion(const fs::path& path) {
  MOTIONDB_ASSIGN_OR_RETURN(const core::FileFormat format, core::FormatOfPath(path.string()));
  MOTIONDB_ASSIGN_OR_RETURN(const std::string bytes, ReadBytes(path));
  std::string skeleton_bytes;
  std::optional<core::SourceFile> skeleton;
  if (format == core::FileFormat::kAmc) {
    MOTIONDB_ASSIGN_OR_RETURN(const fs::path asf, SkeletonOf(path));
    MOTIONDB_ASSIGN_OR_RETURN(skeleton_bytes, ReadBytes(asf));
    skeleton = core::SourceFile{"skeleton.asf", skeleton_bytes};
  }
  const std::string name = path.filename().string();
  return core::ReadMotionFile(format, {name, bytes}, skeleton);
}

absl::StatusOr<std::vector<ListedClip>> ReadClipList(const fs::path& list) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::string text, ReadBytes(list));
  std::istringstream lines(text);
  std::vector<ListedClip> clips;
  std::string line;
  std::getline(lines, line);  // header
  while (std::getline(lines, line)) {
    if (line.ends_with('\r')) line.pop_back();
    const std::size_t tab = line.find('\t');
    if (tab == std::string::npos) continue;
    clips.push_back({list.parent_path() / line.substr(0, tab), line.substr(tab + 1)});
  }
  return clips;
}

}  // namespace motiondb::tests
