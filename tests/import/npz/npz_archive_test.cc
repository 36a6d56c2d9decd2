#include "import/npz/npz_archive.h"

#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

#include "tests/core/format/reading.h"
#include "tests/import/npz/npz_files.h"

namespace motiondb::tests::npz_archive_test {
namespace {

using Catch::Contains;
using importer::NpyArray;
using importer::NpzArchive;

constexpr std::size_t kMegabyte = 1'000'000;

// Reads the only array, `a`, of an archive.
absl::StatusOr<NpyArray> ReadOnly(const std::string& npy, std::size_t max_bytes = kMegabyte) {
  const std::string bytes = Zip({{.name = "a.npy", .content = npy}});
  auto archive = NpzArchive::Open({.name = "walk.npz", .bytes = bytes}, max_bytes);
  if (!archive.ok()) return archive.status();
  return archive->Read("a");
}

std::vector<double> NumbersOf(const absl::StatusOr<NpyArray>& array) {
  INFO(MessageOf(array.status()));
  REQUIRE(array.ok());
  std::vector<double> numbers;
  for (std::size_t i = 0; i < array->size(); ++i) numbers.push_back(array->Number(i));
  return numbers;
}

std::string ErrorOfHeader(const std::string& header, const std::string& data = "") {
  return ErrorMessageOf(ReadOnly(Npy(header, data)));
}

// Opens an archive and reads all arrays; whether that succeeds does not matter.
void ReadEverything(const std::string& bytes) {
  auto archive = NpzArchive::Open({.name = "walk.npz", .bytes = bytes}, kMegabyte);
  if (!archive.ok()) return;
  for (const std::string& name : archive->names()) {
    const auto array = archive->Read(name);
    for (std::size_t i = 0; array.ok() && i < array->size(); ++i) {
      if (array->is_text()) {
        array->Text(i);
      } else {
        array->Number(i);
      }
    }
  }
}

}  // namespace

TEST_CASE("NpzArchive: numbers of all types and byte orders", "[import]") {
  const std::vector<double> numbers = {0, 1, 100, 27, 3, 64};
  const auto check = [&](std::string_view type, const std::string& data) {
    CAPTURE(type);
    CHECK(NumbersOf(ReadOnly(Npy(NpyDictionary(type, {2, 3}), data))) == numbers);
  };
  check("<f8", BytesOf<double>(numbers));
  check(">f8", BytesOf<double>(numbers, true));
  check("<f4", BytesOf<float>(numbers));
  check(">f4", BytesOf<float>(numbers, true));
  check("|i1", BytesOf<std::int8_t>(numbers));
  check("<i2", BytesOf<std::int16_t>(numbers));
  check(">i4", BytesOf<std::int32_t>(numbers, true));
  check("<i8", BytesOf<std::int64_t>(numbers));
  check("|u1", BytesOf<std::uint8_t>(numbers));
  check(">u2", BytesOf<std::uint16_t>(numbers, true));
  check("<u4", BytesOf<std::uint32_t>(numbers));
  check("<u8", BytesOf<std::uint64_t>(numbers));
}

TEST_CASE("NpzArchive: negative, boolean and half precision numbers", "[import]") {
  const std::vector<double> negative = {-1, -128, 127};
  CHECK(NumbersOf(ReadOnly(Npy(NpyDictionary("|i1", {3}), BytesOf<std::int8_t>(negative)))) ==
        negative);
  CHECK(NumbersOf(ReadOnly(
            Npy(NpyDictionary(">i8", {3}), BytesOf<std::int64_t>(negative, true)))) == negative);
  CHECK(NumbersOf(ReadOnly(Npy(NpyDictionary("|b1", {2}), std::string("\x00\x01", 2)))) ==
        std::vector<double>{0, 1});
  // 1, -2, the largest, the smallest, infinity
  const std::string halves("\x00\x3c\x00\xc0\xff\x7b\x01\x00\x00\x7c", 10);
  const std::vector<double> read = NumbersOf(ReadOnly(Npy(NpyDictionary("<f2", {5}), halves)));
  CHECK(read == std::vector<double>{1, -2, 65504, std::ldexp(1.0, -24),
                                    std::numeric_limits<double>::infinity()});
}

TEST_CASE("NpzArchive: C and Fortran order give the same array", "[import]") {
  const auto c = ReadOnly(Npy(NpyDictionary("|i1", {2, 3, 2}),
                              BytesOf<std::int8_t>({0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11})));
  const auto fortran = ReadOnly(Npy(NpyDictionary("|i1", {2, 3, 2}, true),
                                    BytesOf<std::int8_t>({0, 6, 2, 8, 4, 10, 1, 7, 3, 9, 5, 11})));
  CHECK(NumbersOf(c) == NumbersOf(fortran));
  CHECK(importer::ShapeText(fortran->shape()) == "(2, 3, 2)");
}

TEST_CASE("NpzArchive: texts", "[import]") {
  const std::string wide("a\0\0\0\x2d\x4e\0\0\0\0\0\0\0\0\0\0", 16);  // "a中", ""
  const auto unicode = ReadOnly(Npy(NpyDictionary("<U2", {2}), wide));
  REQUIRE(unicode.ok());
  CHECK(unicode->Text(0) == "a\xe4\xb8\xad");
  CHECK(unicode->Text(1).empty());
  const auto bytes = ReadOnly(Npy(NpyDictionary("|S6", {}), std::string("male\0\0", 6)));
  REQUIRE(bytes.ok());
  CHECK(bytes->is_text());
  CHECK(bytes->Text(0) == "male");
  const auto invalid = ReadOnly(Npy(NpyDictionary("<U1", {}), "\xff\xff\xff\xff"));
  REQUIRE(invalid.ok());
  CHECK(invalid->Text(0) == "?");
}

TEST_CASE("NpzArchive: versions 1 to 3, and shapes as other writers write them", "[import]") {
  const std::string data = BytesOf<double>({1, 2});
  for (const int version : {1, 2, 3}) {
    CAPTURE(version);
    CHECK(NumbersOf(ReadOnly(Npy(NpyDictionary("<f8", {2}), data, version))).size() == 2);
  }
  CHECK_THAT(ErrorMessageOf(ReadOnly(Npy(NpyDictionary("<f8", {2}), data, 4))),
             Contains("byte 6: expected version 1, 2 or 3, found 4"));
  for (const char* const header :
       {"{\"shape\":(2L,),\"descr\":\"<f8\",\"fortran_order\":False}",
        "{ 'descr' : '<f8' , 'fortran_order' : False , 'shape' : (2) }   \n"}) {
    CAPTURE(header);
    CHECK(NumbersOf(ReadOnly(Npy(header, data))).size() == 2);
  }
}

TEST_CASE("NpzArchive: header errors name file, array and byte", "[import]") {
  const auto check = [](const std::string& header, const std::string& expected) {
    CAPTURE(header);
    const std::string message = ErrorOfHeader(header);
    CHECK_THAT(message, Catch::StartsWith("walk.npz: array 'a': byte "));
    CHECK_THAT(message, Contains(expected));
  };
  check("{'descr': '|O', 'fortran_order': False, 'shape': (1,), }",
        "byte 20: an object array (a pickle) is not read");
  check("{'descr': [('x', '<f8')], 'fortran_order': False, 'shape': (1,), }",
        "byte 20: the array has a structured type");
  check("{'descr': '<c16', 'fortran_order': False, 'shape': (1,), }", "the type '<c16'");
  check("{'descr': '<f16', 'fortran_order': False, 'shape': (1,), }", "the type '<f16'");
  check("{'descr': '|f8', 'fortran_order': False, 'shape': (1,), }", "the type '|f8'");
  check("{'descr': '<U0', 'fortran_order': False, 'shape': (1,), }", "the type '<U0'");
  check("{'descr': '<f8', 'fortran_order': False, 'shape': (-1,), }",
        "byte 61: expected a size from 0 to 2^64 - 1, found '-1,), }'");
  check("{'descr': '<f8', 'fortran_order': False, 'shape': (99999999999999999999,), }",
        "expected a size");
  check("{'descr': '<f8', 'fortran_order': False, 'shape': (1099511627776, 1099511627776), }",
        "(1099511627776, 1099511627776) does not fit 64 bits");
  check("{'descr': '<f8', 'fortran_order': 0, 'shape': (1,), }", "expected True or False");
  check("{'descr': '<f8', 'fortran_order': False, }", "expected the keys descr");
  check("{'descr': '<f8', 'descr': '<f8', 'shape': (1,), }", "repeated key 'descr'");
  check("{'descr': '<f8', 'size': 3, }", "unexpected or repeated key 'size'");
  check("{'descr': '<f8", "expected a text that ends with its quote");
  check("{'descr': '<f8', 'fortran_order': False, 'shape': (1,", "the header ends, expected");
  check("{'descr': '<f8', 'fortran_order': False, 'shape': (1,)} x", "expected the end");
  check("['descr']", "byte 10: expected '{', found '['");
  check("", "byte 10: the header ends, expected '{'");
  check(
      "{'descr': '<f8', 'fortran_order': False, 'shape': (" +
          [] {
            std::string ones;
            for (int i = 0; i < 33; ++i) ones += "1,";
            return ones;
          }() +
          "), }",
      "at most 32 dimensions");

  CHECK_THAT(ErrorMessageOf(ReadOnly("hello")), Contains("byte 0: expected a NumPy array"));
  CHECK_THAT(ErrorMessageOf(ReadOnly("")), Contains("byte 0: expected a NumPy array"));
  CHECK_THAT(ErrorMessageOf(ReadOnly(std::string("\x93NUMPY\x01\x00", 8))),
             Contains("byte 8: the array ends in its header"));
  CHECK_THAT(ErrorMessageOf(ReadOnly(std::string("\x93NUMPY\x01\x00\xff\x00{", 11))),
             Contains("byte 11: the array ends in its header of 255 bytes"));
  CHECK_THAT(ErrorMessageOf(ReadOnly(std::string("\x93NUMPY\x02\x00\xff\xff\xff\xff{", 13))),
             Contains("expected a header of at most 65524 bytes, found 4294967295"));
}

TEST_CASE("NpzArchive: the data must have the size of the shape", "[import]") {
  CHECK_THAT(ErrorMessageOf(ReadOnly(Float64Npy({3}, {1, 2}))),
             Contains("expected 24 bytes of data for the shape (3), found 16"));
  CHECK_THAT(ErrorMessageOf(ReadOnly(Float64Npy({3}, {1, 2, 3, 4}))), Contains("found more"));
  CHECK_THAT(ErrorMessageOf(ReadOnly(Float64Npy({std::size_t{1} << 40}, {1}))),
             Contains("its shape (1099511627776) needs 8796093022208 bytes, above the limit"));
  CHECK(NumbersOf(ReadOnly(Float64Npy({std::size_t{1} << 40, 0}, {}))).empty());
}

TEST_CASE("NpzArchive: the limit counts bytes as they are decompressed", "[import]") {
  const std::string zeros(100 * kMegabyte, '\0');
  const std::string bytes = Zip({{.name = "a.npy",
                                  .content = Npy(NpyDictionary("<f8", {zeros.size() / 8}), zeros),
                                  .deflated = true}});
  CHECK(bytes.size() < 200'000);
  auto archive = NpzArchive::Open({.name = "bomb.npz", .bytes = bytes}, 10 * kMegabyte);
  REQUIRE(archive.ok());
  CHECK_THAT(ErrorMessageOf(archive->Read("a")), Contains("above the limit of 10000000"));

  // The shape promises little, and the directory the truth or nothing.
  const std::string lying = Npy(NpyDictionary("<f8", {1}), zeros.substr(0, 20 * kMegabyte));
  for (const std::size_t stated : {std::size_t{80}, lying.size()}) {
    const std::string small = Zip({{.name = "a.npy",
                                    .content = lying,
                                    .deflated = true,
                                    .stated_size = static_cast<std::uint32_t>(stated)}});
    auto opened = NpzArchive::Open({.name = "bomb.npz", .bytes = small}, 10 * kMegabyte);
    REQUIRE(opened.ok());
    CHECK_THAT(ErrorMessageOf(opened->Read("a")), Contains("expected 8 bytes of data"));
  }
}

TEST_CASE("NpzArchive: the limit is for all arrays together", "[import]") {
  const std::string array = Float64Npy({1000}, std::vector<double>(1000, 1.5));
  const std::string bytes = Zip(
      {{.name = "a.npy", .content = array}, {.name = "b.npy", .content = array, .deflated = true}});
  auto archive = NpzArchive::Open({.name = "walk.npz", .bytes = bytes}, 20'000);
  REQUIRE(archive.ok());
  CHECK(archive->Read("a").ok());
  CHECK(archive->Read("b").ok());
  CHECK_THAT(ErrorMessageOf(archive->Read("a")), Contains("more than 20000 decompressed bytes"));
}

TEST_CASE("NpzArchive: members that are not read", "[import]") {
  const std::string array = Float64Npy({1}, {1});
  const auto open_error = [](const std::string& bytes) {
    return ErrorMessageOf(NpzArchive::Open({.name = "walk.npz", .bytes = bytes}, kMegabyte));
  };
  CHECK_THAT(open_error(Zip({{.name = "a.npy", .content = array, .flags = 1}})),
             Contains("walk.npz: member 'a.npy' is encrypted"));
  CHECK_THAT(
      open_error(Zip({{.name = "a.npy", .content = array}, {.name = "a.npy", .content = array}})),
      Contains("two members have the same name"));
  CHECK_THAT(open_error("no archive"),
             Contains("walk.npz: byte 0: expected a NumPy archive (zip), found 'no a'"));
  const std::string whole = Zip({{.name = "a.npy", .content = array}});
  CHECK_THAT(
      open_error(whole.substr(0, 100)),
      Contains("walk.npz: expected the directory of the archive before byte 100, its end: it "
               "is truncated"));
  CHECK_THAT(open_error(""), Contains("expected a NumPy archive (zip), found no byte"));
  std::vector<ZipMember> many;
  for (int i = 0; i < 1001; ++i) many.push_back({.name = fmt::format("{}.npy", i), .content = ""});
  CHECK_THAT(open_error(Zip(many)), Contains("at most 1000 members, found 1001"));

  const std::string other = Zip({{.name = "a.npy", .content = array, .method = 12}});
  auto archive = NpzArchive::Open({.name = "walk.npz", .bytes = other}, kMegabyte);
  REQUIRE(archive.ok());
  CHECK_THAT(ErrorMessageOf(archive->Read("a")),
             Contains("array 'a': expected the compression deflate or none, found method 12"));

  const std::string corrupt = Zip({{.name = "a.npy", .content = array, .stated_crc = 1}});
  archive = NpzArchive::Open({.name = "walk.npz", .bytes = corrupt}, kMegabyte);
  REQUIRE(archive.ok());
  CHECK_THAT(ErrorMessageOf(archive->Read("a")), Contains("cannot be decompressed: CRC error"));
  CHECK_THAT(ErrorMessageOf(archive->Read("b")), Contains("there is no array 'b'"));
}

TEST_CASE("NpzArchive: overlapping members are rejected or count", "[import]") {
  const std::string array = Float64Npy({10'000}, std::vector<double>(10'000));
  std::vector<ZipMember> members = {{.name = "a.npy", .content = array, .deflated = true}};
  for (int i = 0; i < 100; ++i) {
    members.push_back(
        {.name = fmt::format("{}.npy", i), .content = array, .deflated = true, .same_data_as = 0});
  }
  const std::string bytes = Zip(members);
  auto archive = NpzArchive::Open({.name = "bomb.npz", .bytes = bytes}, kMegabyte);
  std::size_t decompressed = 0;
  for (std::size_t i = 0; archive.ok() && i < members.size(); ++i) {
    if (archive->Read(archive->names()[i]).ok()) decompressed += array.size();
  }
  CHECK(decompressed <= kMegabyte);
}

TEST_CASE("NpzArchive: an archive in an archive is not opened", "[import]") {
  const std::string inner = Zip({{.name = "poses.npy", .content = Float64Npy({1}, {1})}});
  const std::string bytes =
      Zip({{.name = "inner.npz", .content = inner}, {.name = "a.npy", .content = inner}});
  auto archive = NpzArchive::Open({.name = "walk.npz", .bytes = bytes}, kMegabyte);
  REQUIRE(archive.ok());
  CHECK(archive->names() == std::vector<std::string>{"a"});
  CHECK_THAT(ErrorMessageOf(archive->Read("a")), Contains("byte 0: expected a NumPy array"));
}

TEST_CASE("NpzArchive: truncated and corrupt archives are rejected or read", "[import]") {
  const std::string bytes =
      Zip({{.name = "a.npy", .content = Float64Npy({40, 3}, std::vector<double>(120, 0.25))},
           {.name = "b.npy",
            .content = Float64Npy({100}, std::vector<double>(100, 7)),
            .deflated = true},
           {.name = "gender.npy", .content = TextNpy("male")}});
  for (std::size_t size = 0; size < bytes.size(); size += 50) {
    CAPTURE(size);
    const std::string truncated = bytes.substr(0, size);
    const auto archive = NpzArchive::Open({.name = "walk.npz", .bytes = truncated}, kMegabyte);
    CHECK_FALSE(archive.ok());
  }
  std::mt19937 random(3);
  for (int i = 0; i < 3000; ++i) {
    std::string corrupt = bytes;
    for (int k = 0; k < 1 + i % 4; ++k) {
      corrupt[random() % corrupt.size()] = static_cast<char>(random());
    }
    ReadEverything(corrupt);  // under the sanitizers
  }
}

}  // namespace motiondb::tests::npz_archive_test
