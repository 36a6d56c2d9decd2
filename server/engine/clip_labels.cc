#include "server/engine/clip_labels.h"

#include "storage/clip_segments.h"

namespace motiondb::server {

std::optional<std::vector<core::ClipLabels>> StoredLabels(const core::Model& model,
                                                          const Catalog& catalog) {
  std::vector<core::ClipLabels> labels;
  labels.reserve(model.clips().size());
  bool is_changed = false;
  for (const core::ModelClip& clip : model.clips()) {
    const CatalogClip* const stored = catalog.Find(clip.id);
    if (stored == nullptr) {
      labels.push_back({clip.labels, clip.subject});
      continue;
    }
    labels.push_back(
        {storage::LabelTracksOf(stored->segments, model.settings().frame_rate_hz, clip.frame_count),
         stored->subject});
    is_changed =
        is_changed || labels.back().labels != clip.labels || labels.back().subject != clip.subject;
  }
  if (!is_changed) return std::nullopt;
  return labels;
}

}  // namespace motiondb::server
