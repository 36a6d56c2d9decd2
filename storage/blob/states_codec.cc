#include "storage/blob/states_codec.h"

#include "storage/blob/fields.h"

namespace motiondb::storage {
namespace {

constexpr std::uint32_t kVersion = 1;

}  // namespace

absl::Status EncodeStates(const core::StateSequence& sequence, ByteSink& sink) {
  if (sequence.root_path.rows() != sequence.states.rows()) {
    return core::InvalidArgument("expected a root pose for each of {} frames, got {}",
                                 sequence.states.rows(), sequence.root_path.rows());
  }
  FieldWriter writer(sink);
  writer.Put(kVersion);
  writer.Put(static_cast<std::int32_t>(sequence.states.rows()));
  writer.Put(static_cast<std::int32_t>(sequence.states.cols()));
  writer.Put(sequence.frame_rate_hz);
  writer.Put(sequence.leg_length_m);
  writer.PutElements(
      std::span(sequence.states.data(), static_cast<std::size_t>(sequence.states.size())));
  writer.PutElements(
      std::span(sequence.root_path.data(), static_cast<std::size_t>(sequence.root_path.size())));
  return writer.status();
}

absl::StatusOr<StatesHeader> DecodeStatesHeader(ByteSource& source) {
  FieldReader reader(source);
  if (const auto version = reader.Get<std::uint32_t>(); reader.ok() && version != kVersion) {
    return core::DataLoss("states: expected version {}, got {}", kVersion, version);
  }
  StatesHeader header;
  header.frame_count = reader.Get<std::int32_t>();
  header.dimension_count = reader.Get<std::int32_t>();
  header.frame_rate_hz = reader.Get<double>();
  header.leg_length_m = reader.Get<double>();
  MOTIONDB_RETURN_IF_ERROR(reader.status());
  if (header.frame_count < 0 || header.dimension_count < 0) {
    return core::DataLoss("states: {} frames of {} dimensions", header.frame_count,
                          header.dimension_count);
  }
  // Neither factor reaches 2^34, so the product holds.
  const std::uint64_t frame_bytes =
      sizeof(float) * static_cast<std::uint64_t>(header.dimension_count) + 3 * sizeof(double);
  const std::uint64_t bytes = frame_bytes * static_cast<std::uint64_t>(header.frame_count);
  // Without frames no bytes bound the dimensions, which still take no memory.
  if (reader.remaining() != bytes) {
    return core::DataLoss("states: expected {} bytes for {} frames, got {}", bytes,
                          header.frame_count, reader.remaining());
  }
  return header;
}

absl::Status DecodeStatesFrames(ByteSource& source, std::span<float> states,
                                std::span<double> root_path) {
  FieldReader reader(source);
  reader.GetElements(states);
  reader.GetElements(root_path);
  return reader.Finish();
}

absl::StatusOr<core::StateSequence> DecodeStates(ByteSource& source) {
  MOTIONDB_ASSIGN_OR_RETURN(const StatesHeader header, DecodeStatesHeader(source));
  core::StateSequence sequence;
  sequence.frame_rate_hz = header.frame_rate_hz;
  sequence.leg_length_m = header.leg_length_m;
  sequence.states.resize(header.frame_count, header.dimension_count);
  sequence.root_path.resize(header.frame_count, 3);
  MOTIONDB_RETURN_IF_ERROR(DecodeStatesFrames(
      source, std::span(sequence.states.data(), static_cast<std::size_t>(sequence.states.size())),
      std::span(sequence.root_path.data(), static_cast<std::size_t>(sequence.root_path.size()))));
  return sequence;
}

}  // namespace motiondb::storage
