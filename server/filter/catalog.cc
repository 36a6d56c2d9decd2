#include "server/filter/catalog.h"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>
#include <variant>

namespace motiondb::server {
namespace {

constexpr std::size_t kMaxChunkClips = 256;  // a full chunk becomes two

void SortSegments(std::vector<CatalogSegment>& segments) {
  std::sort(segments.begin(), segments.end(), [](const auto& a, const auto& b) {
    return std::tie(a.track, a.start_seconds, a.id) < std::tie(b.track, b.start_seconds, b.id);
  });
}

void PutSegment(const storage::SegmentRecord& record, CatalogClip& clip) {
  const auto found = std::find_if(clip.segments.begin(), clip.segments.end(),
                                  [&](const CatalogSegment& each) { return each.id == record.id; });
  if (found != clip.segments.end()) {
    *found = ToCatalogSegment(record);
  } else {
    clip.segments.push_back(ToCatalogSegment(record));
  }
}

// Makes chunks of clips in order of id, evenly filled.
template <typename Chunk>
void AppendChunks(Chunk clips, std::vector<std::shared_ptr<const Chunk>>& chunks) {
  if (clips.empty()) return;
  const std::size_t count = clips.size() <= kMaxChunkClips
                                ? 1
                                : (clips.size() + kMaxChunkClips / 2 - 1) / (kMaxChunkClips / 2);
  for (std::size_t i = 0; i < count; ++i) {
    const auto at = [&](std::size_t part) {
      return std::make_move_iterator(clips.begin() +
                                     static_cast<std::ptrdiff_t>(clips.size() * part / count));
    };
    chunks.push_back(std::make_shared<const Chunk>(at(i), at(i + 1)));
  }
}

}  // namespace

std::size_t Catalog::ChunkOf(std::string_view id) const {
  const auto after = std::upper_bound(
      chunks_.begin(), chunks_.end(), id,
      [](std::string_view wanted, const auto& chunk) { return wanted < chunk->front()->id; });
  return after == chunks_.begin() ? 0 : static_cast<std::size_t>(after - chunks_.begin()) - 1;
}

Catalog::ClipPointer Catalog::Entry(std::string_view id) const {
  if (chunks_.empty()) return nullptr;
  const Chunk& chunk = *chunks_[ChunkOf(id)];
  const auto found = std::lower_bound(
      chunk.begin(), chunk.end(), id,
      [](const ClipPointer& clip, std::string_view wanted) { return clip->id < wanted; });
  return found == chunk.end() || (*found)->id != id ? nullptr : *found;
}

const CatalogClip* Catalog::Find(std::string_view id) const {
  const ClipPointer entry = Entry(id);
  return entry == nullptr || !entry->is_stored ? nullptr : entry.get();
}

Catalog Catalog::With(std::span<const storage::ChangeRecord> changes) const {
  Catalog next;
  next.revision_ = revision_;
  Entries changed;
  // The clip to change: a copy of that of this catalog, or a new one.
  const auto entry_of = [&](const std::string& id) -> CatalogClip& {
    const auto [at, is_new] = changed.try_emplace(id);
    if (is_new) {
      if (const ClipPointer before = Entry(id); before != nullptr) {
        at->second = std::make_shared<CatalogClip>(*before);
      }
    }
    if (at->second == nullptr) {
      at->second = std::make_shared<CatalogClip>();
      at->second->id = id;
    }
    return *at->second;
  };
  for (const storage::ChangeRecord& record : changes) {
    next.revision_ = std::max(next.revision_, record.revision);
    if (const auto* clip = std::get_if<storage::ClipPut>(&record.change)) {
      SetRecord(clip->clip, entry_of(clip->clip.id));
    } else if (const auto* segment = std::get_if<storage::SegmentPut>(&record.change)) {
      PutSegment(segment->segment, entry_of(segment->segment.clip));
    } else if (const auto* deleted = std::get_if<storage::Deleted>(&record.change)) {
      if (deleted->segment.empty()) {
        changed[deleted->clip] = nullptr;
      } else {
        std::erase_if(entry_of(deleted->clip).segments,
                      [&](const CatalogSegment& each) { return each.id == deleted->segment; });
      }
    }
  }

  next.stored_ = stored_;
  for (const auto& [id, clip] : changed) {
    if (const CatalogClip* const before = Find(id); before != nullptr) {
      next.stored_ = next.stored_ + -AmountOf(*before);
    }
    if (clip != nullptr && clip->is_stored) next.stored_ = next.stored_ + AmountOf(*clip);
  }
  next.PutEntries(*this, std::move(changed));
  return next;
}

void Catalog::PutEntries(const Catalog& before, Entries changed) {
  auto change = changed.begin();
  const auto add_changed = [&](Chunk& clips) {
    std::shared_ptr<CatalogClip>& clip = change->second;
    if (clip != nullptr && (clip->is_stored || !clip->segments.empty())) {
      SortSegments(clip->segments);
      clips.push_back(std::move(clip));
    }
    ++change;
  };
  const auto& chunks = before.chunks_;
  for (std::size_t i = 0; i < chunks.size(); ++i) {
    const bool is_last = i + 1 == chunks.size();
    const auto is_in_chunk = [&] {
      return change != changed.end() && (is_last || change->first < chunks[i + 1]->front()->id);
    };
    if (!is_in_chunk()) {
      chunks_.push_back(chunks[i]);
      continue;
    }
    Chunk merged;
    for (const ClipPointer& clip : *chunks[i]) {
      while (is_in_chunk() && change->first < clip->id) add_changed(merged);
      if (is_in_chunk() && change->first == clip->id) {
        add_changed(merged);
      } else {
        merged.push_back(clip);
      }
    }
    while (is_in_chunk()) add_changed(merged);
    AppendChunks(std::move(merged), chunks_);
  }
  Chunk added;
  while (change != changed.end()) add_changed(added);
  AppendChunks(std::move(added), chunks_);
}

}  // namespace motiondb::server
