#include <algorithm>
#include <memory>
#include <utility>

#include "core/motion/error.h"
#include "motiondb/v1/clip.grpc.pb.h"
#include "server/engine/query/export_clip.h"
#include "server/filter/listing.h"
#include "server/rpc/edit_call.h"
#include "server/rpc/services.h"
#include "server/rpc/stream_reactor.h"
#include "server/translate/file_format.h"
#include "server/translate/page.h"
#include "server/translate/record_messages.h"
#include "server/translate/resource_name.h"
#include "text/utf8.h"

namespace motiondb::server {
namespace {

constexpr std::size_t kSentBlockBytes = std::size_t{1} << 20;
// Number of skeletons in one read of a list: one may have a megabyte, and two fill a page.
constexpr int kSkeletonsPerRead = 8;

// Sets the stored clip. NOT_FOUND.
absl::Status SetStoredClip(const Call& call, const std::string& database, const std::string& clip,
                           v1::Clip& message) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto record, call.engine.store().GetClip(database, clip));
  SetClip(record, message);
  return absl::OkStatus();
}

absl::Status GetClip(const Call& call, const v1::GetClipRequest& request,
                     v1::GetClipResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const MemberId id, ParseClipName("name", request.name()));
  return SetStoredClip(call, id.database, id.id, *response.mutable_clip());
}

void SetFacet(const Facet& facet, v1::Facet& message) {
  message.set_field(facet.field);
  for (const FacetValue& value : facet.values) {
    v1::FacetValue& count = *message.add_values();
    count.set_value(value.value);
    count.set_clip_count(value.clip_count);
  }
}

absl::Status ListClipsPage(const Call& call, const v1::ListClipsRequest& request,
                           v1::ListClipsResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::string id, ParseDatabaseName("parent", request.parent()));
  MOTIONDB_ASSIGN_OR_RETURN(const int size, PageSize(request.page_size(), 100, 1000));
  MOTIONDB_ASSIGN_OR_RETURN(const Filter filter,
                            Filter::Parse(request.filter(), FilterSubject::kClips));
  MOTIONDB_ASSIGN_OR_RETURN(const ListOrder order,
                            ListOrder::Parse(request.order_by(), FilterSubject::kClips));
  MOTIONDB_ASSIGN_OR_RETURN(const auto facets,
                            ParseFacets({request.facets().begin(), request.facets().end()}));
  const std::string scope = fmt::format("{}?{}&{}", ClipName(id, ""), filter.text(), order.Text());
  MOTIONDB_ASSIGN_OR_RETURN(const std::string after, DecodePageToken(scope, request.page_token()));
  MOTIONDB_ASSIGN_OR_RETURN(const auto live, call.engine.FindDatabase(id));
  MOTIONDB_ASSIGN_OR_RETURN(const auto catalog, live->Catalog(call.engine.store().annotations()));
  MOTIONDB_ASSIGN_OR_RETURN(
      const ListedClips listed,
      ListClips(*catalog, filter, order, {after, static_cast<std::size_t>(size) + 1}, facets,
                call.cancelled));
  MOTIONDB_ASSIGN_OR_RETURN(const std::size_t taken,
                            FillPageFromStore(listed.clips, size, *response.mutable_clips(),
                                              [&](const CatalogClip* clip, v1::Clip& message) {
                                                return SetStoredClip(call, id, clip->id, message);
                                              }));
  if (taken < listed.clips.size()) {
    response.set_next_page_token(EncodePageToken(scope, order.KeyOf(*listed.clips[taken - 1])));
  }
  response.set_total_count(static_cast<int>(listed.total_count));
  for (const Facet& facet : listed.facets) SetFacet(facet, *response.add_facets());
  return absl::OkStatus();
}

