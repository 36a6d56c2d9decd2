#include <motiondb/client.h>

#include "client/channel_credentials.h"
#include "client/connection.h"

namespace motiondb::client {
namespace {

absl::Status Check(const ClientOptions& options) {
  if (options.server.empty()) {
    return absl::InvalidArgumentError("ClientOptions::server is empty; expected HOST:PORT");
  }
  if (options.connect_timeout.count() <= 0 || options.call_timeout.count() <= 0) {
    return absl::InvalidArgumentError("ClientOptions: a timeout must be positive");
  }
  if (options.max_receive_bytes <= 0 || options.max_send_bytes <= 0) {
    return absl::InvalidArgumentError("ClientOptions: a message size must be positive");
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Client> Client::Connect(ClientOptions options) {
  if (const absl::Status status = Check(options); !status.ok()) return status;
  auto credentials = CredentialsFor(options);
  if (!credentials.ok()) return credentials.status();
  options.credentials = *std::move(credentials);
  auto connection = std::make_shared<const Connection>(std::move(options));
  if (const absl::Status status = connection->WaitUntilConnected(); !status.ok()) return status;
  return Client(std::move(connection));
}

Client::Client(std::shared_ptr<const Connection> connection) : connection_(std::move(connection)) {}
Client::Client(Client&&) noexcept = default;
Client& Client::operator=(Client&&) noexcept = default;
Client::~Client() = default;

// One line for each call that is a request and a response.
#define MOTIONDB_UNARY(Method, stub, Service)                                                   \
  absl::StatusOr<v1::Method##Response> Client::Method(const v1::Method##Request& request,       \
                                                      CallOptions options) const {              \
    return connection_->Call(*connection_->stub, &v1::Service::Stub::Method, request, options); \
  }

MOTIONDB_UNARY(CreateDatabase, databases, DatabaseService)
MOTIONDB_UNARY(GetDatabase, databases, DatabaseService)
MOTIONDB_UNARY(ListDatabases, databases, DatabaseService)
MOTIONDB_UNARY(DeleteDatabase, databases, DatabaseService)
MOTIONDB_UNARY(DescribeDatabase, databases, DatabaseService)

MOTIONDB_UNARY(GetClip, clips, ClipService)
MOTIONDB_UNARY(ListClips, clips, ClipService)
MOTIONDB_UNARY(DeleteClip, clips, ClipService)
MOTIONDB_UNARY(GetSkeleton, clips, ClipService)
MOTIONDB_UNARY(ListSkeletons, clips, ClipService)

MOTIONDB_UNARY(GetModel, models, ModelService)
MOTIONDB_UNARY(ListModels, models, ModelService)
MOTIONDB_UNARY(ListNodes, models, ModelService)
MOTIONDB_UNARY(ListTransitions, models, ModelService)

MOTIONDB_UNARY(Recognize, queries, QueryService)
MOTIONDB_UNARY(Estimate, queries, QueryService)
MOTIONDB_UNARY(Predict, queries, QueryService)
MOTIONDB_UNARY(Plan, queries, QueryService)

MOTIONDB_UNARY(GetOperation, operations, OperationService)
MOTIONDB_UNARY(ListOperations, operations, OperationService)
MOTIONDB_UNARY(CancelOperation, operations, OperationService)

MOTIONDB_UNARY(CreateToken, access, AccessService)
MOTIONDB_UNARY(ListTokens, access, AccessService)
MOTIONDB_UNARY(RevokeToken, access, AccessService)
MOTIONDB_UNARY(ListAuditEntries, access, AccessService)

MOTIONDB_UNARY(GetServerStatus, store, StoreService)

#undef MOTIONDB_UNARY

absl::Status Client::ReadStates(
    const v1::ReadStatesRequest& request,
    const std::function<absl::Status(const v1::ReadStatesResponse&)>& on_block,
    CallOptions options) const {
  return connection_->ReadStream(*connection_->models, &v1::ModelService::Stub::ReadStates, request,
                                 on_block, options);
}

absl::Status Client::PredictSeries(
    const v1::PredictSeriesRequest& request,
    const std::function<absl::Status(const v1::PredictSeriesResponse&)>& on_prediction,
    CallOptions options) const {
  return connection_->ReadStream(*connection_->queries, &v1::QueryService::Stub::PredictSeries,
                                 request, on_prediction, options);
}

}  // namespace motiondb::client
