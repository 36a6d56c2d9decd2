// Files that motiondb-import reads for the server, and export in other formats.
#include <array>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <string>
#include <variant>

#include "core/export/motion_writer.h"
#include "core/format/motion_file.h"
#include "motiondb/v1/clip.grpc.pb.h"
#include "motiondb/v1/error.pb.h"
#include "motiondb/v1/query.grpc.pb.h"
#include "tests/support/compressed.h"
#include "tests/support/test_server.h"

namespace motiondb::tests::import_formats_test {
namespace {

using core::FileFormat;
using grpc::StatusCode;

v1::IngestClipHeader HeaderOf(const std::string& file_name) {
  v1::IngestClipHeader header;
  header.set_parent("databases/db");
  header.set_file_name(file_name);
  header.set_label("walk");
  return header;
}

core::Motion ReadWalk(const StickFigure& figure) {
  auto read = core::ReadMotionFile(FileFormat::kBvh, {"walk.bvh", WriteBvh(figure)});
  REQUIRE(read.ok());
  return std::move(read->motion);
}

std::string Written(FileFormat format, const StickFigure& figure) {
  auto written = core::WriteMotion(format, ReadWalk(figure));
  INFO(written.status());
  REQUIRE(written.ok());
  return std::move(written->bytes);
}

struct ExportedFile {
  grpc::Status status;
  v1::ExportClipHeader header;
  std::string bytes;
};

ExportedFile ExportAs(TestServer& server, const std::string& clip, v1::FileFormat format) {
  const auto stub = server.NewStub<v1::ClipService>();
  grpc::ClientContext context;
  v1::ExportClipRequest request;
  request.set_name("databases/db/clips/" + clip);
  request.set_format(format);
  const auto reader = stub->ExportClip(&context, request);
  ExportedFile exported;
  v1::ExportClipResponse message;
  while (reader->Read(&message)) {
    if (message.has_header()) exported.header = message.header();
    exported.bytes += message.file_block();
  }
  exported.status = reader->Finish();
  return exported;
}

// The stored markers of a clip, read from its export as TRC.
core::MarkerMotion StoredMarkers(TestServer& server, const std::string& clip) {
  const ExportedFile exported = ExportAs(server, clip, v1::FILE_FORMAT_TRC);
  INFO(exported.status.error_message());
  REQUIRE(exported.status.ok());
  CHECK(exported.header.file_name() == clip + ".trc");
  const auto read = core::ReadMotionFile(FileFormat::kTrc, {"x.trc", exported.bytes}, {},
                                         {.up_axis = core::UpAxis::kY});
  INFO(read.status());
  REQUIRE(read.ok());
  return std::get<core::MarkerMotion>(read->motion);
}

std::string ReasonOf(const grpc::Status& status, std::string* takes = nullptr) {
  v1::Status details;
  REQUIRE(details.ParseFromString(status.error_details()));
  for (const auto& detail : details.details()) {
    v1::ErrorInfo info;
    if (detail.type_url().find("ErrorInfo") == std::string::npos) continue;
    REQUIRE(info.ParseFromString(detail.value()));
    if (takes != nullptr) *takes = info.metadata().at("takes");
    return info.reason();
  }
  return "";
}

// A scene with one moving child of a root and two animations.
std::string TwoTakes() {
  // Times 0 and 1 s; rotations and positions, as float32 in base64, are made below.
  const std::array<float, 2> times = {0, 1};
  const std::array<float, 6> positions = {0, 1, 0, 0, 1, 1};
  std::string bytes(reinterpret_cast<const char*>(times.data()), sizeof times);
  bytes.append(reinterpret_cast<const char*>(positions.data()), sizeof positions);
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string base64;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned value = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      value = value << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    }
    for (int shift = 18; shift >= 0; shift -= 6) base64 += kDigits[value >> shift & 63];
  }
  const std::size_t padding = (3 - bytes.size() % 3) % 3;
  base64.replace(base64.size() - padding, padding, padding, '=');
  const auto animation = [](const std::string& name) {
    return R"({"name":")" + name +
           R"(","samplers":[{"input":0,"output":1}],"channels":[{"sampler":0,)"
           R"("target":{"node":0,"path":"translation"}}]})";
  };
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],)"
         R"("nodes":[{"name":"hips","children":[1]},{"name":"head","translation":[0,1,0]}],)"
         R"("buffers":[{"byteLength":)" +
         std::to_string(bytes.size()) + R"(,"uri":"data:application/octet-stream;base64,)" +
         base64 +
         R"("}],"bufferViews":[{"buffer":0,"byteLength":8},)"
         R"({"buffer":0,"byteOffset":8,"byteLength":24}],"accessors":[)"
         R"({"bufferView":0,"componentType":5126,"count":2,"type":"SCALAR","min":[0],"max":[1]},)"
         R"({"bufferView":1,"componentType":5126,"count":2,"type":"VEC3"}],"animations":[)" +
         animation("walk") + "," + animation("run") + "]}";
}

