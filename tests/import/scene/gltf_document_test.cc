#include "import/scene/gltf_document.h"

#include <catch2/catch.hpp>
#include <cstddef>
#include <string>
#include <string_view>

#include "tests/core/format/reading.h"
#include "tests/import/scene/scene_files.h"

namespace motiondb::tests::gltf_document_test {
namespace {

using Catch::Contains;

absl::StatusOr<importer::GltfDocument> ParseDocument(std::string_view bytes) {
  return importer::GltfDocument::Parse({.name = "walk.glb", .bytes = bytes});
}

}  // namespace

TEST_CASE("glTF document: numbers of text and binary files", "[import][scene]") {
  GltfFile file;
  file.AddFloats({1, 2, 3, 4, 5, 6}, 3);
  file.AddShorts({-1, 0, 0.5F, 1}, 4);
  for (const std::string& bytes : {file.Text(), file.Binary()}) {
    const auto document = ParseDocument(bytes);
    REQUIRE(document.ok());
    const auto floats = document->Accessor(0U);
    REQUIRE(floats.ok());
    CHECK(floats->count == 2);
    CHECK(*document->Numbers(*floats) == std::vector<float>{1, 2, 3, 4, 5, 6});
    const auto shorts = document->Numbers(*document->Accessor(1U));
    REQUIRE(shorts.ok());
    CHECK(std::abs((*shorts)[2] - 0.5F) < 1e-4F);
    CHECK((*shorts)[0] == -1);
    CHECK((*shorts)[3] == 1);
    CHECK_THAT(ErrorMessageOf(document->Accessor(2U)), Contains("accessors[2]"));
  }
}

TEST_CASE("glTF document: errors name the byte", "[import][scene]") {
  const std::string glb = NoddingFigure(10).Binary();
  for (std::size_t size = 4; size < glb.size(); size += 7) {
    INFO(size);
    CHECK_THAT(
        ErrorMessageOf(ParseDocument(std::string_view(glb).substr(0, size))),
        Contains("is truncated: its ") && Contains("the file at byte " + std::to_string(size)));
  }
  const std::string text = NoddingFigure(3).Text();
  CHECK_THAT(ErrorMessageOf(ParseDocument(std::string_view(text).substr(0, 100))),
             Contains("walk.glb: is truncated at byte 100 (line 1 of its JSON)"));
  CHECK_THAT(ErrorMessageOf(ParseDocument("{\n\"asset\": ?}")),
             Contains("walk.glb: invalid JSON at byte 11 (line 2 of its JSON)"));
}

TEST_CASE("glTF document: hostile accessors are rejected", "[import][scene]") {
  const auto with = [](const char* array, const char* member, const nlohmann::json& value) {
    GltfFile file;
    file.AddFloats({1, 2, 3}, 1);
    file.json[array][0][member] = value;
    const std::string text = file.Text();
    const auto document = ParseDocument(text);
    REQUIRE(document.ok());
    const auto accessor = document->Accessor(0U);
    return accessor.ok() ? document->Numbers(*accessor).status() : accessor.status();
  };
  CHECK(with("accessors", "count", 3).ok());
  constexpr std::size_t kMost = std::size_t{1} << 53;
  for (const nlohmann::json& count :
       {nlohmann::json(4), nlohmann::json(kMost), nlohmann::json(kMost + 1), nlohmann::json(-1)}) {
    CHECK_FALSE(with("accessors", "count", count).ok());
  }
  CHECK_FALSE(with("accessors", "byteOffset", kMost).ok());
  CHECK_FALSE(with("bufferViews", "byteOffset", 4).ok());
  CHECK_FALSE(with("bufferViews", "byteStride", kMost).ok());
  CHECK_FALSE(with("bufferViews", "byteStride", 1).ok());
  CHECK_FALSE(with("buffers", "uri", "data:application/octet-stream;base64,!").ok());
  CHECK_FALSE(with("buffers", "uri", "other.bin").ok());
}

}  // namespace motiondb::tests::gltf_document_test