absl::Status SearchClips(const Call& call, const v1::SearchClipsRequest& request,
                         v1::SearchClipsResponse& response) {
  constexpr std::size_t kMaxQueryBytes = 1000;
  MOTIONDB_ASSIGN_OR_RETURN(const std::string id, ParseDatabaseName("parent", request.parent()));
  if (request.query().size() > kMaxQueryBytes) {
    return core::FieldViolation("query", "expected at most {} bytes, got {}", kMaxQueryBytes,
                                request.query().size());
  }
  MOTIONDB_ASSIGN_OR_RETURN(const int size, PageSize(request.page_size(), 100, 1000));
  MOTIONDB_ASSIGN_OR_RETURN(const Filter filter,
                            Filter::Parse(request.filter(), FilterSubject::kClips));
  MOTIONDB_ASSIGN_OR_RETURN(const auto facets,
                            ParseFacets({request.facets().begin(), request.facets().end()}));
  const std::string scope =
      fmt::format("{}?{}&{}", ClipName(id, ""), filter.text(), request.query());
  MOTIONDB_ASSIGN_OR_RETURN(const std::string after, DecodePageToken(scope, request.page_token()));
  MOTIONDB_ASSIGN_OR_RETURN(const auto live, call.engine.FindDatabase(id));
  auto matches = call.engine.store().annotations().SearchClips(id, request.query());
  if (!matches.ok()) return core::AtField("query", matches.status());
  MOTIONDB_ASSIGN_OR_RETURN(const auto catalog, live->Catalog(call.engine.store().annotations()));
  std::vector<FacetCounter> counters(facets.begin(), facets.end());
  std::vector<storage::TextMatch> passing;
  for (storage::TextMatch& match : *matches) {
    const CatalogClip* const clip = catalog->Find(match.clip);
    if (clip == nullptr || !filter.Passes(*clip)) continue;
    for (FacetCounter& counter : counters) counter.Add(*clip);
    passing.push_back(std::move(match));
  }
  for (const FacetCounter& counter : counters) SetFacet(counter.Counts(), *response.add_facets());
  // Best first; equal scores in order of name, so that pages continue each other.
  std::ranges::sort(passing, [](const auto& a, const auto& b) {
    return a.score != b.score ? a.score > b.score : a.clip < b.clip;
  });
  auto next = passing.begin();
  if (!after.empty()) {
    next = std::ranges::find(passing, after, &storage::TextMatch::clip);
    if (next == passing.end()) {
      return core::FieldViolation(
          "page_token", "the last clip of the former page no longer matches; search again");
    }
    ++next;
  }
  response.set_total_count(static_cast<int>(passing.size()));
  const std::vector<storage::TextMatch> rest(next, passing.end());
  MOTIONDB_ASSIGN_OR_RETURN(
      const std::size_t taken,
      FillPageFromStore(rest, size, *response.mutable_matches(),
                        [&](const storage::TextMatch& match, v1::ClipMatch& message) {
                          message.set_score(match.score);
                          return SetStoredClip(call, id, match.clip, *message.mutable_clip());
                        }));
  if (taken < rest.size()) {
    response.set_next_page_token(EncodePageToken(scope, rest[taken - 1].clip));
  }
  return absl::OkStatus();
}

absl::Status UpdateClip(const Call& call, const v1::UpdateClipRequest& request,
                        v1::UpdateClipResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const RequestedChange requested, ParseChange(request));
  MOTIONDB_RETURN_IF_ERROR(MakeChange(call, requested, request.clip().name(), response).status());
  return SetStoredClip(call, requested.database,
                       std::get<storage::ClipChange>(requested.change).clip,
                       *response.mutable_clip());
}

absl::Status DeleteClip(const Call& call, const v1::DeleteClipRequest& request,
                        v1::DeleteClipResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const MemberId id, ParseClipName("name", request.name()));
  const auto audit = call.entry.AuditRecordForChange(request.name());
  MOTIONDB_ASSIGN_OR_RETURN(const auto operation,
                            call.engine.DeleteClip(id.database, id.id, {&audit, call.cancelled}));
  SetOperation(operation, *response.mutable_operation());
  return absl::OkStatus();
}

