// Labels of stored models: their encoding, and models whose labels are fitted again.
#include <catch2/catch.hpp>
#include <string>

#include "core/calibration/calibrate.h"
#include "storage/blob/byte_stream.h"
#include "storage/blob/model_codec.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::label_codec_test {
namespace {

absl::StatusOr<core::ModelParts> Decoded(const core::ModelParts& parts) {
  const std::string bytes = Encoded(parts);
  storage::SpanSource source(std::as_bytes(std::span(bytes)));
  return storage::DecodeModel(source);
}

core::Model Built(std::vector<core::BuildInput> inputs) {
  core::BuildSettings settings;
  settings.min_frames = 8;
  core::Model model = Require(
      core::BuildModel(settings, SmallMarkerSet(3), std::move(inputs), core::RunSerially, {}));
  const absl::Status calibrated = core::Calibrate(model, core::RunSerially, {});
  INFO(calibrated);
  REQUIRE(calibrated.ok());
  return model;
}

// New labels: parts of clips, on two tracks, some clips without.
std::vector<core::ClipLabels> NewLabels(std::size_t clips) {
  std::vector<core::ClipLabels> labels(clips);
  for (std::size_t c = 0; c < clips; ++c) {
    labels[c].subject = c % 3 == 0 ? "x" : c % 3 == 1 ? "y" : "";
    if (c % 5 == 4) continue;
    const std::string name(1, static_cast<char>('p' + c % 2));
    labels[c].labels.Set(core::kActionTrack, {{name, 5, 60}, {name + "2", 70, 30}});
    if (c % 2 == 1) labels[c].labels.Set("hands", {{"cup", 0, 90}});
  }
  return labels;
}

}  // namespace

TEST_CASE("ModelCodec: tracks of labels are decoded; invalid ones are refused",
          "[storage][codec]") {
  const core::Model model = SampleModel({SampleClip("d", "walk", 1), SampleClip("d", "run", 2)});
  core::ModelParts parts = model.parts();
  parts.clips[0].labels.Set("hands", {{"cup", 3, 10}, {"box", 13, 47}});
  parts.clips[1].labels = {};
  const core::ModelParts back = Require(Decoded(parts));
  REQUIRE(back.clips[0].labels == parts.clips[0].labels);
  REQUIRE(back.clips[1].labels == parts.clips[1].labels);
  REQUIRE(Encoded(back) == Encoded(parts));

  for (const std::vector<core::LabelSpan>& wrong : {std::vector<core::LabelSpan>{{"cup", 3, 58}},
                                                    {{"cup", -1, 5}},
                                                    {{"cup", 0, 0}},
                                                    {{"", 0, 5}},
                                                    {{"a", 0, 5}, {"b", 4, 5}},
                                                    {{"cup", 2147483647, 2147483647}}}) {
    parts.clips[0].labels.Set("hands", wrong);
    REQUIRE_ERROR(Decoded(parts).status(), absl::StatusCode::kDataLoss, "track 'hands'");
  }
}

TEST_CASE("RefitLabels: equals a build of the same clips with the new labels",
          "[storage][calibration]") {
  std::vector<core::BuildInput> inputs = WanderingClips(12, 120, SmallMarkerSet(3), 5);
  const core::Model old = Built(inputs);
  const std::vector<core::ClipLabels> labels = NewLabels(inputs.size());
  const core::Model refitted =
      Require(core::RefitLabels(Require(old.WithLabels(labels)), core::RunSerially, {}));
  for (std::size_t c = 0; c < inputs.size(); ++c) {
    inputs[c].labels = labels[c].labels;
    inputs[c].subject = labels[c].subject;
  }
  const core::Model built = Built(inputs);
  CHECK(Encoded(old.parts()) != Encoded(built.parts()));
  CHECK(Encoded(refitted.parts()) == Encoded(built.parts()));
  CHECK(refitted.metric_frames().projected.view() == built.metric_frames().projected.view());
  CHECK(refitted.clip_index().means() == built.clip_index().means());
  CHECK(built.recognition().unknown == core::UnknownCalibration::kFitted);
}

TEST_CASE("RefitLabels: can be cancelled", "[storage][calibration]") {
  const core::Model model = Built(WanderingClips(4, 60, SmallMarkerSet(3), 5));
  int calls = 0;
  const auto cancelled = core::RefitLabels(model, core::RunSerially,
                                           [&](double, std::string_view) { return ++calls < 2; });
  CHECK(cancelled.status().code() == absl::StatusCode::kCancelled);
}

}  // namespace motiondb::tests::label_codec_test
