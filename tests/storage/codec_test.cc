#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <string>

#include "storage/blob/byte_stream.h"
#include "storage/blob/clip_codec.h"
#include "storage/blob/model_codec.h"
#include "storage/blob/newer_format.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"

namespace motiondb::tests::codec_test {
namespace {

storage::SpanSource SourceOf(const std::string& bytes) {
  return storage::SpanSource(std::as_bytes(std::span(bytes)));
}

// Size of the labels of the sample clip.
constexpr std::size_t kOneLabelBytes = 34;

std::string Number(std::uint32_t number) {
  return std::string(reinterpret_cast<const char*>(&number), sizeof(number));
}

// Returns the encoded labels of the sample clip: one span over 60 frames of one track.
std::string OneLabel() {
  return Number(1) + Number(6) + "action" + Number(1) + Number(4) + "walk" + Number(0) + Number(60);
}

// Changes a model of one clip "walk" without labels to an older version, in which the label follows
// the id of the clip.
std::string WithLabelInClip(std::string bytes, char version) {
  const std::string text = Number(4) + "walk";
  bytes.insert(bytes.find(text), text);
  bytes[0] = version;
  return bytes;
}

// Each function decodes the bytes and encodes the result again.
absl::StatusOr<std::string> RecodeStates(const std::string& bytes) {
  auto source = SourceOf(bytes);
  MOTIONDB_ASSIGN_OR_RETURN(const auto states, storage::DecodeStates(source));
  return Encoded(states);
}
absl::StatusOr<std::string> RecodeSkeleton(const std::string& bytes) {
  auto source = SourceOf(bytes);
  MOTIONDB_ASSIGN_OR_RETURN(const auto skeleton, storage::DecodeSkeleton(source));
  return Encoded(skeleton);
}
absl::StatusOr<std::string> RecodeModel(const std::string& bytes) {
  auto source = SourceOf(bytes);
  MOTIONDB_ASSIGN_OR_RETURN(const auto parts, storage::DecodeModel(source));
  return Encoded(parts);
}

using Recode = absl::StatusOr<std::string> (*)(const std::string&);

void RequireCorruptionIsDetected(Recode recode, const std::string& bytes, int flips) {
  REQUIRE(Require(recode(bytes)) == bytes);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const auto cut = recode(bytes.substr(0, size));
    if (cut.status().code() != absl::StatusCode::kDataLoss) FAIL("cut to " << size << " bytes");
  }
  REQUIRE(recode(bytes + '\0').status().code() == absl::StatusCode::kDataLoss);

  // A changed byte causes an error, or an object whose encoding is these bytes.
  std::mt19937 random(20);
  int refused = 0;
  for (int i = 0; i < flips; ++i) {
    std::string changed = bytes;
    const std::size_t place = random() % changed.size();
    changed[place] = static_cast<char>(changed[place] ^ (1 + random() % 255));
    const auto back = recode(changed);
    // A changed version may be that of a newer format.
    if (back.ok() ? *back != changed
                  : !absl::IsDataLoss(back.status()) && !storage::IsNewerFormat(back.status())) {
      FAIL("byte " << place << ": " << back.status());
    }
    refused += back.ok() ? 0 : 1;
  }
  REQUIRE(refused > 0);
}

// Overwrites four bytes with a huge count, which must be refused before memory is allocated.
void RequireCountsAreBounded(Recode recode, const std::string& bytes) {
  const std::uint32_t huge = 0x7fff'ffff;
  for (std::size_t place = 0; place + sizeof(huge) <= std::min<std::size_t>(bytes.size(), 4000);
       ++place) {
    std::string changed = bytes;
    std::memcpy(changed.data() + place, &huge, sizeof(huge));
    const auto back = recode(changed);
    if (back.ok() || storage::IsNewerFormat(back.status())) continue;
    if (!absl::IsDataLoss(back.status())) FAIL(back.status());
  }
}

}  // namespace

TEST_CASE("StatesCodec: decoded states are bitwise equal", "[storage][codec]") {
  auto states = SampleStates(7, 1);
  states.states(0, 0) = std::nanf("5");
  states.states(1, 1) = -0.0f;
  states.states(2, 2) = std::numeric_limits<float>::infinity();
  const std::string bytes = Encoded(states);
  REQUIRE(bytes.size() == 28 + 7 * (18 * 4 + 3 * 8));
  auto source = SourceOf(bytes);
  REQUIRE(Same(Require(storage::DecodeStates(source)), states));

  core::StateSequence none;
  none.states.resize(0, 18);
  none.root_path.resize(0, 3);
  REQUIRE(Require(RecodeStates(Encoded(none))) == Encoded(none));
}

