#include "tests/storage/samples.h"

#include <cstring>
#include <random>
#include <tuple>
#include <utility>

#include "core/model/model_builder.h"
#include "storage/blob/clip_codec.h"
#include "storage/blob/model_codec.h"
#include "tests/storage/require_ok.h"

namespace motiondb::tests {
namespace {

constexpr int kFrames = 60;

template <typename Matrix>
bool SameBytes(const Matrix& a, const Matrix& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() &&
         std::memcmp(a.data(), b.data(), sizeof(*a.data()) * a.size()) == 0;
}

auto Fields(const storage::ClipRecord& r) {
  return std::tie(r.database, r.id, r.label, r.subject, r.file_name, r.skeleton_file_name, r.format,
                  r.frame_count, r.duration_seconds, r.source_frame_rate_hz, r.leg_length_m,
                  r.skeleton_id, r.source_report, r.content_hash, r.create_time_us,
                  r.given.metres_per_unit, r.given.up_axis, r.given.frame_rate_hz,
                  r.given_leg_length_m, r.representation_version, r.tried_version, r.tried_time_us,
                  r.derive_error);
}

auto Fields(const storage::DatabaseRecord& r) {
  return std::tie(r.name, r.settings.frame_rate_hz, r.settings.min_frames, r.settings.scaling,
                  r.settings.glitches, r.marker_set, r.marker_set_text, r.create_time_us);
}

auto Fields(const storage::ModelRecord& r) {
  return std::tie(r.database, r.version, r.current, r.create_time_us, r.build_seconds,
                  r.frame_count, r.clip_count, r.dimension_count, r.nodes_per_layer,
                  r.added_clip_count, r.added_frame_count, r.drift_fraction);
}

auto Fields(const storage::OperationRecord& r) {
  return std::tie(r.id, r.database, r.kind, r.state, r.progress, r.stage, r.model_version,
                  r.error_code, r.error_message, r.create_time_us, r.update_time_us);
}

}  // namespace

storage::DatabaseRecord SampleDatabase(const std::string& name) {
  storage::DatabaseRecord record;
  record.name = name;
  record.settings = {.frame_rate_hz = 50,
                     .min_frames = 4,
                     .scaling = core::Scaling::kKind,
                     .glitches = core::GlitchPolicy::kDrop};
  record.marker_set = "three";
  record.marker_set_text = "markers of three";
  record.create_time_us = 1'700'000'000'000'001;
  return record;
}

core::MarkerSet SampleMarkerSet() {
  core::MarkerSet set;
  set.name = "three";
  set.markers = {"left hip", "right hip", "head"};
  set.landmarks = {.left_hip = 0, .right_hip = 1, .legs = {{0, 1, 2}}};
  return set;
}

core::StateSequence SampleStates(int frames, unsigned seed) {
  std::mt19937 random(seed);
  const auto step = [&] { return static_cast<double>(random() % 2001) / 1000.0 - 1.0; };
  core::StateSequence sequence;
  sequence.frame_rate_hz = 50;
  sequence.leg_length_m = 0.9;
  sequence.states.resize(frames, SampleMarkerSet().dimension_count());
  sequence.root_path.resize(frames, 3);
  for (int t = 0; t < frames; ++t) {
    for (int d = 0; d < sequence.states.cols(); ++d) {
      const float before = t == 0 ? 0 : sequence.states(t - 1, d);
      sequence.states(t, d) = before + static_cast<float>(step());
    }
    for (int d = 0; d < 3; ++d) sequence.root_path(t, d) = step();
  }
  if (frames > 8) sequence.glitches = {{0, 2}, {5, 5}};
  return sequence;
}

core::Skeleton SampleSkeleton(const std::string& name, double thigh_m) {
  core::Joint root{.name = "root"};
  root.dofs = {{.kind = core::Dof::Kind::kTranslation, .axis = Eigen::Vector3d::UnitZ()},
               {.axis = Eigen::Vector3d::UnitY(), .lower = -1, .upper = 2}};
  core::Joint thigh{.name = "thigh", .parent = 0, .offset_m = {0, 0, -thigh_m}};
  thigh.dofs = {{.axis = Eigen::Vector3d::UnitX()}};
  return Require(core::Skeleton::Create(name, {root, thigh}));
}

storage::NewClip SampleClip(const std::string& database, const std::string& id, unsigned seed) {
  storage::NewClip clip;
  clip.record.database = database;
  clip.record.id = id;
  clip.record.label = "walk";
  clip.record.subject = "subject 1";
  clip.record.file_name = id + ".amc";
  clip.record.skeleton_file_name = "1.asf";
  clip.record.format = core::FileFormat::kAmc;
  clip.record.frame_count = kFrames;
  clip.record.duration_seconds = 1.2;
  clip.record.source_frame_rate_hz = 120;
  clip.record.leg_length_m = 0.9;
  clip.record.source_report = "unit 0.01 m (stated)";
  clip.record.content_hash = 0xffff'0000'0000'0000 + seed;  // above the maximum of a signed number
  clip.record.create_time_us = 1'700'000'000'000'002;
  clip.record.given = {
      .metres_per_unit = 0.01, .up_axis = core::UpAxis::kMinusZ, .frame_rate_hz = 119.88};
  clip.record.given_leg_length_m = 0.9;
  clip.record.tried_time_us = 1'700'000'000'000'002;
  clip.file_bytes = "motion " + std::to_string(seed) + std::string("\0\xff", 2);
  clip.skeleton_bytes = "skeleton";
  clip.states = SampleStates(kFrames, seed);
  clip.skeleton = SampleSkeleton("human");
  return clip;
}

core::Model SampleModel(const std::vector<storage::NewClip>& clips) {
  std::vector<core::BuildInput> inputs;
  for (const storage::NewClip& clip : clips) {
    inputs.push_back({clip.record.id, clip.record.label, clip.states, clip.record.subject});
  }
  core::Model model = Require(core::BuildModel(SampleDatabase("any").settings, SampleMarkerSet(),
                                               std::move(inputs), core::RunSerially, {}));
  model.set_build_seconds(0.25);
  return model;
}

storage::OperationRecord SampleOperation(const std::string& database, const std::string& id) {
  storage::OperationRecord record;
  record.id = id;
  record.database = database;
  record.stage = "waiting";
  record.create_time_us = 1'700'000'000'000'003;
  record.update_time_us = 1'700'000'000'000'004;
  return record;
}

bool Same(const storage::DatabaseRecord& a, const storage::DatabaseRecord& b) {
  return Fields(a) == Fields(b);
}
bool Same(const storage::ClipRecord& a, const storage::ClipRecord& b) {
  return Fields(a) == Fields(b);
}
bool Same(const storage::ModelRecord& a, const storage::ModelRecord& b) {
  return Fields(a) == Fields(b);
}
bool Same(const storage::OperationRecord& a, const storage::OperationRecord& b) {
  return Fields(a) == Fields(b);
}

bool Same(const core::StateSequence& a, const core::StateSequence& b) {
  return a.frame_rate_hz == b.frame_rate_hz && a.leg_length_m == b.leg_length_m &&
         a.glitches == b.glitches && SameBytes(a.states, b.states) &&
         SameBytes(a.root_path, b.root_path);
}

bool Same(const core::Skeleton& a, const core::Skeleton& b) { return Encoded(a) == Encoded(b); }

bool Same(const core::Model& a, const core::Model& b) {
  for (std::size_t c = 0; c < std::min(a.clips().size(), b.clips().size()); ++c) {
    if (a.clips()[c].glitches != b.clips()[c].glitches) return false;
  }
  return SameBytes(a.states(), b.states()) && SameBytes(a.root_path(), b.root_path()) &&
         Encoded(a.parts()) == Encoded(b.parts());
}

std::string Encoded(const core::StateSequence& states) {
  storage::StringSink sink;
  REQUIRE_OK(storage::EncodeStates(states, sink));
  return sink.bytes();
}

std::string Encoded(const core::Skeleton& skeleton) {
  storage::StringSink sink;
  REQUIRE_OK(storage::EncodeSkeleton(skeleton, sink));
  return sink.bytes();
}

std::string Encoded(const core::ModelParts& parts) {
  storage::StringSink sink;
  REQUIRE_OK(storage::EncodeModel(parts, sink));
  return sink.bytes();
}

}  // namespace motiondb::tests
