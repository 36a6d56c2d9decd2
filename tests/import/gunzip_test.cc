#include "core/format/gunzip.h"

#include <catch2/catch.hpp>
#include <random>
#include <string>

#include "tests/core/format/reading.h"
#include "tests/import/npz/npz_files.h"

namespace motiondb::tests::gunzip_test {
namespace {

using Catch::Contains;

constexpr std::size_t kLimit = 10'000'000;

absl::StatusOr<std::string> Unzipped(const std::string& bytes, std::size_t limit = kLimit) {
  return core::Gunzip({.name = "walk.bvh.gz", .bytes = bytes}, limit);
}

std::string Noise(std::size_t size) {
  std::mt19937 random(5);
  std::string text;
  for (std::size_t i = 0; i < size; ++i) text += static_cast<char>(random());
  return text;
}

}  // namespace

TEST_CASE("Gunzip: the content comes back", "[import]") {
  for (const std::string& content :
       {std::string(), std::string("HIERARCHY\n"), Noise(1'000'000), std::string(3'000'000, 'x')}) {
    const auto read = Unzipped(Deflated(content, true));
    REQUIRE(read.ok());
    CHECK(*read == content);
  }
}

TEST_CASE("Gunzip: members follow each other", "[import]") {
  const auto read = Unzipped(Deflated("one ", true) + Deflated("", true) + Deflated("two", true));
  REQUIRE(read.ok());
  CHECK(*read == "one two");
}

TEST_CASE("Gunzip: a header with a file name", "[import]") {
  std::string bytes = Deflated("text", true);
  bytes[3] = 8;  // FNAME
  bytes.insert(10, std::string("walk.bvh\0", 9));
  const auto read = Unzipped(bytes);
  REQUIRE(read.ok());
  CHECK(*read == "text");
}

TEST_CASE("Gunzip: errors name the byte", "[import]") {
  const std::string bytes = Deflated(Noise(1000), true);
  CHECK_THAT(ErrorMessageOf(Unzipped("")), Contains("walk.bvh.gz: byte 0: expected a gzip file"));
  CHECK_THAT(ErrorMessageOf(Unzipped("HIERARCHY")), Contains("byte 0: expected a gzip file"));
  CHECK_THAT(ErrorMessageOf(Unzipped(bytes + "surplus")),
             Contains("byte " + std::to_string(bytes.size()) + ": expected the end of the file"));
  CHECK_THAT(ErrorMessageOf(Unzipped(bytes + std::string(512, '\0'))),
             Contains("expected the end of the file or another gzip member"));

  std::string wrong_checksum = bytes;
  wrong_checksum[bytes.size() - 8] ^= 1;
  CHECK_THAT(ErrorMessageOf(Unzipped(wrong_checksum)), Contains("incorrect data check"));
  std::string wrong_size = bytes;
  wrong_size[bytes.size() - 1] ^= 1;
  CHECK_THAT(ErrorMessageOf(Unzipped(wrong_size)), Contains("incorrect length check"));
  std::string wrong_method = bytes;
  wrong_method[2] = 7;
  CHECK_THAT(ErrorMessageOf(Unzipped(wrong_method)), Contains("corrupt gzip data"));
}

TEST_CASE("Gunzip: every truncation is an error", "[import]") {
  const std::string bytes = Deflated("one", true) + Deflated(Noise(200), true);
  const std::size_t first = Deflated("one", true).size();
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    if (size == first) continue;  // the first member is a complete file
    CAPTURE(size);
    CHECK_THAT(ErrorMessageOf(Unzipped(bytes.substr(0, size))), Contains("byte "));
  }
}

TEST_CASE("Gunzip: the limit counts decompressed bytes of all members", "[import]") {
  const std::string content(1'000'000, '\0');
  const std::string member = Deflated(content, true);
  CHECK(Unzipped(member, content.size()).ok());
  CHECK_THAT(ErrorMessageOf(Unzipped(member, content.size() - 1)),
             Contains("more than 999999 decompressed bytes"));
  std::string bomb;
  for (int i = 0; i < 1000; ++i) bomb += member;
  CHECK_THAT(ErrorMessageOf(Unzipped(bomb)), Contains("more than 10000000 decompressed bytes"));
}

TEST_CASE("PlainBytes: what is decompressed before an error counts", "[import]") {
  constexpr std::size_t kLimit = 1 << 20;
  const std::string content(500'000, 'x');
  const std::string bytes = Deflated(content, true);
  CHECK(core::PlainBytes(content, kLimit) == content.size());
  CHECK(core::PlainBytes(bytes, kLimit) == content.size());
  CHECK(core::PlainBytes(bytes + "surplus", kLimit) == content.size());
  CHECK(core::PlainBytes(bytes.substr(0, bytes.size() - 1), kLimit) >= content.size());
  CHECK(core::PlainBytes(bytes, 100'000) > 100'000);
  CHECK(core::PlainBytes("\x1f\x8b", kLimit) == 2);
}

TEST_CASE("Gunzip: gzip in gzip is decompressed once", "[import]") {
  const std::string inner = Deflated("text", true);
  const auto read = Unzipped(Deflated(inner, true));
  REQUIRE(read.ok());
  CHECK(*read == inner);
}

TEST_CASE("Gunzip: corrupt files are rejected or read", "[import]") {
  const std::string bytes = Deflated(Noise(300) + std::string(3000, 'a'), true);
  std::mt19937 random(3);
  for (int i = 0; i < 2000; ++i) {
    std::string corrupt = bytes;
    corrupt[random() % corrupt.size()] = static_cast<char>(random());
    Unzipped(corrupt).IgnoreError();  // under the sanitizers
  }
}

}  // namespace motiondb::tests::gunzip_test
