// Animation layers of FBX files.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace motiondb::importer {

// Returns a note if the takes of an FBX file, binary or text, have more than one layer each: assimp
// 5.2 does not blend layers, but overwrites the keys of one with those of another, and gives no
// sign of it. Takes and layers are counted in the bytes. O(bytes).
std::optional<std::string> NoteOnFbxLayers(std::string_view bytes);

}  // namespace motiondb::importer
