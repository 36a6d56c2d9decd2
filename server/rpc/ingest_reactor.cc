#include "server/rpc/ingest_reactor.h"

#include <atomic>
#include <memory>
#include <utility>

#include "core/motion/error.h"
#include "motiondb/v1/clip.pb.h"
#include "server/rpc/call.h"
#include "server/rpc/silence_limit.h"
#include "server/translate/clip_message.h"
#include "server/translate/field_violation.h"
#include "server/translate/ingest_stream.h"
#include "server/translate/operation_message.h"
#include "server/translate/resource_name.h"

namespace motiondb::server {
namespace {

class IngestReactor final : public grpc::ServerReadReactor<v1::IngestClipRequest> {
 public:
  IngestReactor(CallHost& host, grpc::CallbackServerContext& context,
                v1::IngestClipResponse& response)
      : entry_(host, context, MethodOf<v1::IngestClipRequest>()),
        engine_(host.engine),
        response_(response),
        stream_(engine_.options().max_file_bytes),
        silence_(engine_.workers().request_executor(), host.limits.options().longest_silence,
                 [this] { EndSilence(); }) {
    if (grpc::Status admission = entry_.Admission(); !admission.ok()) {
      End(std::move(admission));
      return;
    }
    Read();
  }

  void OnReadDone(bool ok) override {
    if (!reading_.exchange(false)) return;  // the call has ended meanwhile
    if (!ok) {
      entry_.Post([this] { End(RunHandler(entry_.cancelled(), [this] { return Store(); })); });
    } else if (database_ == nullptr) {
      entry_.Post([this] { Take([this] { return Begin(); }); });
    } else {
      Take([this]() -> absl::Status {
        MOTIONDB_RETURN_IF_ERROR(entry_.Recheck());
        return stream_.Take(std::move(message_));
      });
    }
  }
  void OnDone() override { delete this; }

 private:
  void Take(const std::function<absl::Status()>& take) {
    grpc::Status status = RunHandler(entry_.cancelled(), take);
    if (!status.ok()) return End(std::move(status));
    Read();
  }

  void Read() {
    silence_.Restart();
    reading_ = true;
    StartRead(&message_);
  }

  // What was sent so far is kept in memory, and a rebuild may be waiting for the rest.
  void EndSilence() {
    if (reading_.exchange(false)) End(entry_.Silent());
  }

  void End(grpc::Status status) { Finish(entry_.End(std::move(status))); }

  absl::Status Begin() {
    MOTIONDB_RETURN_IF_ERROR(entry_.Check(message_));
    MOTIONDB_RETURN_IF_ERROR(stream_.Take(std::move(message_)));
    MOTIONDB_ASSIGN_OR_RETURN(database_, engine_.FindDatabase(stream_.database()));
    MOTIONDB_ASSIGN_OR_RETURN(in_flight_, engine_.BeginIngest(database_));
    return absl::OkStatus();
  }

  absl::Status Store() {
    const LogFields fields{{"request_id", entry_.request_id()}};
    // A stream without any message was not checked yet.
    MOTIONDB_RETURN_IF_ERROR(database_ == nullptr ? entry_.Check(message_) : entry_.Recheck());
    MOTIONDB_ASSIGN_OR_RETURN(IngestFile file, stream_.Finish());
    file.audit = [this](const storage::ClipRecord& clip) {
      return entry_.RecordWithChange(ClipName(clip.database, clip.id));
    };
    auto ingested = engine_.Ingest(database_, std::move(file), entry_.cancelled());
    if (!ingested.ok()) return AtField("file_block", ingested.status());
    SetClip(ingested->clip, *response_.mutable_clip());
    SetOperation(ingested->operation, *response_.mutable_operation());
    in_flight_.reset();
    return absl::OkStatus();
  }

  CallEntry entry_;
  Engine& engine_;
  v1::IngestClipResponse& response_;
  v1::IngestClipRequest message_;
  IngestStream stream_;
  std::shared_ptr<LiveDatabase> database_;
  std::unique_ptr<Rebuilder::Ingest> in_flight_;
  std::atomic<bool> reading_ = false;  // a read is under way, and the call has not ended
  SilenceLimit silence_;               // last: it calls what is above
};

}  // namespace

grpc::ServerReadReactor<v1::IngestClipRequest>* NewIngestReactor(
    CallHost& host, grpc::CallbackServerContext& context, v1::IngestClipResponse& response) {
  return new IngestReactor(host, context, response);
}

}  // namespace motiondb::server