TEST_CASE("StatesCodec: corruption is detected", "[storage][codec]") {
  core::StateSequence states = SampleStates(3, 1);
  for (const auto& glitches : {std::vector<core::FrameSpan>{}, {{0, 0}, {2, 2}}}) {
    states.glitches = glitches;
    const std::string bytes = Encoded(states);
    RequireCorruptionIsDetected(RecodeStates, bytes, 500);
    RequireCountsAreBounded(RecodeStates, bytes);
  }
}

TEST_CASE("StatesCodec: glitches are decoded; invalid spans are refused", "[storage][codec]") {
  core::StateSequence states = SampleStates(7, 1);
  states.glitches = {{0, 1}, {3, 6}};
  const std::string bytes = Encoded(states);
  auto source = SourceOf(bytes);
  REQUIRE(Same(Require(storage::DecodeStates(source)), states));
  for (const std::vector<core::FrameSpan>& wrong :
       {std::vector<core::FrameSpan>{{3, 7}}, {{-1, 2}}, {{4, 3}}, {{2, 4}, {4, 5}}}) {
    states.glitches = wrong;
    REQUIRE(RecodeStates(Encoded(states)).status().code() == absl::StatusCode::kDataLoss);
  }
}

TEST_CASE("SkeletonCodec: a decoded skeleton is bitwise equal", "[storage][codec]") {
  const core::Skeleton skeleton = SampleSkeleton("human");
  const std::string bytes = Encoded(skeleton);
  auto source = SourceOf(bytes);
  const core::Skeleton back = Require(storage::DecodeSkeleton(source));
  REQUIRE(Encoded(back) == bytes);
  REQUIRE(back.name() == "human");
  REQUIRE(back.dof_count() == 3);
  REQUIRE(back.joints()[0].dofs[0].kind == core::Dof::Kind::kTranslation);
  REQUIRE(back.joints()[0].dofs[1].upper == 2);
  REQUIRE(back.joints()[1].parent == 0);
  REQUIRE(back.joints()[1].offset_m.z() == -0.4);
  REQUIRE(std::isinf(back.joints()[1].dofs[0].lower));
}

TEST_CASE("SkeletonCodec: corruption is detected", "[storage][codec]") {
  RequireCorruptionIsDetected(RecodeSkeleton, Encoded(SampleSkeleton("human")), 3000);
  RequireCountsAreBounded(RecodeSkeleton, Encoded(SampleSkeleton("human")));
}

TEST_CASE("ModelCodec: a decoded model is bitwise equal, except its states", "[storage][codec]") {
  const core::Model model = SampleModel({SampleClip("d", "walk", 1), SampleClip("d", "run", 2)});
  const std::string bytes = Encoded(model.parts());
  auto source = SourceOf(bytes);
  core::ModelParts parts = Require(storage::DecodeModel(source));
  REQUIRE(parts.states.size() == 0);
  REQUIRE(parts.clips[1].id == "run");
  REQUIRE(parts.clips[1].first_frame == 60);
  REQUIRE(parts.marker_set.landmarks.legs.size() == 1);
  REQUIRE(parts.build_seconds == 0.25);
  parts.states = model.parts().states;
  parts.root_path = model.root_path();
  // Glitches are stored with the states.
  for (std::size_t c = 0; c < parts.clips.size(); ++c) {
    REQUIRE(parts.clips[c].glitches.empty());
    parts.clips[c].glitches = model.clips()[c].glitches;
  }
  const core::Model back = Require(core::Model::Create(std::move(parts)));
  REQUIRE(Same(back, model));
  REQUIRE(back.global_graph(2).edges() == model.global_graph(2).edges());
  REQUIRE(back.familiarity().scores == model.familiarity().scores);
  REQUIRE(back.clips()[1].subject == "subject 1");
  REQUIRE(back.metric().projection == model.metric().projection);
  REQUIRE(back.metric_frames().projected.view() == model.metric_frames().projected.view());
}