TEST_CASE("IngestClip: imported formats give the clip of the original", "[server][import]") {
  TestServer server;
  server.CreateDatabase("db");
  const StickFigure walk{.frame_count = 90};
  server.IngestFigure("db", "original", "walk", walk);
  const core::MarkerMotion original = StoredMarkers(server, "original");
  struct Case {
    std::string file_name;
    std::string bytes;
    v1::FileFormat format;
  };
  const std::vector<Case> cases = {
      {"scene.glb", Written(FileFormat::kGltf, walk), v1::FILE_FORMAT_GLTF},
      {"array.npz", Written(FileFormat::kNpz, walk), v1::FILE_FORMAT_NPZ},
      {"packed.bvh.gz", Compressed(WriteBvh(walk)), v1::FILE_FORMAT_BVH},
  };
  for (const Case& one : cases) {
    CAPTURE(one.file_name);
    v1::IngestClipResponse response;
    const grpc::Status status = server.Ingest(HeaderOf(one.file_name), one.bytes, &response);
    INFO(status.error_message());
    REQUIRE(status.ok());
    CHECK(response.clip().format() == one.format);
    CHECK(response.clip().file_name() == one.file_name);
    const std::string id = one.file_name.substr(0, one.file_name.find('.'));
    CHECK(response.clip().name() == "databases/db/clips/" + id);
    const core::MarkerMotion stored = StoredMarkers(server, id);
    REQUIRE(stored.names == original.names);
    REQUIRE(stored.positions_m.rows() == original.positions_m.rows());
    CHECK((stored.positions_m - original.positions_m).cwiseAbs().maxCoeff() < 1e-3F);
    // The original bytes are kept.
    CHECK(ExportAs(server, id, v1::FILE_FORMAT_UNSPECIFIED).bytes == one.bytes);
  }
}

TEST_CASE("Recognize: an imported observation is answered like the original", "[server][import]") {
  TestServer server;
  server.CreateTrained("db");
  const auto stub = server.NewStub<v1::QueryService>();
  const StickFigure walk{.frame_count = 48, .phase = 0.3};
  v1::RecognizeRequest request;
  request.set_database("databases/db");
  v1::FileObservation& file = *request.mutable_observation()->mutable_file();
  file.set_file_name("walk.bvh");
  file.set_data(WriteBvh(walk));
  const auto original = Ask(*stub, &v1::QueryService::Stub::Recognize, request);
  REQUIRE(original.status.ok());
  file.set_file_name("walk.glb");
  file.set_data(Written(FileFormat::kGltf, walk));
  const auto imported = Ask(*stub, &v1::QueryService::Stub::Recognize, request);
  INFO(imported.status.error_message());
  REQUIRE(imported.status.ok());
  REQUIRE(imported.response.windows_size() == original.response.windows_size());
  CHECK(imported.response.windows(0).labels(0).label() ==
        original.response.windows(0).labels(0).label());
}

TEST_CASE("IngestClip: a file with several takes needs a choice", "[server][import]") {
  TestServer server;
  server.CreateDatabase("db");
  const auto refused = server.Ingest(HeaderOf("two.gltf"), TwoTakes());
  CHECK(refused.error_code() == StatusCode::INVALID_ARGUMENT);
  INFO(refused.error_message());
  std::string takes;
  CHECK(ReasonOf(refused, &takes) == "TAKE_REQUIRED");
  CHECK(takes == R"(["walk","run"])");

  v1::IngestClipHeader header = HeaderOf("two.gltf");
  header.mutable_conventions()->set_take("jump");
  CHECK(ReasonOf(server.Ingest(header, TwoTakes())) == "TAKE_NOT_FOUND");
  for (const std::string take : {"run", "1"}) {
    header.mutable_conventions()->set_take(take);
    // Two moving nodes are no body: the error is that of the mapping, so the take was read.
    CHECK_THAT(server.Ingest(header, TwoTakes()).error_message(), Catch::Contains("hips"));
  }
  header.set_file_name("walk.bvh");
  const auto no_takes = server.Ingest(header, WriteBvh({}));
  CHECK(no_takes.error_code() == StatusCode::INVALID_ARGUMENT);
  CHECK_THAT(no_takes.error_message(), Catch::Contains("bvh files have no takes"));
}

