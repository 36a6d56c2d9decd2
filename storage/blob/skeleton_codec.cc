#include "storage/blob/skeleton_codec.h"

#include <utility>

#include "storage/blob/fields.h"

namespace motiondb::storage {
namespace {

constexpr std::uint32_t kVersion = 1;
constexpr std::size_t kDofBytes = 1 + 5 * sizeof(double);
constexpr std::size_t kJointBytes = 4 + 4 + (3 + 9 + 9) * sizeof(double) + 4;

// Stored: values do not change.
constexpr std::uint8_t kTranslation = 0;
constexpr std::uint8_t kRotation = 1;

// Vectors and matrices, column after column.
template <typename Matrix>
void PutMatrix(FieldWriter& writer, const Matrix& matrix) {
  writer.PutElements(std::span(matrix.data(), static_cast<std::size_t>(matrix.size())));
}

template <typename Matrix>
void GetMatrix(FieldReader& reader, Matrix& matrix) {
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
  if (kind > kRotation) reader.Fail(core::DataLoss("joints: unknown kind of motion {}", kind));
  dof.kind = kind == kTranslation ? core::Dof::Kind::kTranslation : core::Dof::Kind::kRotation;
  GetMatrix(reader, dof.axis);
  dof.lower = reader.Get<double>();
  dof.upper = reader.Get<double>();
  return dof;
}

core::Joint GetJoint(FieldReader& reader) {
  core::Joint joint;
  joint.name = reader.GetText();
  joint.parent = reader.Get<std::int32_t>();
  GetMatrix(reader, joint.offset_m);
  GetMatrix(reader, joint.pre_rotation);
  GetMatrix(reader, joint.post_rotation);
  joint.dofs.resize(reader.GetCount(kDofBytes));
  for (core::Dof& dof : joint.dofs) dof = GetDof(reader);
  return joint;
}

}  // namespace

absl::Status EncodeSkeleton(const core::Skeleton& skeleton, ByteSink& sink) {
  FieldWriter writer(sink);
  writer.Put(kVersion);
  writer.PutText(skeleton.name());
  writer.PutCount(skeleton.joints().size());
  for (const core::Joint& joint : skeleton.joints()) PutJoint(writer, joint);
  return writer.status();
}

absl::StatusOr<core::Skeleton> DecodeSkeleton(ByteSource& source) {
  FieldReader reader(source);
  if (const auto version = reader.Get<std::uint32_t>(); reader.ok() && version != kVersion) {
    return core::DataLoss("joints: expected version {}, got {}", kVersion, version);
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
