#include <catch2/catch.hpp>

#include "client/cli/model_dump.h"
#include "tests/client/temporary_folder.h"
#include "tests/support/real_data.h"

namespace motiondb::tests::npy_writer_test {
namespace {

using client::NpyHeader;
using client::NpyType;
using client::NpyWriter;

TEST_CASE("NpyWriter: the header is format 1.0 and ends at a multiple of 64", "[client][cli]") {
  for (const std::vector<int64_t>& shape :
       std::vector<std::vector<int64_t>>{{0}, {7}, {12, 204}, {1234567890, 3}}) {
    const std::string header = NpyHeader(NpyType::kFloat32, shape);
    CHECK(header.substr(0, 8) == std::string("\x93NUMPY\x01\x00", 8));
    CHECK(header.size() % 64 == 0);
    CHECK(header.back() == '\n');
    const size_t length =
        static_cast<unsigned char>(header[8]) + 256 * static_cast<unsigned char>(header[9]);
    CHECK(length == header.size() - 10);
  }
  CHECK_THAT(NpyHeader(NpyType::kInt32, {7}),
             Catch::Contains("{'descr': '<i4', 'fortran_order': False, 'shape': (7,), }"));
  CHECK_THAT(NpyHeader(NpyType::kFloat32, {12, 204}),
             Catch::Contains("{'descr': '<f4', 'fortran_order': False, 'shape': (12, 204), }"));
}

TEST_CASE("NpyWriter: integers are little-endian after the header", "[client][cli]") {
  const TemporaryFolder folder;
  NpyWriter writer(folder / "a.npy", NpyType::kInt32, {2});
  writer.Append(-2);
  writer.Append(0x01020304);
  CHECK(!std::filesystem::exists(folder / "a.npy"));
  REQUIRE(writer.Finish().ok());
  CHECK(ReadFile(folder / "a.npy") ==
        NpyHeader(NpyType::kInt32, {2}) + std::string("\xFE\xFF\xFF\xFF\x04\x03\x02\x01", 8));
}

TEST_CASE("NpyWriter: a wrong number of elements leaves no file", "[client][cli]") {
  const TemporaryFolder folder;
  for (const int count : {1, 3}) {
    NpyWriter writer(folder / "a.npy", NpyType::kInt32, {2});
    for (int i = 0; i < count; ++i) writer.Append(i);
    CHECK(writer.Finish().code() == absl::StatusCode::kDataLoss);
  }
  CHECK(std::filesystem::is_empty(folder.path()));
}

TEST_CASE("NpyWriter: a missing folder is an error", "[client][cli]") {
  const TemporaryFolder folder;
  NpyWriter writer(folder / "none/a.npy", NpyType::kInt32, {0});
  const absl::Status status = writer.Finish();
  CHECK(!status.ok());
  CHECK_THAT(std::string(status.message()), Catch::Contains("a.npy"));
}

}  // namespace
}  // namespace motiondb::tests::npy_writer_test
