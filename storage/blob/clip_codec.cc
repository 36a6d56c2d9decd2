#include "storage/blob/clip_codec.h"

#include <utility>

#include "storage/blob/byte_stream.h"

namespace motiondb::storage {

namespace {

constexpr std::uint32_t kWholeVersion = 1;   // without glitches
constexpr std::uint32_t kGlitchVersion = 2;  // with the frame spans of at least one glitch

static_assert(sizeof(core::FrameSpan) == 8, "spans are stored in their memory layout");

std::vector<core::FrameSpan> GetSpans(FieldReader& reader, std::int32_t frame_count) {
  auto spans = reader.GetArray<core::FrameSpan>();
  std::int64_t next = 0;
  for (const core::FrameSpan& span : spans) {
    if (span.first < next || span.last < span.first || span.last >= frame_count) {
      reader.Fail(core::DataLoss("states: invalid glitch in frames {} to {} of {}", span.first,
                                 span.last, frame_count));
      break;
    }
    next = std::int64_t{span.last} + 1;
  }
  if (reader.ok() && spans.empty())
    reader.Fail(core::DataLoss("states: version 2 without a glitch"));
  return spans;
}

}  // namespace

absl::Status EncodeStates(const core::StateSequence& sequence, ByteSink& sink) {
  if (sequence.root_path.rows() != sequence.states.rows()) {
    return core::InvalidArgument("expected a root pose for each of {} frames, got {}",
                                 sequence.states.rows(), sequence.root_path.rows());
  }
  FieldWriter writer(sink);
  writer.Put(sequence.glitches.empty() ? kWholeVersion : kGlitchVersion);
  writer.Put(static_cast<std::int32_t>(sequence.states.rows()));
  writer.Put(static_cast<std::int32_t>(sequence.states.cols()));
  writer.Put(sequence.frame_rate_hz);
  writer.Put(sequence.leg_length_m);
  if (!sequence.glitches.empty()) writer.PutArray(sequence.glitches);
  writer.PutElements(
      std::span(sequence.states.data(), static_cast<std::size_t>(sequence.states.size())));
  writer.PutElements(
      std::span(sequence.root_path.data(), static_cast<std::size_t>(sequence.root_path.size())));
  return writer.status();
}

absl::StatusOr<StatesHeader> DecodeStatesHeader(ByteSource& source) {
  FieldReader reader(source);
  const auto version = reader.Get<std::uint32_t>();
  if (reader.ok() && version != kWholeVersion && version != kGlitchVersion) {
    return core::DataLoss("states: expected version {} or {}, got {}", kWholeVersion,
                          kGlitchVersion, version);
  }
  StatesHeader header;
  header.frame_count = reader.Get<std::int32_t>();
  header.dimension_count = reader.Get<std::int32_t>();
  header.frame_rate_hz = reader.Get<double>();
  header.leg_length_m = reader.Get<double>();
  if (version == kGlitchVersion) header.glitches = GetSpans(reader, header.frame_count);
  MOTIONDB_RETURN_IF_ERROR(reader.status());
  if (header.frame_count < 0 || header.dimension_count < 0) {
    return core::DataLoss("states: negative size, {} frames of {} dimensions", header.frame_count,
                          header.dimension_count);
  }
  // frame_bytes < 2^34 and frame_count < 2^31: the product does not overflow.
  const std::uint64_t frame_bytes =
      sizeof(float) * static_cast<std::uint64_t>(header.dimension_count) + 3 * sizeof(double);
  const std::uint64_t bytes = frame_bytes * static_cast<std::uint64_t>(header.frame_count);
  // With 0 frames the number of dimensions is not checked, but no memory is allocated.
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
  MOTIONDB_ASSIGN_OR_RETURN(StatesHeader header, DecodeStatesHeader(source));
  core::StateSequence sequence;
  sequence.frame_rate_hz = header.frame_rate_hz;
  sequence.leg_length_m = header.leg_length_m;
  sequence.glitches = std::move(header.glitches);
  sequence.states.resize(header.frame_count, header.dimension_count);
  sequence.root_path.resize(header.frame_count, 3);
  MOTIONDB_RETURN_IF_ERROR(DecodeStatesFrames(
      source, std::span(sequence.states.data(), static_cast<std::size_t>(sequence.states.size())),
      std::span(sequence.root_path.data(), static_cast<std::size_t>(sequence.root_path.size()))));
  return sequence;
}

namespace {

constexpr std::uint32_t kSkeletonVersion = 1;
constexpr std::size_t kDofBytes = 1 + 5 * sizeof(double);
constexpr std::size_t kJointBytes = 4 + 4 + (3 + 9 + 9) * sizeof(double) + 4;

// Stored: never change a value.
constexpr std::uint8_t kTranslation = 0;
constexpr std::uint8_t kRotation = 1;

// Reads a vector or matrix of fixed size, column by column.
template <typename Matrix>
void GetFixed(FieldReader& reader, Matrix& matrix) {
  reader.GetElements(std::span(matrix.data(), static_cast<std::size_t>(matrix.size())));
}

void PutJoint(FieldWriter& writer, const core::Joint& joint) {
  writer.PutText(joint.name);
  writer.Put(std::int32_t{joint.parent});
  PutMatrix(writer, joint.offset_m);
  PutMatrix(writer, joint.pre_rotation);
  PutMatrix(writer, joint.post_rotation);
  writer.PutCount(joint.dofs.size());
  for (const core::Dof& dof : joint.dofs) {
    writer.Put(dof.kind == core::Dof::Kind::kTranslation ? kTranslation : kRotation);
    PutMatrix(writer, dof.axis);
    writer.Put(dof.lower);
    writer.Put(dof.upper);
  }
}

core::Dof GetDof(FieldReader& reader) {
  core::Dof dof;
  const auto kind = reader.Get<std::uint8_t>();
  if (kind > kRotation)
    reader.Fail(core::DataLoss("joints: unknown kind of degree of freedom {}", kind));
  dof.kind = kind == kTranslation ? core::Dof::Kind::kTranslation : core::Dof::Kind::kRotation;
  GetFixed(reader, dof.axis);
  dof.lower = reader.Get<double>();
  dof.upper = reader.Get<double>();
  return dof;
}

core::Joint GetJoint(FieldReader& reader) {
  core::Joint joint;
  joint.name = reader.GetText();
  joint.parent = reader.Get<std::int32_t>();
  GetFixed(reader, joint.offset_m);
  GetFixed(reader, joint.pre_rotation);
  GetFixed(reader, joint.post_rotation);
  joint.dofs.resize(reader.GetCount(kDofBytes));
  for (core::Dof& dof : joint.dofs) dof = GetDof(reader);
  return joint;
}

}  // namespace

absl::Status EncodeSkeleton(const core::Skeleton& skeleton, ByteSink& sink) {
  FieldWriter writer(sink);
  writer.Put(kSkeletonVersion);
  writer.PutText(skeleton.name());
  writer.PutCount(skeleton.joints().size());
  for (const core::Joint& joint : skeleton.joints()) PutJoint(writer, joint);
  return writer.status();
}

absl::StatusOr<core::Skeleton> DecodeSkeleton(ByteSource& source) {
  FieldReader reader(source);
  if (const auto version = reader.Get<std::uint32_t>();
      reader.ok() && version != kSkeletonVersion) {
    return core::DataLoss("joints: expected version {}, got {}", kSkeletonVersion, version);
  }
  std::string name = reader.GetText();
  std::vector<core::Joint> joints(reader.GetCount(kJointBytes));
  for (core::Joint& joint : joints) joint = GetJoint(reader);
  MOTIONDB_RETURN_IF_ERROR(reader.Finish());
  auto skeleton = core::Skeleton::Create(std::move(name), std::move(joints));
  if (!skeleton.ok()) return core::DataLoss("joints: {}", std::string(skeleton.status().message()));
  return skeleton;
}

}  // namespace motiondb::storage
