#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include "core/motion/error.h"
#include "motiondb/v1/clip.pb.h"
#include "server/rpc/receive_reactor.h"
#include "server/rpc/services.h"
#include "server/translate/ingest_stream.h"
#include "server/translate/message_fields.h"
#include "server/translate/record_messages.h"
#include "server/translate/resource_name.h"

namespace motiondb::server {
namespace {

// The steps of IngestClip and UploadClip after their requests are read.
class IngestSteps {
 public:
  // `file_field`: field of the request with the bytes of the file.
  IngestSteps(Engine& engine, CallContext& entry, std::string_view file_field)
      : engine_(engine), entry_(entry), file_field_(file_field) {}

  // Finds the database, and lets its builds wait for this clip.
  absl::Status Open(const std::string& database, bool validate_only) {
    MOTIONDB_ASSIGN_OR_RETURN(database_, engine_.FindDatabase(database));
    if (validate_only) return absl::OkStatus();
    MOTIONDB_ASSIGN_OR_RETURN(in_flight_, engine_.BeginIngest(database_));
    return absl::OkStatus();
  }
  bool is_open() const { return database_ != nullptr; }

  absl::Status Import(IngestRequest& request) {
    return AtField(file_field_, ImportBefore(request, Terms()));
  }

  // Sets clip and operation of the response.
  template <typename Response>
  absl::Status Store(IngestRequest request, Response& response) {
    const bool validate_only = request.validate_only;
    request.clip.author = entry_.principal();
    request.clip.audit = [this](const storage::ClipRecord& record) {
      return entry_.AuditRecordForChange(ClipName(record.database, record.id));
    };
    auto ingested = engine_.Ingest(database_, std::move(request), Terms());
    if (!ingested.ok()) return AtField(file_field_, ingested.status());
    SetClip(ingested->clip, *response.mutable_clip());
    if (validate_only) {
      entry_.SetUnrecorded();
    } else {
      SetOperation(ingested->operation, *response.mutable_operation());
    }
    in_flight_.reset();
    return absl::OkStatus();
  }

 private:
  WorkOptions Terms() {
    return {AllowedWork::kAllWork, entry_.cancelled(),
            [this](std::int64_t bytes) { return entry_.ReserveWork(bytes); }};
  }

  Engine& engine_;
  CallContext& entry_;
  const std::string_view file_field_;
  std::shared_ptr<LiveDatabase> database_;
  std::unique_ptr<ModelLifecycle::Ingest> in_flight_;
};

class IngestReactor final : public ReceiveReactor<v1::IngestClipRequest> {
 public:
  IngestReactor(ServiceContext& host, grpc::CallbackServerContext& context,
                v1::IngestClipResponse& response)
      : ReceiveReactor(host, context, ReceiveThread::kGrpcThread),
        steps_(host.engine, entry(), "file_block"),
        response_(response),
        stream_(host.engine.options().max_file_bytes) {}

 private:
  absl::Status Take(v1::IngestClipRequest& message) override {
    MOTIONDB_RETURN_IF_ERROR(stream_.Take(std::move(message)));
    MOTIONDB_RETURN_IF_ERROR(entry().ReserveFile(stream_.byte_count()));
    if (steps_.is_open()) return absl::OkStatus();
    return steps_.Open(stream_.database(), stream_.validate_only());
  }

  bool NeedsImport() const override { return stream_.needs_import(); }

  absl::Status Import() override {
    MOTIONDB_ASSIGN_OR_RETURN(request_, stream_.Finish());
    return steps_.Import(*request_);
  }

  absl::Status Answer() override {
    if (!request_) {
      MOTIONDB_ASSIGN_OR_RETURN(request_, stream_.Finish());
    }
    return steps_.Store(*std::move(request_), response_);
  }

  IngestSteps steps_;
  v1::IngestClipResponse& response_;
  IngestStream stream_;
  std::optional<IngestRequest> request_;
};

// Owned by gRPC: deletes itself when the call is over.
class UploadClipReactor final : public grpc::ServerUnaryReactor {
 public:
  // gRPC keeps `message` and `response` until the call is finished.
  UploadClipReactor(ServiceContext& host, const grpc::CallbackServerContext& context,
                    const v1::UploadClipRequest& message, v1::UploadClipResponse& response)
      : entry_(host, context, MethodOf<v1::UploadClipRequest>()),
        steps_(host.engine, entry_, "file"),
        max_file_bytes_(host.engine.options().max_file_bytes),
        message_(message),
        response_(response) {
    if (grpc::Status admission = entry_.Admission(); !admission.ok()) {
      End(std::move(admission));
      return;
    }
    entry_.Begin(message_, [this](grpc::Status checked) {
      checked.ok() ? Begin() : End(std::move(checked));
    });
  }
  void OnDone() override { delete this; }

 private:
  // Runs one step of the call and returns its status.
  grpc::Status Step(absl::Status (UploadClipReactor::*step)()) {
    return RunHandler(entry_.cancelled(), [this, step]() -> absl::Status {
      const LogFields fields{{"request_id", entry_.request_id()}};
      return (this->*step)();
    });
  }

  void Begin() {
    if (grpc::Status read = Step(&UploadClipReactor::Read); !read.ok()) return End(std::move(read));
    if (!NeedsImport(request_)) return End(Step(&UploadClipReactor::Store));
    entry_.PostImport([this] {
      grpc::Status imported = Step(&UploadClipReactor::Import);
      entry_.Post(
          [this, imported] { End(imported.ok() ? Step(&UploadClipReactor::Store) : imported); });
    });
  }

  absl::Status Read() {
    // For the copy of the files, which the request lends.
    MOTIONDB_RETURN_IF_ERROR(
        entry_.ReserveFile(message_.file().size() + message_.skeleton_file().size()));
    MOTIONDB_ASSIGN_OR_RETURN(const std::string database,
                              ParseDatabaseName("header.parent", message_.header().parent()));
    MOTIONDB_ASSIGN_OR_RETURN(request_, ParseUpload(message_, max_file_bytes_));
    if (request_.validate_only) request_.points = &points_;
    return steps_.Open(database, request_.validate_only);
  }

  absl::Status Import() {
    MOTIONDB_RETURN_IF_ERROR(entry_.Recheck());
    return steps_.Import(request_);
  }

  absl::Status Store() {
    MOTIONDB_RETURN_IF_ERROR(entry_.Recheck());
    MOTIONDB_RETURN_IF_ERROR(steps_.Store(std::move(request_), response_));
    SetSourcePoints(points_, response_);
    return absl::OkStatus();
  }

  void End(grpc::Status status) { Finish(entry_.End(std::move(status), response_.ByteSizeLong())); }

  CallContext entry_;
  IngestSteps steps_;
  const std::size_t max_file_bytes_;
  const v1::UploadClipRequest& message_;
  v1::UploadClipResponse& response_;
  IngestRequest request_;
  core::SourcePoints points_;
};

}  // namespace

grpc::ServerReadReactor<v1::IngestClipRequest>* NewIngestReactor(
    ServiceContext& host, grpc::CallbackServerContext& context, v1::IngestClipResponse& response) {
  return new IngestReactor(host, context, response);
}

grpc::ServerUnaryReactor* NewUploadClipReactor(ServiceContext& host,
                                               grpc::CallbackServerContext& context,
                                               const v1::UploadClipRequest& request,
                                               v1::UploadClipResponse& response) {
  return new UploadClipReactor(host, context, request, response);
}

}  // namespace motiondb::server
