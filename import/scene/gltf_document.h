// The JSON and the numbers of a glTF 2.0 file.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"

namespace motiondb::importer {

using GltfJson = nlohmann::json;

// Numbers of an accessor, and where they come from: "accessors[3]".
struct GltfAccessor {
  const GltfJson* json = nullptr;
  std::string path = {};
  std::size_t count = 0;  // of elements
  std::size_t width = 0;  // numbers of an element; 0: a matrix
  int component = 0;      // componentType
};

// Component types of glTF.
inline constexpr int kGltfByte = 5120;
inline constexpr int kGltfUnsignedByte = 5121;
inline constexpr int kGltfShort = 5122;
inline constexpr int kGltfUnsignedShort = 5123;
inline constexpr int kGltfUnsignedInt = 5125;
inline constexpr int kGltfFloat = 5126;

// Bytes of a number; 0 for other component types.
std::size_t GltfComponentBytes(int component);

class GltfDocument {
 public:
  // Parses glTF text or GLB, whose bytes must outlive the document. INVALID_ARGUMENT, with the
  // byte, if a GLB is truncated or has no JSON chunk, if the JSON is invalid, or if its version is
  // not 2. Throws std::bad_alloc.
  static absl::StatusOr<GltfDocument> Parse(core::SourceFile file);

  std::string_view file_name() const { return file_.name; }
  const GltfJson& json() const { return json_; }

  // Returns an element of an array of the document, or nothing. `index`: a JSON number.
  const GltfJson* Find(const char* array, const GltfJson& index) const;

  // Returns an accessor. INVALID_ARGUMENT, with its path, if there is none or if its component
  // type, type or count is not one of glTF.
  absl::StatusOr<GltfAccessor> Accessor(const GltfJson& index) const;

  // Returns the numbers of an accessor, count x width; normalized integers are divided by their
  // greatest value. INVALID_ARGUMENT, with the path, if they are beyond the buffer, sparse, in
  // another file, or not finite. O(count).
  absl::StatusOr<std::vector<float>> Numbers(const GltfAccessor& accessor) const;

 private:
  explicit GltfDocument(core::SourceFile file) : file_(file) {}

  // Returns the bytes of a buffer; `storage` keeps decoded ones.
  absl::StatusOr<std::string_view> Buffer(const GltfJson& index, std::string& storage) const;

  core::SourceFile file_;
  GltfJson json_;
  std::string_view binary_;  // the chunk of a GLB
};

// Returns a member that is an integer from 0 to 2^53; nothing if it is missing or another value.
std::optional<std::size_t> GltfUnsigned(const GltfJson& object, const char* member);

// Returns a member, or null if it is missing or if `object` is none.
const GltfJson& GltfMember(const GltfJson& object, const char* member);

}  // namespace motiondb::importer
