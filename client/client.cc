#include <fmt/format.h>
#include <motiondb/client.h>

#include <cstdint>
#include <cstring>
#include <utility>
#include <vector>

#include "client/channel_credentials.h"
#include "client/connection.h"

namespace motiondb::client {

namespace {

absl::Status Check(const ClientOptions& options) {
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
  const auto addresses = AddressesOf(options.server);
  if (!addresses.ok()) return addresses.status();
  auto credentials = CredentialsFor(options, *addresses);
  if (!credentials.ok()) return credentials.status();
  options.credentials = *std::move(credentials);
  auto connection = std::make_shared<const Connection>(options, *addresses);
  if (const absl::Status status = connection->WaitUntilConnected(); !status.ok()) return status;
  return Client(std::move(connection));
}

Client::Client(std::shared_ptr<const Connection> connection) : connection_(std::move(connection)) {}
Client::Client(Client&&) noexcept = default;
Client& Client::operator=(Client&&) noexcept = default;
Client::~Client() = default;

// Defines a unary call that only reads, or one that changes something: a change is not made again
// after a server may have begun it (Connection::Run).
#define MOTIONDB_UNARY(effect, Method, stub, Service)                                      \
  absl::StatusOr<v1::Method##Response> Client::Method(const v1::Method##Request& request,  \
                                                      CallOptions options) const {         \
    return connection_->Call(effect, &Endpoint::stub, &v1::Service::Stub::Method, request, \
                             options);                                                     \
  }
#define MOTIONDB_READ(Method, stub, Service) MOTIONDB_UNARY(Effect::kRead, Method, stub, Service)
#define MOTIONDB_CHANGE(Method, stub, Service) \
  MOTIONDB_UNARY(Effect::kChange, Method, stub, Service)

MOTIONDB_CHANGE(CreateDatabase, databases, DatabaseService)
MOTIONDB_READ(GetDatabase, databases, DatabaseService)
MOTIONDB_READ(ListDatabases, databases, DatabaseService)
MOTIONDB_CHANGE(DeleteDatabase, databases, DatabaseService)
MOTIONDB_CHANGE(ReprocessDatabase, databases, DatabaseService)

MOTIONDB_READ(GetMarkerSet, marker_sets, MarkerSetService)
MOTIONDB_CHANGE(AddMappings, marker_sets, MarkerSetService)
MOTIONDB_CHANGE(DeleteMapping, marker_sets, MarkerSetService)

MOTIONDB_CHANGE(UploadClip, clips, ClipService)
MOTIONDB_READ(GetClip, clips, ClipService)
MOTIONDB_READ(ListClips, clips, ClipService)
MOTIONDB_CHANGE(UpdateClip, clips, ClipService)
MOTIONDB_READ(SearchClips, clips, ClipService)
MOTIONDB_CHANGE(DeleteClip, clips, ClipService)
MOTIONDB_READ(GetSkeleton, clips, ClipService)
MOTIONDB_READ(ListSkeletons, clips, ClipService)

MOTIONDB_CHANGE(CreateSegment, segments, SegmentService)
MOTIONDB_CHANGE(UpdateSegment, segments, SegmentService)
MOTIONDB_CHANGE(DeleteSegment, segments, SegmentService)
MOTIONDB_READ(ListSegments, segments, SegmentService)

MOTIONDB_CHANGE(BatchEdit, edits, EditService)
MOTIONDB_READ(ListEdits, edits, EditService)
MOTIONDB_CHANGE(UndoEdit, edits, EditService)

MOTIONDB_READ(GetModel, models, ModelService)
MOTIONDB_READ(ListModels, models, ModelService)
MOTIONDB_READ(ListNodes, models, ModelService)
MOTIONDB_READ(ListTransitions, models, ModelService)

MOTIONDB_READ(GetFigure, views, ViewService)
MOTIONDB_READ(GetNodePoses, views, ViewService)

MOTIONDB_READ(Recognize, queries, QueryService)
MOTIONDB_READ(Estimate, queries, QueryService)
MOTIONDB_READ(Predict, queries, QueryService)
MOTIONDB_READ(Find, queries, QueryService)
MOTIONDB_READ(Plan, queries, QueryService)

MOTIONDB_READ(Represent, observations, ObserveService)
MOTIONDB_READ(ListStreams, observations, ObserveService)

MOTIONDB_READ(GetOperation, operations, OperationService)
MOTIONDB_READ(ListOperations, operations, OperationService)
MOTIONDB_CHANGE(CancelOperation, operations, OperationService)

MOTIONDB_CHANGE(CreateToken, access, AccessService)
MOTIONDB_READ(ListTokens, access, AccessService)
MOTIONDB_CHANGE(RevokeToken, access, AccessService)
MOTIONDB_READ(ListAuditEntries, access, AccessService)

MOTIONDB_READ(GetServerStatus, server, ServerService)

#undef MOTIONDB_CHANGE
#undef MOTIONDB_READ
#undef MOTIONDB_UNARY

absl::Status Client::ReadStates(
    const v1::ReadStatesRequest& request,
    const std::function<absl::Status(const v1::ReadStatesResponse&)>& on_block,
    CallOptions options) const {
  return connection_->ReadStream(&Endpoint::models, &v1::ModelService::Stub::ReadStates, request,
                                 on_block, options);
}

absl::Status Client::ReadClipMotion(
    const v1::ReadClipMotionRequest& request,
    const std::function<absl::Status(const v1::ReadClipMotionResponse&)>& on_block,
    CallOptions options) const {
  return connection_->ReadStream(&Endpoint::views, &v1::ViewService::Stub::ReadClipMotion, request,
                                 on_block, options);
}

absl::Status Client::ReadStateMap(
    const v1::ReadStateMapRequest& request,
    const std::function<absl::Status(const v1::ReadStateMapResponse&)>& on_part,
    CallOptions options) const {
  return connection_->ReadStream(&Endpoint::views, &v1::ViewService::Stub::ReadStateMap, request,
                                 on_part, options);
}

absl::Status Client::PredictSeries(
    const v1::PredictSeriesRequest& request,
    const std::function<absl::Status(const v1::PredictSeriesResponse&)>& on_prediction,
    CallOptions options) const {
  return connection_->ReadStream(&Endpoint::queries, &v1::QueryService::Stub::PredictSeries,
                                 request, on_prediction, options);
}

// Whole lists: one call for each page, until the server returns no page token.

namespace {

// `fetch` makes one call; `items` returns the repeated field of a page.
template <typename Item, typename Request, typename Fetch, typename Items>
absl::StatusOr<std::vector<Item>> AllPages(Request request, const Fetch& fetch,
                                           const Items& items) {
  if (!request.page_token().empty()) {
    return absl::InvalidArgumentError("page_token must be empty to read a whole list");
  }
  std::vector<Item> all;
  while (true) {
    auto page = fetch(request);
    if (!page.ok()) return page.status();
    for (Item& item : *items(*page)) all.push_back(std::move(item));
    // A repeated token would cause an endless loop.
    if (!page->next_page_token().empty() && page->next_page_token() == request.page_token()) {
      return absl::InternalError(
          fmt::format("the server returned the page token \"{}\" twice", request.page_token()));
    }
    request.set_page_token(page->next_page_token());
    if (request.page_token().empty()) return all;
  }
}

}  // namespace

absl::StatusOr<std::vector<v1::Database>> Client::AllDatabases(CallOptions options) const {
  return AllPages<v1::Database>(
      v1::ListDatabasesRequest(), [&](const auto& page) { return ListDatabases(page, options); },
      [](auto& page) { return page.mutable_databases(); });
}

absl::StatusOr<std::vector<v1::Token>> Client::AllTokens(CallOptions options) const {
  return AllPages<v1::Token>(
      v1::ListTokensRequest(), [&](const auto& page) { return ListTokens(page, options); },
      [](auto& page) { return page.mutable_tokens(); });
}

absl::StatusOr<std::vector<v1::Clip>> Client::AllClips(const v1::ListClipsRequest& request,
                                                       CallOptions options) const {
  return AllPages<v1::Clip>(
      request, [&](const auto& page) { return ListClips(page, options); },
      [](auto& page) { return page.mutable_clips(); });
}

absl::StatusOr<std::vector<v1::Segment>> Client::AllSegments(const v1::ListSegmentsRequest& request,
                                                             CallOptions options) const {
  return AllPages<v1::Segment>(
      request, [&](const auto& page) { return ListSegments(page, options); },
      [](auto& page) { return page.mutable_segments(); });
}

absl::StatusOr<std::vector<v1::Skeleton>> Client::AllSkeletons(
    const v1::ListSkeletonsRequest& request, CallOptions options) const {
  return AllPages<v1::Skeleton>(
      request, [&](const auto& page) { return ListSkeletons(page, options); },
      [](auto& page) { return page.mutable_skeletons(); });
}

absl::StatusOr<std::vector<v1::Model>> Client::AllModels(const v1::ListModelsRequest& request,
                                                         CallOptions options) const {
  return AllPages<v1::Model>(
      request, [&](const auto& page) { return ListModels(page, options); },
      [](auto& page) { return page.mutable_models(); });
}

absl::StatusOr<std::vector<v1::Node>> Client::AllNodes(const v1::ListNodesRequest& request,
                                                       CallOptions options) const {
  return AllPages<v1::Node>(
      request, [&](const auto& page) { return ListNodes(page, options); },
      [](auto& page) { return page.mutable_nodes(); });
}

absl::StatusOr<std::vector<v1::Transition>> Client::AllTransitions(
    const v1::ListTransitionsRequest& request, CallOptions options) const {
  return AllPages<v1::Transition>(
      request, [&](const auto& page) { return ListTransitions(page, options); },
      [](auto& page) { return page.mutable_transitions(); });
}

absl::StatusOr<std::vector<v1::Operation>> Client::AllOperations(
    const v1::ListOperationsRequest& request, CallOptions options) const {
  return AllPages<v1::Operation>(
      request, [&](const auto& page) { return ListOperations(page, options); },
      [](auto& page) { return page.mutable_operations(); });
}

// Waiting for an operation: repeated long polls until it is done.

namespace {

using std::chrono::milliseconds;

// Time between two progress reports.
constexpr milliseconds kPollTime{500};
// A poll that takes longer than this beyond kPollTime fails.
constexpr milliseconds kPollGrace{30'000};

}  // namespace

absl::StatusOr<v1::Operation> Client::WaitOperation(
    const std::string& name, const std::function<void(const v1::Operation&)>& on_progress,
    CallOptions options) const {
  const auto start = std::chrono::steady_clock::now();
  const milliseconds limit = options.timeout.value_or(kNoTimeout);
  while (true) {
    const auto waited =
        std::chrono::duration_cast<milliseconds>(std::chrono::steady_clock::now() - start);
    if (waited >= limit) {
      return absl::DeadlineExceededError(fmt::format("{} did not end within {:g} s", name,
                                                     std::chrono::duration<double>(limit).count()));
    }
    const milliseconds poll = std::min(kPollTime, limit - waited);
    v1::WaitOperationRequest request;
    request.set_name(name);
    request.mutable_timeout()->set_seconds(poll.count() / 1000);
    request.mutable_timeout()->set_nanos(static_cast<int>(poll.count() % 1000) * 1'000'000);
    auto response = connection_->Call(Effect::kRead, &Endpoint::operations,
                                      &v1::OperationService::Stub::WaitOperation, request,
                                      CallOptions{.timeout = poll + kPollGrace});
    if (!response.ok()) return response.status();
    if (on_progress) on_progress(response->operation());
    if (IsDone(response->operation())) return std::move(*response->mutable_operation());
  }
}

std::vector<float> UnpackFloats(const std::string& bytes) {
  std::vector<float> values(bytes.size() / sizeof(float));
  for (size_t i = 0; i < values.size(); ++i) {
    std::uint32_t bits = 0;
    for (size_t b = 0; b < sizeof(float); ++b) {
      bits |= std::uint32_t{static_cast<unsigned char>(bytes[sizeof(float) * i + b])} << (8 * b);
    }
    std::memcpy(&values[i], &bits, sizeof(float));
  }
  return values;
}

bool IsDone(const v1::Operation& operation) {
  return operation.state() == v1::OPERATION_STATE_SUCCEEDED ||
         operation.state() == v1::OPERATION_STATE_FAILED ||
         operation.state() == v1::OPERATION_STATE_CANCELLED;
}

const std::string& ModelOf(const v1::Operation& operation) {
  return operation.has_reprocess() ? operation.reprocess().model() : operation.rebuild().model();
}

absl::Status OperationStatus(const v1::Operation& operation) {
  switch (operation.state()) {
    case v1::OPERATION_STATE_SUCCEEDED:
      return absl::OkStatus();
    case v1::OPERATION_STATE_CANCELLED:
      return absl::CancelledError(fmt::format("{} was cancelled", operation.name()));
    case v1::OPERATION_STATE_FAILED: {
      const int code = operation.error().code();
      return absl::Status(
          code == 0 ? absl::StatusCode::kUnknown : static_cast<absl::StatusCode>(code),
          fmt::format("{} failed: {}", operation.name(), operation.error().message()));
    }
    default:
      return absl::FailedPreconditionError(fmt::format("{} has not ended", operation.name()));
  }
}

}  // namespace motiondb::client
