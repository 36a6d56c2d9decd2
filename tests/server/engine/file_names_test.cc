#include <catch2/catch.hpp>

#include "server/engine/ingest_rules.h"

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
  CHECK(ClipIdFromFileName("walk") == "walk");
  CHECK(ClipIdFromFileName(".bvh") == "clip");
  CHECK(ClipIdFromFileName(std::string(300, 'x') + ".bvh") == std::string(120, 'x'));
}

TEST_CASE("FileNames: a clip id keeps what names in other alphabets tell apart", "[server]") {
  CHECK(ClipIdFromFileName("gehen-schr\u00e4g.bvh") == "gehen-schrag");
  CHECK(ClipIdFromFileName("\u00dcbung.bvh") == "Ubung");
  CHECK(ClipIdFromFileName("U\u0308bung.bvh") == "Ubung");  // decomposed, as on macOS
  CHECK(ClipIdFromFileName("stra\u00dfe \u00c6\u0152\u0178\u017e.bvh") == "strase_AOYz");
  CHECK(ClipIdFromFileName("\u6b69\u884c.bvh", "\u8d70") == "u6b69u884c-u8d70");
  CHECK(ClipIdFromFileName("\U0001F600.bvh") == "u1f600");
  CHECK(ClipIdFromFileName("bad\xff\xc3.bvh") == "bad__");
  std::string long_name;
  for (int i = 0; i < 100; ++i) long_name += "\u6b69";
  CHECK(ClipIdFromFileName(long_name + ".bvh").size() == 120);
  // Every character of two bytes gives an id that is allowed.
  for (char32_t code = 0x80; code < 0x800; ++code) {
    const std::string name = {static_cast<char>(0xC0 | code >> 6),
                              static_cast<char>(0x80 | (code & 0x3F)), 'x'};
    const std::string id = ClipIdFromFileName(name + ".bvh");
    CHECK(id.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_") ==
          id.npos);
    CHECK(id.ends_with('x'));
  }
}

TEST_CASE("ContentHash: distinguishes bytes and the boundary between files", "[server]") {
  CHECK(ContentHash("ab", "c") == ContentHash("ab", "c"));
  CHECK(ContentHash("ab", "c") != ContentHash("a", "bc"));
  CHECK(ContentHash("ab", "c") != ContentHash("abc", ""));
  CHECK(ContentHash("", "") != ContentHash(std::string(1, '\0'), ""));
}

}  // namespace
}  // namespace motiondb::server::file_names_test
