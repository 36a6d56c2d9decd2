// Random clips with segments from few values, so that they agree often.
#pragma once

#include <map>
#include <random>
#include <string>
#include <vector>

#include "server/filter/catalog.h"
#include "storage/annotation_store.h"

namespace motiondb::tests {

using Random = std::mt19937_64;

// Returns a number below `count`.
int Below(Random& random, int count);

// Returns one of some values.
template <typename Values>
auto OneOf(Random& random, const Values& values) {
  return *(std::begin(values) + Below(random, static_cast<int>(std::size(values))));
}

// A stored clip with its segments, as a test knows it.
struct StoredClip {
  storage::ClipRecord record;
  std::vector<storage::SegmentRecord> segments;
};
using StoredClips = std::map<std::string, StoredClip>;  // by id

storage::ClipRecord RandomClip(Random& random, const std::string& id);
storage::SegmentRecord RandomSegment(Random& random, const std::string& clip,
                                     const std::string& id);
// At most three segments.
StoredClip RandomStoredClip(Random& random, const std::string& id);

// Returns the catalog of some clips.
server::Catalog CatalogOf(const StoredClips& clips);

// Returns the changes that put a clip and its segments.
std::vector<storage::ChangeRecord> ChangesOf(const StoredClip& clip);

}  // namespace motiondb::tests