absl::Status GetSkeleton(const Call& call, const v1::GetSkeletonRequest& request,
                         v1::GetSkeletonResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const MemberId id, ParseSkeletonName("name", request.name()));
  MOTIONDB_ASSIGN_OR_RETURN(auto skeleton, call.engine.store().GetSkeleton(id.database, id.id));
  SetSkeleton(id.database, {id.id, std::move(skeleton)}, *response.mutable_skeleton());
  return absl::OkStatus();
}

absl::Status ListSkeletons(const Call& call, const v1::ListSkeletonsRequest& request,
                           v1::ListSkeletonsResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::string id, ParseDatabaseName("parent", request.parent()));
  MOTIONDB_ASSIGN_OR_RETURN(const int size, PageSize(request.page_size(), 100, 1000));
  const std::string scope = SkeletonName(id, "");
  MOTIONDB_ASSIGN_OR_RETURN(std::string after, DecodePageToken(scope, request.page_token()));
  MOTIONDB_RETURN_IF_ERROR(call.engine.FindDatabase(id).status());
  MOTIONDB_ASSIGN_OR_RETURN(
      *response.mutable_next_page_token(),
      FillPageByReads(
          std::move(after), size, scope, *response.mutable_skeletons(),
          [&](const std::string& last) {
            return call.engine.store().ListSkeletons(id, {last, kSkeletonsPerRead});
          },
          [&](const auto& record, v1::Skeleton& skeleton) { SetSkeleton(id, record, skeleton); },
          [](const auto& record) { return record.id; }));
  return absl::OkStatus();
}

// Copies the next block of `bytes` from `begin` to `block` and advances `begin`. False at the end.
bool TakeBlock(const std::string& bytes, std::size_t& begin, std::string& block) {
  if (begin == bytes.size()) return false;
  block.assign(bytes, begin, kSentBlockBytes);
  begin += block.size();
  return true;
}

// Returns the ingested files, or one in another format, and sets the rest of the header.
absl::StatusOr<storage::ClipSource> ExportedFiles(const Call& call,
                                                  const storage::ClipRecord& record,
                                                  v1::FileFormat format,
                                                  v1::ExportClipHeader& header) {
  if (format == v1::FILE_FORMAT_UNSPECIFIED) {
    header.set_file_name(record.file_name);
    header.set_skeleton_file_name(record.skeleton_file_name);
    return call.engine.store().ReadClipSource(record.database, record.id);
  }
  MOTIONDB_ASSIGN_OR_RETURN(const core::FileFormat parsed, ParseFormat("format", format));
  // A long clip may use as much memory as a long request.
  MOTIONDB_RETURN_IF_ERROR(call.entry.ReserveFile(static_cast<std::size_t>(record.byte_count)));
  MOTIONDB_ASSIGN_OR_RETURN(ExportedMotion exported,
                            ExportMotion(call.engine, record, parsed, call.work_options()));
  header.set_file_name(exported.file_name);
  for (const std::string& note : exported.notes) header.add_notes(text::ValidUtf8(note));
  return storage::ClipSource{std::move(exported.bytes), ""};
}