TEST_CASE("ModelCodec: the calibration is decoded; an invalid one is refused", "[storage][codec]") {
  core::Model model = SampleModel({SampleClip("d", "walk", 1)});
  core::RecognitionCalibration calibration;
  calibration.window = {{0.5, 0.25}, {-2, 1, 1, 3}};
  calibration.whole = {{2, 0}, {0.5F}};
  model.set_recognition(calibration);
  const auto decoded = [](const core::Model& encoded) {
    const std::string bytes = Encoded(encoded.parts());
    auto source = SourceOf(bytes);
    return storage::DecodeModel(source);
  };
  const core::ModelParts back = Require(decoded(model));
  REQUIRE(back.recognition.window.weight.scale == 0.5);
  REQUIRE(back.recognition.window.weight.power == 0.25);
  REQUIRE(back.recognition.window.familiarity == calibration.window.familiarity);
  REQUIRE(back.recognition.whole.weight.scale == 2);
  REQUIRE(back.recognition.whole.familiarity == calibration.whole.familiarity);

  REQUIRE(back.recognition.unknown == core::UnknownCalibration::kNotFitted);
  REQUIRE_FALSE(back.recognition.window.unknown.has_value());

  calibration.window.familiarity = {1, 0};
  model.set_recognition(calibration);
  REQUIRE_ERROR(decoded(model).status(), absl::StatusCode::kDataLoss, "ascending");
  calibration.window = {{std::nan(""), 1}, {}};
  model.set_recognition(calibration);
  REQUIRE_ERROR(decoded(model).status(), absl::StatusCode::kDataLoss, "calibration");
}

TEST_CASE("ModelCodec: the model of unknown motion is decoded; an invalid one is refused",
          "[storage][codec]") {
  core::Model model = SampleModel({SampleClip("d", "walk", 1)});
  core::RecognitionCalibration calibration;
  calibration.unknown = core::UnknownCalibration::kFitted;
  calibration.window.unknown = {-1, {2, -3}, 5, {{"jog", 4}, {"walk", -2}}};
  calibration.whole.unknown = {-2, {0.5, 0}, 6, {}};
  const auto decoded = [&] {
    model.set_recognition(calibration);
    const std::string bytes = Encoded(model.parts());
    auto source = SourceOf(bytes);
    return storage::DecodeModel(source);
  };
  const core::RecognitionCalibration back = Require(decoded()).recognition;
  REQUIRE(back.unknown == core::UnknownCalibration::kFitted);
  REQUIRE(back.window.unknown->weights == calibration.window.unknown->weights);
  REQUIRE(back.window.unknown->labels.size() == 2);
  REQUIRE(back.window.unknown->labels[1].label == "walk");
  REQUIRE(back.window.unknown->labels[1].log_distance == -2);
  REQUIRE(back.whole.unknown->intercept == -2);
  REQUIRE(back.whole.unknown->typical_log_distance == 6);

  const auto require_refused = [&] {
    REQUIRE_ERROR(decoded().status(), absl::StatusCode::kDataLoss, "unknown motion");
  };
  calibration.window.unknown->labels[1].label = "jog";  // not ascending
  require_refused();
  calibration.window.unknown->labels[1] = {"walk", std::nan("")};
  require_refused();
  calibration.window.unknown->labels.clear();
  calibration.whole.unknown->weights[1] = std::nan("");
  require_refused();

  for (const auto reason :
       {core::UnknownCalibration::kOneClip, core::UnknownCalibration::kOneLabel,
        core::UnknownCalibration::kOneSubject, core::UnknownCalibration::kTooFewClips}) {
    calibration = {};
    calibration.unknown = reason;
    REQUIRE(Require(decoded()).recognition.unknown == reason);
  }
}

TEST_CASE("ModelCodec: a model of version 1 is read without the parts of later versions",
          "[storage][codec]") {
  const core::Model model = SampleModel({SampleClip("d", "walk", 1)});
  core::ModelParts plain = model.parts();
  plain.clips.front().subject.clear();
  plain.prior = {};
  plain.confidence = {};
  plain.metric = {};
  plain.recognition = {};
  plain.tree = Require(core::Tree::Create(plain.tree.frame_order(), plain.tree.branches()));
  // The fields of version 2 now have a known size; they precede the last field.
  std::string bytes = Encoded(plain);
  constexpr std::size_t kAnswerBytes = 2 * sizeof(double) + sizeof(std::uint32_t);
  // Version 4 added one number here, version 5 the labels.
  constexpr std::size_t kAdded = 5 * sizeof(std::uint32_t) + 2 * kAnswerBytes + kOneLabelBytes;
  bytes.erase(bytes.size() - sizeof(double) - kAdded, kAdded);
  // The fields of version 3, a threshold count of 0 and a clip count, follow the branches.
  const auto& branches = plain.tree.branches();
  const std::string_view branch_bytes(reinterpret_cast<const char*>(branches.data()),
                                      branches.size() * sizeof(core::Branch));
  bytes.erase(bytes.find(branch_bytes) + branch_bytes.size(),
              sizeof(std::uint32_t) + sizeof(std::int32_t));
  bytes = WithLabelInClip(bytes, 1);

  auto source = SourceOf(bytes);
  core::ModelParts parts = Require(storage::DecodeModel(source));
  REQUIRE(parts.metric.empty());
  REQUIRE(parts.prior.seconds.empty());
  REQUIRE(parts.build_seconds == 0.25);
  parts.states = model.parts().states;
  parts.root_path = model.root_path();
  const core::Model back = Require(core::Model::Create(std::move(parts)));
  REQUIRE(Encoded(back.parts()) == Encoded(plain));
}

