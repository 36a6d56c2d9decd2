#include "tests/client/fake_server.h"

#include <grpcpp/grpcpp.h>
#include <motiondb/v1/access.grpc.pb.h>
#include <motiondb/v1/clip.grpc.pb.h>
#include <motiondb/v1/database.grpc.pb.h>
#include <motiondb/v1/edit.grpc.pb.h>
#include <motiondb/v1/marker_set.grpc.pb.h>
#include <motiondb/v1/model.grpc.pb.h>
#include <motiondb/v1/observe.grpc.pb.h>
#include <motiondb/v1/operation.grpc.pb.h>
#include <motiondb/v1/query.grpc.pb.h>
#include <motiondb/v1/segment.grpc.pb.h>
#include <motiondb/v1/server.grpc.pb.h>
#include <motiondb/v1/store.grpc.pb.h>
#include <motiondb/v1/view.grpc.pb.h>

#include <chrono>
#include <thread>
#include <utility>

namespace motiondb::tests {

v1::GetDatabaseResponse WithStatistics(const v1::DatabaseStatistics& statistics) {
  v1::GetDatabaseResponse response;
  *response.mutable_database()->mutable_statistics() = statistics;
  return response;
}
namespace {

using grpc::ServerContext;
using grpc::Status;
using grpc::StatusCode;

Status StatusOf(const FakeServer::Reply& reply) {
  if (reply.delay_milliseconds > 0) {
    std::this_thread::sleep_for(std::chrono::milliseconds(reply.delay_milliseconds));
  }
  return reply.code == 0
             ? Status::OK
             : Status(static_cast<StatusCode>(reply.code), reply.message, reply.details);
}

std::map<std::string, std::string> MetadataOf(const ServerContext& context) {
  std::map<std::string, std::string> headers;
  for (const auto& [name, value] : context.client_metadata()) {
    headers.emplace(std::string(name.data(), name.size()), std::string(value.data(), value.size()));
  }
  return headers;
}

template <typename Message>
void Fill(const FakeServer::Reply& reply, Message* message) {
  if (!reply.messages.empty()) message->ParseFromString(reply.messages.front());
}

template <typename Message>
void Stream(const FakeServer::Reply& reply, grpc::ServerWriter<Message>* writer) {
  for (const std::string& bytes : reply.messages) {
    Message message;
    message.ParseFromString(bytes);
    if (!writer->Write(message)) return;
  }
}

}  // namespace

#define MOTIONDB_FAKE_UNARY(Method)                                         \
  Status Method(ServerContext* context, const v1::Method##Request* request, \
                v1::Method##Response* response) override {                  \
    fake.Keep(#Method, request->SerializeAsString());                       \
    fake.KeepHeaders(#Method, MetadataOf(*context));                        \
    const auto reply = fake.Next(#Method);                                  \
    Fill(reply, response);                                                  \
    return StatusOf(reply);                                                 \
  }

#define MOTIONDB_FAKE_STREAM(Method)                                         \
  Status Method(ServerContext* context, const v1::Method##Request* request,  \
                grpc::ServerWriter<v1::Method##Response>* writer) override { \
    fake.Keep(#Method, request->SerializeAsString());                        \
    fake.KeepHeaders(#Method, MetadataOf(*context));                         \
    const auto reply = fake.Next(#Method);                                   \
    Stream(reply, writer);                                                   \
    return StatusOf(reply);                                                  \
  }

#define MOTIONDB_FAKE_UPLOAD(Method)                                                     \
  Status Method(ServerContext* context, grpc::ServerReader<v1::Method##Request>* reader, \
                v1::Method##Response* response) override {                               \
    fake.KeepHeaders(#Method, MetadataOf(*context));                                     \
    v1::Method##Request message;                                                         \
    while (reader->Read(&message)) fake.Keep(#Method, message.SerializeAsString());      \
    const auto reply = fake.Next(#Method);                                               \
    Fill(reply, response);                                                               \
    return StatusOf(reply);                                                              \
  }

struct FakeServer::Services {
  struct Databases : v1::DatabaseService::Service {
    explicit Databases(FakeServer& server) : fake(server) {}
    MOTIONDB_FAKE_UNARY(CreateDatabase)
    MOTIONDB_FAKE_UNARY(GetDatabase)
    MOTIONDB_FAKE_UNARY(ListDatabases)
    MOTIONDB_FAKE_UNARY(DeleteDatabase)
    MOTIONDB_FAKE_UNARY(ReprocessDatabase)
    MOTIONDB_FAKE_STREAM(WatchDatabase)
    FakeServer& fake;
  };

  struct MarkerSets : v1::MarkerSetService::Service {
    explicit MarkerSets(FakeServer& server) : fake(server) {}
    MOTIONDB_FAKE_UNARY(GetMarkerSet)
    MOTIONDB_FAKE_UNARY(AddMappings)
    MOTIONDB_FAKE_UNARY(DeleteMapping)
    FakeServer& fake;
  };

  struct Clips : v1::ClipService::Service {
    explicit Clips(FakeServer& server) : fake(server) {}
    MOTIONDB_FAKE_UPLOAD(IngestClip)
    MOTIONDB_FAKE_UNARY(GetClip)
    MOTIONDB_FAKE_UNARY(ListClips)
    MOTIONDB_FAKE_UNARY(UpdateClip)
    MOTIONDB_FAKE_UNARY(SearchClips)
    MOTIONDB_FAKE_UNARY(DeleteClip)
    MOTIONDB_FAKE_STREAM(ExportClip)
    MOTIONDB_FAKE_UNARY(GetSkeleton)
    MOTIONDB_FAKE_UNARY(ListSkeletons)
    FakeServer& fake;
  };

  struct Segments : v1::SegmentService::Service {
    explicit Segments(FakeServer& server) : fake(server) {}
    MOTIONDB_FAKE_UNARY(CreateSegment)
    MOTIONDB_FAKE_UNARY(UpdateSegment)
    MOTIONDB_FAKE_UNARY(DeleteSegment)
    MOTIONDB_FAKE_UNARY(ListSegments)
    FakeServer& fake;
  };

  struct Edits : v1::EditService::Service {
    explicit Edits(FakeServer& server) : fake(server) {}
    MOTIONDB_FAKE_UNARY(BatchEdit)
    MOTIONDB_FAKE_UNARY(ListEdits)
    MOTIONDB_FAKE_UNARY(UndoEdit)
    FakeServer& fake;
  };

  struct Models : v1::ModelService::Service {
    explicit Models(FakeServer& server) : fake(server) {}
    MOTIONDB_FAKE_UNARY(GetModel)
    MOTIONDB_FAKE_UNARY(ListModels)
    MOTIONDB_FAKE_UNARY(ListNodes)
    MOTIONDB_FAKE_UNARY(ListTransitions)
    MOTIONDB_FAKE_STREAM(ReadStates)
    FakeServer& fake;
  };

  struct Views : v1::ViewService::Service {
    explicit Views(FakeServer& server) : fake(server) {}
    MOTIONDB_FAKE_UNARY(GetFigure)
    MOTIONDB_FAKE_UNARY(GetNodePoses)
    MOTIONDB_FAKE_STREAM(ReadClipMotion)
    MOTIONDB_FAKE_STREAM(ReadStateMap)
    FakeServer& fake;
  };

  struct Queries : v1::QueryService::Service {
    explicit Queries(FakeServer& server) : fake(server) {}
    MOTIONDB_FAKE_UNARY(Recognize)
    MOTIONDB_FAKE_UNARY(Estimate)
    MOTIONDB_FAKE_UNARY(Predict)
    MOTIONDB_FAKE_UNARY(Plan)
    MOTIONDB_FAKE_STREAM(PredictSeries)
    MOTIONDB_FAKE_UNARY(Find)
    FakeServer& fake;
  };

  struct Observations : v1::ObserveService::Service {
    explicit Observations(FakeServer& server) : fake(server) {}
    MOTIONDB_FAKE_UNARY(Represent)
    FakeServer& fake;
  };

  struct Access : v1::AccessService::Service {
    explicit Access(FakeServer& server) : fake(server) {}
    MOTIONDB_FAKE_UNARY(CreateToken)
    MOTIONDB_FAKE_UNARY(ListTokens)
    MOTIONDB_FAKE_UNARY(RevokeToken)
    MOTIONDB_FAKE_UNARY(ListAuditEntries)
    FakeServer& fake;
  };

  struct Operations : v1::OperationService::Service {
    explicit Operations(FakeServer& server) : fake(server) {}
    MOTIONDB_FAKE_UNARY(GetOperation)
    MOTIONDB_FAKE_UNARY(ListOperations)
    MOTIONDB_FAKE_UNARY(WaitOperation)
    MOTIONDB_FAKE_UNARY(CancelOperation)
    FakeServer& fake;
  };

  struct Stores : v1::StoreService::Service {
    explicit Stores(FakeServer& server) : fake(server) {}
    MOTIONDB_FAKE_STREAM(BackupStore)
    MOTIONDB_FAKE_UPLOAD(RestoreStore)
    MOTIONDB_FAKE_STREAM(ExportDatabase)
    MOTIONDB_FAKE_UPLOAD(ImportDatabase)
    FakeServer& fake;
  };

  struct Server : v1::ServerService::Service {
    explicit Server(FakeServer& server) : fake(server) {}
    MOTIONDB_FAKE_UNARY(GetServerStatus)
    FakeServer& fake;
  };

  explicit Services(FakeServer& fake)
      : databases(fake),
        marker_sets(fake),
        clips(fake),
        segments(fake),
        edits(fake),
        models(fake),
        views(fake),
        queries(fake),
        observations(fake),
        operations(fake),
        access(fake),
        stores(fake),
        status(fake) {}

  Databases databases;
  MarkerSets marker_sets;
  Clips clips;
  Segments segments;
  Edits edits;
  Models models;
  Views views;
  Queries queries;
  Observations observations;
  Operations operations;
  Access access;
  Stores stores;
  Server status;
  std::unique_ptr<grpc::Server> server;
};

#undef MOTIONDB_FAKE_UNARY
#undef MOTIONDB_FAKE_STREAM
#undef MOTIONDB_FAKE_UPLOAD

FakeServer::FakeServer() {
  // gRPC may lose its port to another program between bind and listen; then try again.
  for (int tries = 0; tries < 5 && (services_ == nullptr || services_->server == nullptr);
       ++tries) {
    services_ = std::make_unique<Services>(*this);
    Listen();
  }
}

void FakeServer::Listen() {
  grpc::ServerBuilder builder;
  int port = 0;
  builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
  builder.RegisterService(&services_->databases);
  builder.RegisterService(&services_->marker_sets);
  builder.RegisterService(&services_->clips);
  builder.RegisterService(&services_->segments);
  builder.RegisterService(&services_->edits);
  builder.RegisterService(&services_->models);
  builder.RegisterService(&services_->views);
  builder.RegisterService(&services_->queries);
  builder.RegisterService(&services_->observations);
  builder.RegisterService(&services_->operations);
  builder.RegisterService(&services_->access);
  builder.RegisterService(&services_->stores);
  builder.RegisterService(&services_->status);
  services_->server = builder.BuildAndStart();
  address_ = "127.0.0.1:" + std::to_string(port);
}

FakeServer::~FakeServer() { services_->server->Shutdown(std::chrono::system_clock::now()); }

void FakeServer::Push(const std::string& rpc, Reply reply) {
  const std::lock_guard lock(mutex_);
  replies_[rpc].push_back(std::move(reply));
}

void FakeServer::Keep(const std::string& rpc, std::string request) {
  const std::lock_guard lock(mutex_);
  requests_[rpc].push_back(std::move(request));
}

void FakeServer::KeepHeaders(const std::string& rpc, Headers headers) {
  const std::lock_guard lock(mutex_);
  headers_[rpc].push_back(std::move(headers));
}

std::vector<FakeServer::Headers> FakeServer::HeadersOf(const std::string& rpc) const {
  const std::lock_guard lock(mutex_);
  const auto found = headers_.find(rpc);
  return found == headers_.end() ? std::vector<Headers>() : found->second;
}

FakeServer::Reply FakeServer::Next(const std::string& rpc) {
  const std::lock_guard lock(mutex_);
  std::vector<Reply>& replies = replies_[rpc];
  if (replies.empty()) return {StatusCode::UNIMPLEMENTED, rpc + " has no canned answer", "", {}};
  const Reply reply = replies.front();
  if (replies.size() > 1) replies.erase(replies.begin());
  return reply;
}

}  // namespace motiondb::tests