TEST_CASE("IngestClip: hostile files are refused and the server goes on", "[server][import]") {
  TestServer server;
  server.CreateDatabase("db");
  const std::string glb = Written(FileFormat::kGltf, {});
  std::string endless_nodes = TwoTakes();
  const auto at = endless_nodes.find(R"("children":[1])");
  endless_nodes.replace(at, 14, R"("children":[0])");
  const std::vector<std::pair<std::string, std::string>> files = {
      {"cut.glb", glb.substr(0, glb.size() / 2)},
      {"noise.fbx", "Kaydara FBX Binary  " + std::string(1000, '\xff')},
      {"empty.dae", "<COLLADA/>"},
      {"cycle.gltf", endless_nodes},
      {"array.npz", std::string("PK\x03\x04") + std::string(100, 'x')},
      {"bomb.bvh.gz", Compressed(std::string(std::size_t{300} << 20, ' '))},
      {"cut.bvh.gz", Compressed(WriteBvh({})).substr(0, 100)},
  };
  for (const auto& [name, bytes] : files) {
    CAPTURE(name);
    const grpc::Status refused = server.Ingest(HeaderOf(name), bytes);
    INFO(refused.error_message());
    CHECK((refused.error_code() == StatusCode::INVALID_ARGUMENT ||
           refused.error_code() == StatusCode::RESOURCE_EXHAUSTED));
    CHECK_THAT(refused.error_message(), Catch::Contains(name));
  }
  CHECK(server.Describe("db").stored_clip_count() == 0);
  CHECK(server.Ingest(HeaderOf("walk.glb"), glb).ok());
}

TEST_CASE("IngestClip: without motiondb-import only its formats fail", "[server][import]") {
  TestServer server;
  server.CreateDatabase("db");
  const std::string program = std::getenv("MOTIONDB_IMPORT");
  setenv("MOTIONDB_IMPORT", "/nonexistent/motiondb-import", 1);
  const grpc::Status refused = server.Ingest(HeaderOf("walk.glb"), Written(FileFormat::kGltf, {}));
  setenv("MOTIONDB_IMPORT", "/bin/cat", 1);  // echoes the request
  const grpc::Status wrong = server.Ingest(HeaderOf("walk.glb"), Written(FileFormat::kGltf, {}));
  setenv("MOTIONDB_IMPORT", program.c_str(), 1);
  CHECK(refused.error_code() == StatusCode::FAILED_PRECONDITION);
  CHECK(ReasonOf(refused) == "IMPORT_NOT_INSTALLED");
  CHECK_THAT(refused.error_message(), !Catch::Contains("/nonexistent"));
  CHECK(wrong.error_code() == StatusCode::INTERNAL);  // cat refuses the arguments
  CHECK(server.Ingest(HeaderOf("walk.bvh"), WriteBvh({})).ok());
}

TEST_CASE("ExportClip: every written format holds the stored motion", "[server][import]") {
  TestServer server;
  server.CreateDatabase("db");
  server.IngestFigure("db", "walk", "walk", {.frame_count = 200});
  const core::MarkerMotion stored = StoredMarkers(server, "walk");
  for (const auto format : {v1::FILE_FORMAT_BVH, v1::FILE_FORMAT_TRC, v1::FILE_FORMAT_C3D,
                            v1::FILE_FORMAT_CSV, v1::FILE_FORMAT_NPZ, v1::FILE_FORMAT_GLTF}) {
    CAPTURE(v1::FileFormat_Name(format));
    const ExportedFile exported = ExportAs(server, "walk", format);
    INFO(exported.status.error_message());
    REQUIRE(exported.status.ok());
    v1::IngestClipHeader header = HeaderOf(exported.header.file_name());
    header.set_clip_id("back-" + std::to_string(format));
    if (format == v1::FILE_FORMAT_TRC) header.mutable_conventions()->set_up_axis(v1::UP_AXIS_Y);
    v1::IngestClipResponse back;
    const grpc::Status status = server.Ingest(header, exported.bytes, &back);
    INFO(status.error_message());
    REQUIRE(status.ok());
    const core::MarkerMotion again = StoredMarkers(server, header.clip_id());
    REQUIRE(again.names == stored.names);
    REQUIRE(again.positions_m.rows() == stored.positions_m.rows());
    CHECK((again.positions_m - stored.positions_m).cwiseAbs().maxCoeff() < 1e-3F);
  }
  CHECK(ExportAs(server, "walk", v1::FILE_FORMAT_FBX).status.error_code() ==
        StatusCode::INVALID_ARGUMENT);
  CHECK(ExportAs(server, "none", v1::FILE_FORMAT_BVH).status.error_code() == StatusCode::NOT_FOUND);
}

}  // namespace
}  // namespace motiondb::tests::import_formats_test
