// The clips and segments of a database in memory, as filters and lists see them. A catalog is
// immutable: a change makes another one, which shares what is unchanged.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/filter/catalog_clip.h"
#include "server/filter/filter.h"
#include "storage/annotation_store.h"

namespace motiondb::server {

// Thread-safe. A pointer to a clip holds as long as a catalog that has the clip.
class Catalog {
 public:
  Catalog() = default;  // of a database without clips

  // Returns the catalog after changes, in the order of AnnotationStore::Changes, also if their
  // revisions are not above revision(): to apply a change twice has no effect. Models only set the
  // revision. O(number of clips / 128 + 128 * changed clips + their segments).
  Catalog With(std::span<const storage::ChangeRecord> changes) const;

  // Revision of the last change; 0 if there was none.
  std::int64_t revision() const { return revision_; }
  // The amount of its clips.
  const StoredAmount& stored() const { return stored_; }

  // Returns the clip, or null. O(log(number of clips)).
  const CatalogClip* Find(std::string_view id) const;

  // Calls visit(const CatalogClip&) for each clip in order of id, while it returns true.
  template <typename Visit>
  void ForEach(const Visit& visit) const;

 private:
  using ClipPointer = std::shared_ptr<const CatalogClip>;
  // At least one clip, in order of id.
  using Chunk = std::vector<ClipPointer>;
  // Changed clips by id; null: deleted.
  using Entries = std::map<std::string, std::shared_ptr<CatalogClip>>;

  // Index of the chunk that has or would have the clip; 0 without chunks.
  std::size_t ChunkOf(std::string_view id) const;
  // Returns the clip or its segments that precede it, or null.
  ClipPointer Entry(std::string_view id) const;
  // Loads what a filter will need of the clips after the i-th, which are anywhere in memory.
  static void Prefetch(const Chunk& chunk, std::size_t i);
  // Fills an empty catalog with the clips of another one and changed clips.
  void PutEntries(const Catalog& before, Entries changed);

  std::vector<std::shared_ptr<const Chunk>> chunks_;  // in order of id
  StoredAmount stored_;
  std::int64_t revision_ = 0;
};

inline void Catalog::Prefetch(const Chunk& chunk, std::size_t i) {
  constexpr std::size_t kClipsAhead = 16;
  constexpr std::size_t kSegmentsAhead = 8;
  constexpr std::ptrdiff_t kLineBytes = 64;
  if (i + kClipsAhead < chunk.size()) {
    const char* clip = reinterpret_cast<const char*>(chunk[i + kClipsAhead].get());
    for (int line = 0; line < 3; ++line) __builtin_prefetch(clip + line * kLineBytes);
  }
  if (i + kSegmentsAhead < chunk.size()) {
    const char* segments =
        reinterpret_cast<const char*>(chunk[i + kSegmentsAhead]->segments.data());
    __builtin_prefetch(segments);
    __builtin_prefetch(segments + kLineBytes);
  }
}

template <typename Visit>
void Catalog::ForEach(const Visit& visit) const {
  for (const auto& chunk : chunks_) {
    for (std::size_t i = 0; i < chunk->size(); ++i) {
      Prefetch(*chunk, i);
      const CatalogClip& clip = *(*chunk)[i];
      if (clip.is_stored && !visit(clip)) return;
    }
  }
}

}  // namespace motiondb::server
