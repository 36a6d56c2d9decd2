// Seeds of the codecs: blobs of the samples of the store tests.
#include <catch2/catch.hpp>
#include <vector>

#include "storage/blob/chunk_stream.h"
#include "storage/blob/model_codec.h"
#include "tests/fuzz/seeds/seed_file.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"

namespace motiondb::tests {
namespace {

template <typename Put, typename... Values>
std::string Fields(const Put& put, const Values&... values) {
  storage::StringSink sink;
  storage::FieldWriter writer(sink);
  (put(writer, values), ...);
  REQUIRE_OK(writer.status());
  return sink.bytes();
}

std::string Length(std::size_t bytes) {
  const auto length = static_cast<std::uint32_t>(bytes);
  return {reinterpret_cast<const char*>(&length), sizeof(length)};
}

// Returns a blob's chunks, each after its length, behind two bytes for the target.
std::string Chunks(const std::string& payload, char seal) {
  std::string input{seal, 0};
  storage::ChunkSink sink(storage::BlobKind::kStates,
                          [&](std::uint32_t, std::span<const std::byte> chunk) {
                            input += Length(chunk.size());
                            input.append(reinterpret_cast<const char*>(chunk.data()), chunk.size());
                            return absl::OkStatus();
                          });
  REQUIRE_OK(sink.Write(std::as_bytes(std::span(payload))));
  REQUIRE_OK(sink.Finish());
  return input;
}

TEST_CASE("Seeds: chunks", "[seeds]") {
  WriteSeed("chunk_fuzz", "empty", Chunks("", 0));
  WriteSeed("chunk_fuzz", "one", Chunks("payload", 0));
  WriteSeed("chunk_fuzz", "resealed", Chunks("payload", 1));
}

TEST_CASE("Seeds: states and skeletons", "[seeds]") {
  WriteSeed("states_codec_fuzz", "none", Encoded(SampleStates(0, 1)));
  WriteSeed("states_codec_fuzz", "few", Encoded(SampleStates(3, 1)));
  WriteSeed("skeleton_codec_fuzz", "human", Encoded(SampleSkeleton("human")));
}

TEST_CASE("Seeds: models and their parts", "[seeds]") {
  const core::Model one = SampleModel({SampleClip("db", "a", 1)});
  const core::Model two = SampleModel({SampleClip("db", "a", 1), SampleClip("db", "b", 2)});
  WriteSeed("model_codec_fuzz", "one_clip", Encoded(one.parts()));
  WriteSeed("model_codec_fuzz", "two_clips", Encoded(two.parts()));
  for (int layer = 1; layer <= one.layer_count(); ++layer) {
    WriteSeed("graph_codec_fuzz", "layer" + std::to_string(layer),
              Fields(storage::PutGraph, one.global_graph(layer)));
  }
  WriteSeed("graph_codec_fuzz", "clip", Fields(storage::PutClipGraph, *one.parts().clip_graphs[0]));

  const std::string markers(1, static_cast<char>(one.marker_set().marker_count()));
  WriteSeed("prediction_codec_fuzz", "prior", markers + Fields(storage::PutPrior, one.prior()));
  WriteSeed("recognition_codec_fuzz", "metric", markers + Fields(storage::PutMetric, one.metric()));
  core::PredictionConfidence confidence;
  confidence.models.resize(2);
  confidence.models[0].seconds = 0.1;
  confidence.models[1].seconds = 0.2;
  for (core::ErrorModel& model : confidence.models) model.deviation = 1;
  WriteSeed("prediction_codec_fuzz", "confidence",
            markers + Fields(storage::PutConfidence, confidence));
  core::RecognitionCalibration calibration;
  calibration.window.familiarity = {-1, 0, 1};
  WriteSeed("recognition_codec_fuzz", "calibration",
            markers + Fields(storage::PutRecognition, calibration));
  calibration.unknown = core::UnknownCalibration::kFitted;
  calibration.window.unknown = calibration.whole.unknown =
      core::UnknownModel{-1, {1, -1}, 3, {{"walk", 2}}};
  WriteSeed("recognition_codec_fuzz", "unknown",
            markers + Fields(storage::PutRecognition, calibration));
}

}  // namespace
}  // namespace motiondb::tests
