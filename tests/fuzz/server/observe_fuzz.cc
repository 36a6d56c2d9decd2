// Streams of Observe. An input is a sequence of messages, each after its length (u16).
#include "core/motion/error.h"
#include "motiondb/v1/observe.pb.h"
#include "server/translate/observation_message.h"
#include "tests/fuzz/server/answer_properties.h"
#include "tests/fuzz/server/message_mutation.h"
#include "tests/fuzz/server/message_stream.h"
#include "tests/fuzz/server/trained_engine.h"

using namespace motiondb;

MOTIONDB_MUTATE_STREAM_OF(v1::ObserveRequest)

namespace {

// As in server/rpc/observe_service.cc.
class Stream {
 public:
  absl::Status Take(const v1::ObserveRequest& request) {
    if (request.has_start()) return Open(request.start());
    if (!request.has_frames() || session_ == nullptr) {
      return core::InvalidArgument("expected a start message, then frames");
    }
    const v1::ObservedFrames& frames = request.frames();
    MOTIONDB_ASSIGN_OR_RETURN(const auto step,
                              session_->Take(frames.first_frame(), server::FramesFrom(frames)));
    v1::ObserveResponse response;
    server::SetStep(step, top_count_, response);
    tests::CheckAllFinite(response);
    return absl::OkStatus();
  }

 private:
  absl::Status Open(const v1::ObserveStart& start) {
    if (session_ != nullptr) return core::InvalidArgument("start: expected only one");
    MOTIONDB_ASSIGN_OR_RETURN(auto setup, server::ParseObserveSetup(start));
    top_count_ = start.top_count();
    MOTIONDB_ASSIGN_OR_RETURN(
        session_, server::ObserveSession::Open(tests::Trained().Ask(), std::move(setup)));
    return absl::OkStatus();
  }

  int top_count_ = 0;
  std::unique_ptr<server::ObserveSession> session_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Stream stream;
  tests::ForEachMessage<v1::ObserveRequest>(data, size, [&](const v1::ObserveRequest& request) {
    const absl::Status status = stream.Take(request);
    tests::CheckRefusalContract(status);
    return status.ok();
  });
  return 0;
}
