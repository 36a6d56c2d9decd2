#include "client/cli/annotate/clip_index.h"

#include "client/cli/motion_file.h"
#include "client/cli/resource_name.h"

namespace motiondb::client {
namespace {

// "folder/walk.bvh.gz" -> "walk".
std::string MotionStem(const std::string& path) {
  const std::string name = path.substr(path.find_last_of("/\\") + 1);
  const std::string extension = MotionExtension(name);
  if (extension.empty() || name.size() <= extension.size()) return name;
  return name.substr(0, name.rfind('.', name.size() - (name.ends_with(".gz") ? 4 : 1)));
}

}  // namespace

ClipIndex::ClipIndex(const std::vector<v1::Clip>& clips) {
  for (const v1::Clip& clip : clips) {
    const std::string id = ShortName(clip.name());
    clips_[id] = clip;
    const std::string stem = MotionStem(clip.file_name());
    if (!id_of_.emplace(stem, id).second) ambiguous_.insert(stem);
  }
}

const v1::Clip* ClipIndex::Find(const std::string& name) const {
  const std::string last = ShortName(name);
  const std::string stem = MotionStem(name);
  for (const std::string& id : {last, stem}) {
    if (const auto found = clips_.find(id); found != clips_.end()) return &found->second;
  }
  for (const std::string& file : {stem, last}) {
    const auto found = id_of_.find(file);
    if (found != id_of_.end() && !ambiguous_.contains(file)) return &clips_.at(found->second);
  }
  return nullptr;
}

std::string ClipIndex::FileNameOf(const v1::Clip& clip) const {
  const std::string stem = MotionStem(clip.file_name());
  const v1::Clip* const found = Find(stem);
  if (found != nullptr && found->name() == clip.name()) return clip.file_name();
  return ShortName(clip.name()) + MotionExtension(clip.file_name());
}

std::vector<std::string> ClipIndex::Names() const {
  std::vector<std::string> names;
  for (const auto& [id, clip] : clips_) names.push_back(id);
  return names;
}

}  // namespace motiondb::client
