#include "server/translate/ingest_stream.h"

#include <catch2/catch.hpp>
#include <limits>

#include "core/motion/error.h"
#include "motiondb/v1/clip.pb.h"

namespace motiondb::server::ingest_stream_test {
namespace {

v1::IngestClipRequest Header(const std::string& file_name) {
  v1::IngestClipRequest message;
  message.mutable_header()->set_parent("databases/db");
  message.mutable_header()->set_file_name(file_name);
  return message;
}

v1::IngestClipRequest Block(const std::string& bytes) {
  v1::IngestClipRequest message;
  message.set_file_block(bytes);
  return message;
}

std::string Error(const absl::Status& status) { return std::string(status.message()); }

TEST_CASE("IngestStream: joins blocks to the file", "[server][translate]") {
  IngestStream stream(100);
  REQUIRE(stream.Take(Header("folder/walk.BVH")).ok());
  CHECK(stream.database() == "db");
  REQUIRE(stream.Take(Block("abc")).ok());
  REQUIRE(stream.Take(Block("def")).ok());
  const auto finished = stream.Finish();
  REQUIRE(finished.ok());
  const storage::NewClip& clip = finished->clip;
  CHECK(clip.record.file_name == "walk.BVH");
  CHECK(clip.record.format == core::FileFormat::kBvh);
  CHECK(clip.file_bytes == "abcdef");
}

TEST_CASE("IngestStream: the header comes first and once", "[server][translate]") {
  IngestStream stream(100);
  CHECK(Error(stream.Take(Block("abc"))).starts_with("header: "));
  REQUIRE(stream.Take(Header("walk.bvh")).ok());
  CHECK(Error(stream.Take(Header("walk.bvh"))).starts_with("header: "));
  CHECK(!stream.Take(v1::IngestClipRequest()).ok());
  CHECK(!IngestStream(100).Finish().ok());
  CHECK(Error(stream.Finish().status()).find("empty") != std::string::npos);
}

TEST_CASE("IngestStream: sizes are limited", "[server][translate]") {
  IngestStream stream((2 << 20) + 5);
  REQUIRE(stream.Take(Header("walk.bvh")).ok());
  const std::string block(1 << 20, 'x');
  CHECK(absl::IsInvalidArgument(stream.Take(Block(block + "x"))));
  CHECK(stream.Take(Block(block)).ok());
  CHECK(stream.Take(Block(block)).ok());
  CHECK(stream.Take(Block("12345")).ok());
  CHECK(absl::IsResourceExhausted(stream.Take(Block("6"))));
}

TEST_CASE("IngestStream: the error names the invalid field of the header", "[server][translate]") {
  const auto expect = [](const std::string& field, const auto& change) {
    v1::IngestClipRequest message = Header("walk.bvh");
    change(*message.mutable_header());
    IngestStream stream(100);
    const absl::Status status = stream.Take(message);
    INFO(field << ": " << Error(status));
    CHECK(absl::IsInvalidArgument(status));
    const auto named = status.GetPayload(core::kFieldUrl);
    REQUIRE(named.has_value());
    CHECK(std::string(*named) == "header." + field);
  };
  expect("parent", [](auto& header) { header.set_parent("db"); });
  expect("file_name", [](auto& header) { header.set_file_name(""); });
  expect("file_name", [](auto& header) { header.set_file_name("folder/"); });
  expect("file_name", [](auto& header) { header.set_file_name("walk.txt"); });
  expect("file_name", [](auto& header) { header.set_file_name("a\nb.bvh"); });
  for (const char* name : {".walk.bvh", "-rf.bvh", "a\xC2\x9B.bvh", "a\xE2\x80\xAE.bvh"}) {
    expect("file_name", [name](auto& header) { header.set_file_name(name); });
    expect("label",
           [name](auto& header) { header.set_label(std::string(name).substr(1) + "\u2028"); });
    expect("subject", [name](auto& header) { header.set_subject(std::string(name) + "\u061c"); });
  }
  expect("format", [](auto& header) { header.set_format(static_cast<v1::FileFormat>(99)); });
  expect("skeleton_file_name", [](auto& header) { header.set_skeleton_file_name("a.asf"); });
  expect("skeleton_file_name", [](auto& header) { header.set_file_name("walk.amc"); });
  expect("label", [](auto& header) { header.set_label(std::string(300, 'x')); });
  expect("subject", [](auto& header) { header.set_subject("a\tb"); });
  expect("clip_id", [](auto& header) { header.set_clip_id("a/b"); });
  const double nan = std::numeric_limits<double>::quiet_NaN();
  expect("conventions.metres_per_unit",
         [&](auto& header) { header.mutable_conventions()->set_metres_per_unit(nan); });
  expect("conventions.frame_rate_hz",
         [&](auto& header) { header.mutable_conventions()->set_frame_rate_hz(-1); });
  expect("conventions.leg_length_m",
         [&](auto& header) { header.mutable_conventions()->set_leg_length_m(1 / 0.0); });
  expect("conventions.up_axis", [&](auto& header) {
    header.mutable_conventions()->set_up_axis(static_cast<v1::UpAxis>(9));
  });
}

TEST_CASE("IngestStream: an AMC file comes with its skeleton", "[server][translate]") {
  v1::IngestClipRequest header = Header("02_01.amc");
  header.mutable_header()->set_skeleton_file_name("02.asf");
  IngestStream stream(100);
  REQUIRE(stream.Take(header).ok());
  REQUIRE(stream.Take(Block("amc")).ok());
  v1::IngestClipRequest skeleton;
  skeleton.set_skeleton_block("asf");
  IngestStream without = stream;
  CHECK(!without.Finish().ok());
  REQUIRE(stream.Take(skeleton).ok());
  CHECK(stream.Finish()->clip.skeleton_bytes == "asf");

  IngestStream bvh(100);
  REQUIRE(bvh.Take(Header("walk.bvh")).ok());
  CHECK(!bvh.Take(skeleton).ok());
}

}  // namespace
}  // namespace motiondb::server::ingest_stream_test
