// Seeds of the queries: requests with a walk as a file, as markers and as joint angles.
#include <catch2/catch.hpp>
#include <vector>

#include "absl/strings/escaping.h"
#include "core/format/readers.h"
#include "core/motion/marker_set.h"
#include "motiondb/v1/clip.pb.h"
#include "motiondb/v1/observe.pb.h"
#include "motiondb/v1/plan.pb.h"
#include "motiondb/v1/query.pb.h"
#include "server/translate/message_fields.h"
#include "tests/fuzz/seeds/seed_file.h"
#include "tests/fuzz/seeds/small_files.h"
#include "tests/fuzz/server/message_stream.h"
#include "tests/support/stick_figure.h"

namespace motiondb::tests {
namespace {

constexpr int kFrames = 12;

const core::JointMotion& Walk() {
  static const core::JointMotion kWalk = [] {
    auto read = core::ReadBvh({"walk.bvh", WriteBvh({.frame_count = kFrames})}, {});
    REQUIRE(read.ok());
    return std::get<core::JointMotion>(read->motion);
  }();
  return kWalk;
}

core::MarkerMotion WalkMarkers() {
  const auto scheme = core::SourceScheme(Walk());
  REQUIRE(scheme.ok());
  auto markers = core::ApplyScheme(*scheme, Walk());
  REQUIRE(markers.ok());
  return *std::move(markers);
}

std::string Packed(const core::FrameMatrix& matrix) {
  std::string bytes;
  server::AppendPacked(matrix.data(), static_cast<std::size_t>(matrix.size()), bytes);
  return bytes;
}

struct NamedObservation {
  std::string name;
  v1::Observation observation;
};

std::vector<NamedObservation> Observations() {
  v1::Observation file;
  file.mutable_file()->set_file_name("small.bvh");
  file.mutable_file()->set_data(std::string(kSmallBvh));
  v1::Observation whole_file;
  whole_file.mutable_file()->set_file_name("walk.bvh");
  whole_file.mutable_file()->set_data(WriteBvh({.frame_count = 4}));

  const core::MarkerMotion motion = WalkMarkers();
  v1::Observation markers;
  markers.mutable_markers()->set_frame_rate_hz(60);
  markers.mutable_markers()->set_frame_count(kFrames);
  markers.mutable_markers()->set_positions(Packed(motion.positions_m));

  v1::Observation joints;
  joints.mutable_joints()->set_skeleton("databases/db/skeletons/walk");
  joints.mutable_joints()->set_frame_rate_hz(60);
  joints.mutable_joints()->set_frame_count(kFrames);
  joints.mutable_joints()->set_angles(Packed(Walk().angles.cast<float>()));
  return {{"file", file}, {"whole_file", whole_file}, {"markers", markers}, {"joints", joints}};
}

TEST_CASE("Seeds: Recognize, Estimate, Predict and Represent", "[seeds]") {
  for (const auto& [name, observation] : Observations()) {
    v1::RecognizeRequest recognize;
    recognize.set_database("databases/db");
    *recognize.mutable_observation() = observation;
    WriteSeed("recognize_fuzz", name, recognize.SerializeAsString());
    recognize.set_method(v1::METHOD_PAPER);
    recognize.set_layer(2);
    recognize.set_window_seconds(0.1);
    recognize.set_hop_seconds(0.05);
    recognize.set_generation(v1::GENERATION_TOP_PATHS);
    recognize.set_path_count(3);
    WriteSeed("recognize_fuzz", name + "_paper", recognize.SerializeAsString());

    v1::EstimateRequest estimate;
    estimate.set_database("databases/db");
    *estimate.mutable_observation() = observation;
    estimate.set_path_count(2);
    estimate.set_max_candidates(4);
    estimate.set_fill_every_frame(true);
    WriteSeed("estimate_fuzz", name, estimate.SerializeAsString());

    v1::PredictRequest predict;
    predict.set_database("databases/db");
    *predict.mutable_observation() = observation;
    WriteSeed("predict_fuzz", name, predict.SerializeAsString());
    predict.set_method(v1::METHOD_PAPER);
    predict.set_at_seconds(0.05);
    predict.set_history_seconds(0.1);
    predict.add_horizon_seconds(0.1);
    WriteSeed("predict_fuzz", name + "_paper", predict.SerializeAsString());

    v1::RepresentRequest represent;
    represent.set_database("databases/db");
    *represent.mutable_observation() = observation;
    WriteSeed("represent_fuzz", name, represent.SerializeAsString());
  }
}

TEST_CASE("Seeds: Plan", "[seeds]") {
  v1::PlanRequest plan;
  plan.set_database("databases/db");
  plan.mutable_goal()->set_x_m(0.3);
  plan.set_max_duration_seconds(2);
  WriteSeed("plan_fuzz", "standing", plan.SerializeAsString());
  plan.mutable_clip_start()->set_clip("databases/db/clips/walk");
  plan.mutable_clip_start()->set_seconds(0.2);
  v1::Disc* const disc = plan.mutable_obstacles()->add_discs();
  disc->mutable_centre()->set_x_m(0.2);
  disc->set_radius_m(0.05);
  v1::Polygon* const polygon = plan.mutable_obstacles()->add_polygons();
  for (const double x : {1.0, 2.0, 1.5}) {
    v1::FloorPoint* const corner = polygon->add_corners();
    corner->set_x_m(x);
    corner->set_y_m(x * x);
  }
  plan.set_alternative_count(1);
  plan.set_frame_rate_hz(30);
  plan.add_labels("walk");
  WriteSeed("plan_fuzz", "from_clip", plan.SerializeAsString());
  plan.set_method(v1::PLAN_METHOD_RANDOM_SAMPLING);
  plan.set_skeleton("databases/db/skeletons/walk");
  plan.set_include_files(true);
  WriteSeed("plan_fuzz", "sampled", plan.SerializeAsString());
  *plan.mutable_observation_start() = Observations()[2].observation;
  WriteSeed("plan_fuzz", "observed", plan.SerializeAsString());
  plan.mutable_robot()->set_file_name("arm.urdf");
  plan.mutable_robot()->set_urdf(std::string(kSmallUrdf));
  WriteSeed("plan_fuzz", "robot", plan.SerializeAsString());
}

TEST_CASE("Seeds: Observe", "[seeds]") {
  v1::ObserveRequest start;
  start.mutable_start()->set_database("databases/db");
  start.mutable_start()->set_frame_rate_hz(60);
  start.mutable_start()->add_horizon_seconds(0.2);
  std::string stream = LengthPrefixed(start.SerializeAsString());
  const core::MarkerMotion motion = WalkMarkers();
  for (int first = 0; first < kFrames; first += kFrames / 3) {
    v1::ObserveRequest frames;
    frames.mutable_frames()->set_first_frame(first);
    frames.mutable_frames()->set_frame_count(kFrames / 3);
    frames.mutable_frames()->set_positions(
        Packed(motion.positions_m.middleRows(first, kFrames / 3)));
    stream += LengthPrefixed(frames.SerializeAsString());
  }
  WriteSeed("observe_fuzz", "walk", stream);
}

TEST_CASE("Seeds: IngestClip", "[seeds]") {
  v1::IngestClipRequest message;
  message.mutable_header()->set_parent("databases/db");
  message.mutable_header()->set_file_name("small.bvh");
  std::string stream = LengthPrefixed(message.SerializeAsString());
  message.set_file_block(std::string(kSmallBvh.substr(0, 300)));
  stream += LengthPrefixed(message.SerializeAsString());
  message.set_file_block(std::string(kSmallBvh.substr(300)));
  stream += LengthPrefixed(message.SerializeAsString());
  WriteSeed("ingest_stream_fuzz", "bvh", stream);

  v1::IngestClipHeader* const header = message.mutable_header();
  header->set_parent("databases/db");
  header->set_file_name("small.amc");
  header->set_skeleton_file_name("small.asf");
  header->mutable_conventions()->set_frame_rate_hz(120);
  stream = LengthPrefixed(message.SerializeAsString());
  message.set_skeleton_block(std::string(kSmallAsf));
  stream += LengthPrefixed(message.SerializeAsString());
  message.set_file_block(std::string(kSmallAmc));
  stream += LengthPrefixed(message.SerializeAsString());
  WriteSeed("ingest_stream_fuzz", "amc", stream);
}

TEST_CASE("Seeds: changes of a backup", "[seeds]") {
  using namespace std::string_literals;
  WriteSeed("restore_fuzz", "as_it_is", "\1"s);
  WriteSeed("restore_fuzz", "without_its_checksum", "\0\1\7\0\0\0\2ab"s);
  WriteSeed("restore_fuzz", "byte", "\1\1\x88\x13\0\0\1a"s);
  WriteSeed("restore_fuzz", "value", "\1\2\3\4\0\1\5"s);
  WriteSeed("restore_fuzz", "text", "\1\2\4\1\0\4\3abc"s);
}

TEST_CASE("Seeds: names and tokens", "[seeds]") {
  for (const char* const name :
       {"databases/db", "databases/db/clips/a", "databases/db/skeletons/s", "operations/o",
        "databases/db/models/3", "databases/db/models/current", "3:17"}) {
    std::string file(name);
    for (char& c : file) c = c == '/' ? '_' : c;
    WriteSeed("names_fuzz", file, name);
  }
  WriteSeed("connect_fuzz", "envelope", std::string("\0\0\0\0\0\2{}", 8));
  WriteSeed("connect_fuzz", "json",
            R"(2{"database":"databases/d","atSeconds":0.5,"horizonSeconds":[0.1,"NaN"]})");
  // A token of the list that the target reads; random letters match no list.
  WriteSeed("names_fuzz", "token", absl::WebSafeBase64Escape("databases/db/models\n3:17"));
}

TEST_CASE("Seeds: filters and orders", "[seeds]") {
  constexpr std::string_view kTexts[] = {
      "label = \"walk\" AND NOT subject != 07 OR tags:(left slow)",
      "segment:(label = walk AND track = action AND confidence < 0.8) duration >= 2.5s",
      "fields.n > 3 OR fields.s = \"x*\\*\" OR fields:b OR fields.t = 2026-05-01",
      "clip.label = walk AND start < 2s AND -clip.segment.source = (person OR import)",
      "create_time > \"2026-05-01T12:00:00+02:00\" format:bvh description:'hall 5' title:*",
      "duration desc, fields.n, name",
      "clip.subject, track, start desc"};
  for (std::size_t i = 0; i < std::size(kTexts); ++i) {
    WriteSeed("filter_fuzz", std::to_string(i), kTexts[i]);
  }
}

}  // namespace
}  // namespace motiondb::tests
