#include "import/scene/fbx_layers.h"

#include <fmt/format.h>

#include <cstddef>

namespace motiondb::importer {

namespace {

std::size_t CountText(std::string_view bytes, std::string_view text) {
  std::size_t count = 0;
  for (std::size_t at = bytes.find(text); at != bytes.npos; at = bytes.find(text, at + 1)) ++count;
  return count;
}

// Counts the objects of a class: in binary files, names of records follow their length as one byte
// (strings: as four bytes); in text files, ": " follows them.
std::size_t CountFbxObjects(std::string_view bytes, std::string_view name) {
  const bool is_binary = bytes.starts_with("Kaydara FBX Binary");
  return CountText(bytes, is_binary ? fmt::format("{}{}", static_cast<char>(name.size()), name)
                                    : fmt::format("{}: ", name));
}

}  // namespace

std::optional<std::string> NoteOnFbxLayers(std::string_view bytes) {
  const std::size_t layers = CountFbxObjects(bytes, "AnimationLayer");
  const std::size_t takes = CountFbxObjects(bytes, "AnimationStack");
  if (layers <= takes || takes == 0) return std::nullopt;
  return fmt::format(
      "{} animation layers in {} take{}: layers are not blended, so that the motion may be wrong; "
      "bake or merge the layers before you export the file",
      layers, takes, takes == 1 ? "" : "s");
}

}  // namespace motiondb::importer
