// Streams of Observe. An input is a stream's messages, each behind its length (u16).
#include "core/motion/error.h"
#include "motiondb/v1/observe.pb.h"
#include "server/translate/observe_message.h"
#include "tests/fuzz/server/answer_properties.h"
#include "tests/fuzz/server/message_mutation.h"
#include "tests/fuzz/server/message_stream.h"
#include "tests/fuzz/server/trained_engine.h"

using namespace motiondb;

MOTIONDB_MUTATE_STREAM_OF(v1::ObserveRequest)

namespace {

// As the call does it (server/rpc/observe_reactor.cc).
class Stream {
 public:
  absl::Status Take(const v1::ObserveRequest& request) {
    if (request.has_start()) return Open(request.start());
    if (!request.has_frames() || session_ == nullptr) {
      return core::InvalidArgument("expected a start, then frames");
    }
    MOTIONDB_ASSIGN_OR_RETURN(const core::FrameMatrix positions,
                              server::FramesFrom(request.frames(), marker_names_));
    MOTIONDB_ASSIGN_OR_RETURN(const auto step,
                              session_->Take(request.frames().first_frame(), positions, {}));
    v1::ObserveResponse response;
    server::SetStep(step, top_count_, response);
    tests::HoldsFinite(response);
    return absl::OkStatus();
  }

 private:
  absl::Status Open(const v1::ObserveStart& start) {
    if (session_ != nullptr) return core::InvalidArgument("start: expected once");
    tests::TrainedEngine& trained = tests::Trained();
    MOTIONDB_ASSIGN_OR_RETURN(const auto scheme, trained.database->scheme());
    MOTIONDB_ASSIGN_OR_RETURN(auto setup, server::SetupFrom(start, trained.model(), scheme->set));
    marker_names_ = setup.marker_names;
    top_count_ = start.top_count();
    MOTIONDB_ASSIGN_OR_RETURN(
        session_, server::ObserveSession::Open(*trained.engine, trained.database, trained.snapshot,
                                               std::move(setup)));
    return absl::OkStatus();
  }

  std::vector<std::string> marker_names_;
  int top_count_ = 0;
  std::unique_ptr<server::ObserveSession> session_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Stream stream;
  tests::ForEachMessage<v1::ObserveRequest>(data, size, [&](const v1::ObserveRequest& request) {
    const absl::Status status = stream.Take(request);
    tests::HoldsRefusal(status);
    return status.ok();
  });
  return 0;
}
