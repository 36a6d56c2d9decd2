#include "storage/sql/tables/added_bytes.h"

#include <span>

#include "core/model/model.h"
#include "storage/blob/byte_stream.h"
#include "storage/blob/model_codec.h"

namespace motiondb::storage {
namespace {

class CountingSink final : public ByteSink {
 public:
  absl::Status Write(std::span<const std::byte> bytes) override {
    count_ += static_cast<std::int64_t>(bytes.size());
    return absl::OkStatus();
  }
  std::int64_t count() const { return count_; }

 private:
  std::int64_t count_ = 0;
};

template <typename Matrix>
std::int64_t BytesOf(const Matrix& matrix) {
  return static_cast<std::int64_t>(matrix.size()) *
         static_cast<std::int64_t>(sizeof(typename Matrix::Scalar));
}

}  // namespace

std::int64_t AddedBytes(const NewClip& clip) {
  return std::ssize(clip.file_bytes) + std::ssize(clip.skeleton_bytes) +
         BytesOf(clip.states.states) + BytesOf(clip.states.root_path);
}

std::int64_t AddedBytes(const DerivedClip& clip) {
  if (!clip.states) return 0;
  return clip.record.byte_count + BytesOf(clip.states->states) + BytesOf(clip.states->root_path);
}

std::int64_t AddedBytes(const core::Model& model) {
  CountingSink sink;
  // PutModel returns errors of encoding.
  EncodeModel(model.parts(), sink).IgnoreError();
  return sink.count();
}

}  // namespace motiondb::storage
