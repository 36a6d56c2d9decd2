#include "server/engine/file_names.h"

#include <catch2/catch.hpp>

namespace motiondb::server::file_names_test {
namespace {

TEST_CASE("FileNames: folders are removed for both kinds of slash", "[server]") {
  CHECK(WithoutFolders("walk.bvh") == "walk.bvh");
  CHECK(WithoutFolders("/a/b/walk.bvh") == "walk.bvh");
  CHECK(WithoutFolders("C:\\motion\\walk.bvh") == "walk.bvh");
  CHECK(WithoutFolders("folder/") == "");
}

TEST_CASE("FileNames: a clip id is the stem, with '_' for invalid characters", "[server]") {
  CHECK(ClipIdFromFileName("02_01.amc") == "02_01");
  CHECK(ClipIdFromFileName("my walk (3).bvh") == "my_walk__3_");
  CHECK(ClipIdFromFileName("a.b.bvh") == "a.b");
  CHECK(ClipIdFromFileName("gehen-schr\xc3\xa4g.bvh") == "gehen-schr_g");
  CHECK(ClipIdFromFileName("walk") == "walk");
  CHECK(ClipIdFromFileName(".bvh") == "clip");
  CHECK(ClipIdFromFileName(std::string(300, 'x') + ".bvh") == std::string(120, 'x'));
}

TEST_CASE("ContentHash: distinguishes bytes and the boundary between files", "[server]") {
  CHECK(ContentHash("ab", "c") == ContentHash("ab", "c"));
  CHECK(ContentHash("ab", "c") != ContentHash("a", "bc"));
  CHECK(ContentHash("ab", "c") != ContentHash("abc", ""));
  CHECK(ContentHash("", "") != ContentHash(std::string(1, '\0'), ""));
}

}  // namespace
}  // namespace motiondb::server::file_names_test
