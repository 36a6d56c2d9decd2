// Streams of IngestClip, and reading the received file. An input is a sequence of messages, each
// after its length (u16).
#include "motiondb/v1/clip.pb.h"
#include "server/engine/ingest.h"
#include "server/translate/ingest_stream.h"
#include "tests/fuzz/server/answer_properties.h"
#include "tests/fuzz/server/message_stream.h"
#include "tests/fuzz/support/motion_properties.h"
#include "tests/fuzz/support/properties.h"

using namespace motiondb;

MOTIONDB_MUTATE_STREAM_OF(v1::IngestClipRequest)

namespace {

constexpr std::size_t kMaxBytes = 16 << 10;

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  server::IngestStream stream(kMaxBytes);
  bool taken = true;
  tests::ForEachMessage<v1::IngestClipRequest>(data, size,
                                               [&](const v1::IngestClipRequest& request) {
                                                 const absl::Status status = stream.Take(request);
                                                 tests::CheckRefusalContract(status);
                                                 taken = status.ok();
                                                 return taken;
                                               });
  if (!taken) return 0;
  const auto finished = stream.Finish();
  tests::CheckRefusalContract(finished.status());
  if (!finished.ok()) return 0;
  const storage::NewClip& clip = finished->clip;
  tests::CheckContract(clip.file_bytes.size() + clip.skeleton_bytes.size() <= kMaxBytes,
                       "a file is within the limit");
  const storage::ClipRecord& record = clip.record;
  tests::CheckContract(record.file_name.find('/') == std::string::npos,
                       "a file's name has no folder");
  tests::CheckMotionFile(core::ReadMotionFile(record.format, {record.file_name, clip.file_bytes},
                                              server::SkeletonFile(record, clip.skeleton_bytes),
                                              record.given));
  return 0;
}