TEST_CASE("ModelCodec: a model of version 4 has one label for each clip", "[storage][codec]") {
  const core::Model model = SampleModel({SampleClip("d", "walk", 1)});
  std::string bytes = Encoded(model.parts());
  const std::string labels = OneLabel();
  bytes.erase(bytes.find(labels), labels.size());
  bytes = WithLabelInClip(bytes, 4);
  auto source = SourceOf(bytes);
  const core::ModelParts parts = Require(storage::DecodeModel(source));
  REQUIRE(parts.clips[0].label() == "walk");
  REQUIRE(Encoded(parts) == Encoded(model.parts()));
}

TEST_CASE("ModelCodec: the model of unknown motion of version 5 is not used", "[storage][codec]") {
  core::Model model = SampleModel({SampleClip("d", "walk", 1)});
  core::RecognitionCalibration calibration;
  calibration.unknown = core::UnknownCalibration::kFitted;
  calibration.window = {{0.5, 0.25}, {1}, core::UnknownModel{-1, {2, -3}, 5, {{"walk", 4}}}};
  calibration.whole = {{2, 0}, {3}, core::UnknownModel{-4, {8, -6}, 7, {}}};
  model.set_recognition(calibration);
  std::string bytes = Encoded(model.parts());
  bytes[0] = 5;
  // It had a third weight, and a deviation for the typical label and for each label.
  for (const double before : {-3.0, 5.0, 4.0, -6.0, 7.0}) {
    const std::string number(reinterpret_cast<const char*>(&before), sizeof(before));
    bytes.insert(bytes.rfind(number), number);
  }
  auto source = SourceOf(bytes);
  const core::RecognitionCalibration back = Require(storage::DecodeModel(source)).recognition;
  REQUIRE(back.unknown == core::UnknownCalibration::kNotFitted);
  REQUIRE_FALSE(back.window.unknown.has_value());
  REQUIRE_FALSE(back.whole.unknown.has_value());
  REQUIRE(back.whole.weight.scale == 2);
}

TEST_CASE("ModelCodec: a model of a newer version is not corrupt", "[storage][codec]") {
  std::string bytes = Encoded(SampleModel({SampleClip("d", "walk", 1)}).parts());
  ++bytes[0];
  auto source = SourceOf(bytes);
  const absl::Status status = storage::DecodeModel(source).status();
  CHECK(storage::IsNewerFormat(status));
  REQUIRE_ERROR(status, absl::StatusCode::kFailedPrecondition, "upgrade this server");
}

TEST_CASE("ModelCodec: corruption is detected", "[storage][codec]") {
  const std::string bytes = Encoded(SampleModel({SampleClip("d", "walk", 1)}).parts());
  RequireCorruptionIsDetected(RecodeModel, bytes, 3000);
  RequireCountsAreBounded(RecodeModel, bytes);
}

TEST_CASE("FieldReader: keeps its first error", "[storage][codec]") {
  const std::string bytes(6, '\x01');
  auto source = SourceOf(bytes);
  storage::FieldReader reader(source);
  REQUIRE(reader.Get<std::uint16_t>() == 0x0101);
  REQUIRE(reader.GetText().empty());  // its length is 16843009
  const absl::Status first = reader.status();
  REQUIRE_ERROR(first, absl::StatusCode::kDataLoss, "16843009");
  REQUIRE(reader.Get<std::uint8_t>() == 0);
  REQUIRE(reader.GetArray<double>().empty());
  REQUIRE(reader.Finish() == first);
}

}  // namespace motiondb::tests::codec_test