absl::StatusOr<MessageSource<v1::ExportClipResponse>> OpenExport(
    const Call& call, const v1::ExportClipRequest& request) {
  MOTIONDB_ASSIGN_OR_RETURN(const MemberId id, ParseClipName("name", request.name()));
  MOTIONDB_ASSIGN_OR_RETURN(auto record, call.engine.store().GetClip(id.database, id.id));
  v1::ExportClipHeader header;
  SetClip(record, *header.mutable_clip());
  MOTIONDB_ASSIGN_OR_RETURN(storage::ClipSource source,
                            ExportedFiles(call, record, request.format(), header));
  MOTIONDB_RETURN_IF_ERROR(
      call.entry.ReserveFile(source.file_bytes.size() + source.skeleton_bytes.size()));
  struct State {
    v1::ExportClipHeader header;
    storage::ClipSource source;
    bool header_sent = false;
    std::size_t file_begin = 0;
    std::size_t skeleton_begin = 0;
  };
  auto state = std::make_shared<State>(State{std::move(header), std::move(source)});
  return [state](v1::ExportClipResponse& message) -> absl::StatusOr<bool> {
    if (!std::exchange(state->header_sent, true)) {
      *message.mutable_header() = std::move(state->header);
      return true;
    }
    std::string block;
    if (TakeBlock(state->source.file_bytes, state->file_begin, block)) {
      message.set_file_block(std::move(block));
      return true;
    }
    if (TakeBlock(state->source.skeleton_bytes, state->skeleton_begin, block)) {
      message.set_skeleton_block(std::move(block));
      return true;
    }
    return false;
  };
}

class ClipServiceImpl final : public v1::ClipService::CallbackService {
 public:
  explicit ClipServiceImpl(ServiceContext& host) : host_(host) {}

  grpc::ServerReadReactor<v1::IngestClipRequest>* IngestClip(
      grpc::CallbackServerContext* context, v1::IngestClipResponse* response) override {
    return NewIngestReactor(host_, *context, *response);
  }
  grpc::ServerUnaryReactor* UploadClip(grpc::CallbackServerContext* context,
                                       const v1::UploadClipRequest* request,
                                       v1::UploadClipResponse* response) override {
    return NewUploadClipReactor(host_, *context, *request, *response);
  }
  grpc::ServerUnaryReactor* GetClip(grpc::CallbackServerContext* context,
                                    const v1::GetClipRequest* request,
                                    v1::GetClipResponse* response) override {
    return Answer<server::GetClip>(host_, context, request, response);
  }
  grpc::ServerUnaryReactor* ListClips(grpc::CallbackServerContext* context,
                                      const v1::ListClipsRequest* request,
                                      v1::ListClipsResponse* response) override {
    return Answer<ListClipsPage>(host_, context, request, response);
  }
  grpc::ServerUnaryReactor* UpdateClip(grpc::CallbackServerContext* context,
                                       const v1::UpdateClipRequest* request,
                                       v1::UpdateClipResponse* response) override {
    return Answer<server::UpdateClip>(host_, context, request, response);
  }
  grpc::ServerUnaryReactor* SearchClips(grpc::CallbackServerContext* context,
                                        const v1::SearchClipsRequest* request,
                                        v1::SearchClipsResponse* response) override {
    return Answer<server::SearchClips>(host_, context, request, response);
  }
  grpc::ServerUnaryReactor* DeleteClip(grpc::CallbackServerContext* context,
                                       const v1::DeleteClipRequest* request,
                                       v1::DeleteClipResponse* response) override {
    return Answer<server::DeleteClip>(host_, context, request, response);
  }
  grpc::ServerWriteReactor<v1::ExportClipResponse>* ExportClip(
      grpc::CallbackServerContext* context, const v1::ExportClipRequest* request) override {
    return new StreamReactor<v1::ExportClipRequest, v1::ExportClipResponse>(host_, context, request,
                                                                            OpenExport);
  }
  grpc::ServerUnaryReactor* GetSkeleton(grpc::CallbackServerContext* context,
                                        const v1::GetSkeletonRequest* request,
                                        v1::GetSkeletonResponse* response) override {
    return Answer<server::GetSkeleton>(host_, context, request, response);
  }
  grpc::ServerUnaryReactor* ListSkeletons(grpc::CallbackServerContext* context,
                                          const v1::ListSkeletonsRequest* request,
                                          v1::ListSkeletonsResponse* response) override {
    return Answer<server::ListSkeletons>(host_, context, request, response);
  }

 private:
  ServiceContext& host_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeClipService(ServiceContext& host) {
  return std::make_unique<ClipServiceImpl>(host);
}

}  // namespace motiondb::server
