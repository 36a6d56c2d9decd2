#include <memory>
#include <utility>

#include "core/motion/error.h"
#include "motiondb/v1/segment.grpc.pb.h"
#include "server/filter/listing.h"
#include "server/rpc/edit_call.h"
#include "server/rpc/services.h"
#include "server/translate/annotation_message.h"
#include "server/translate/page.h"
#include "server/translate/resource_name.h"

namespace motiondb::server {
namespace {

absl::Status CreateSegment(const Call& call, const v1::CreateSegmentRequest& request,
                           v1::CreateSegmentResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const RequestedChange requested, ParseChange(request));
  MOTIONDB_ASSIGN_OR_RETURN(const auto edit,
                            MakeChange(call, requested, request.parent(), response));
  // The edit may also have removed the segment of the clip's label, and thereby changed the clip.
  for (const storage::EditedObject& object : edit.objects) {
    if (object.before || !object.after) continue;
    SetSegment(std::get<storage::SegmentRecord>(*object.after), *response.mutable_segment());
  }
  return absl::OkStatus();
}

absl::Status UpdateSegment(const Call& call, const v1::UpdateSegmentRequest& request,
                           v1::UpdateSegmentResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const RequestedChange requested, ParseChange(request));
  MOTIONDB_RETURN_IF_ERROR(
      MakeChange(call, requested, request.segment().name(), response).status());
  const auto& change = std::get<storage::SegmentChange>(requested.change);
  MOTIONDB_ASSIGN_OR_RETURN(const auto segment, call.engine.store().annotations().GetSegment(
                                                    requested.database, change.clip, change.id));
  SetSegment(segment, *response.mutable_segment());
  return absl::OkStatus();
}

absl::Status DeleteSegment(const Call& call, const v1::DeleteSegmentRequest& request,
                           v1::DeleteSegmentResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const RequestedChange requested, ParseChange(request));
  return MakeChange(call, requested, request.name(), response).status();
}

// The clip in the name of a parent; empty: all clips of the database.
absl::StatusOr<MemberId> ParseParent(const std::string& parent) {
  if (auto database = ParseDatabaseName("parent", parent); database.ok()) {
    return MemberId{*std::move(database), ""};
  }
  return ParseClipName("parent", parent);
}

absl::Status ListSegmentsPage(const Call& call, const v1::ListSegmentsRequest& request,
                              v1::ListSegmentsResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const MemberId parent, ParseParent(request.parent()));
  MOTIONDB_ASSIGN_OR_RETURN(const int size, PageSize(request.page_size(), 100, 1000));
  MOTIONDB_ASSIGN_OR_RETURN(const Filter filter,
                            Filter::Parse(request.filter(), FilterSubject::kSegments));
  MOTIONDB_ASSIGN_OR_RETURN(const ListOrder order,
                            ListOrder::Parse(request.order_by(), FilterSubject::kSegments));
  const std::string scope = fmt::format("{}?{}&{}", SegmentName(parent.database, parent.id, ""),
                                        filter.text(), order.Text());
  MOTIONDB_ASSIGN_OR_RETURN(const std::string after, DecodePageToken(scope, request.page_token()));
  MOTIONDB_ASSIGN_OR_RETURN(const auto live, call.engine.FindDatabase(parent.database));
  storage::AnnotationStore& store = call.engine.store().annotations();
  MOTIONDB_ASSIGN_OR_RETURN(const auto catalog, live->Catalog(store));
  MOTIONDB_ASSIGN_OR_RETURN(
      const ListedSegments listed,
      ListSegments(*catalog, parent.id, filter, order, {after, static_cast<std::size_t>(size) + 1},
                   call.cancelled));
  MOTIONDB_ASSIGN_OR_RETURN(
      const std::size_t taken,
      FillPageFromStore(listed.segments, size, *response.mutable_segments(),
                        [&](const ListedSegment& item, v1::Segment& message) -> absl::Status {
                          MOTIONDB_ASSIGN_OR_RETURN(
                              const auto record,
                              store.GetSegment(parent.database, item.clip->id, item.segment->id));
                          SetSegment(record, message);
                          return absl::OkStatus();
                        }));
  if (taken < listed.segments.size()) {
    const ListedSegment& last = listed.segments[taken - 1];
    response.set_next_page_token(EncodePageToken(scope, order.KeyOf(*last.clip, last.segment)));
  }
  response.set_total_count(static_cast<int>(listed.total_count));
  return absl::OkStatus();
}

class SegmentServiceImpl final : public v1::SegmentService::CallbackService {
 public:
  explicit SegmentServiceImpl(ServiceContext& host) : host_(host) {}

  grpc::ServerUnaryReactor* CreateSegment(grpc::CallbackServerContext* context,
                                          const v1::CreateSegmentRequest* request,
                                          v1::CreateSegmentResponse* response) override {
    return Answer<server::CreateSegment>(host_, context, request, response);
  }
  grpc::ServerUnaryReactor* UpdateSegment(grpc::CallbackServerContext* context,
                                          const v1::UpdateSegmentRequest* request,
                                          v1::UpdateSegmentResponse* response) override {
    return Answer<server::UpdateSegment>(host_, context, request, response);
  }
  grpc::ServerUnaryReactor* DeleteSegment(grpc::CallbackServerContext* context,
                                          const v1::DeleteSegmentRequest* request,
                                          v1::DeleteSegmentResponse* response) override {
    return Answer<server::DeleteSegment>(host_, context, request, response);
  }
  grpc::ServerUnaryReactor* ListSegments(grpc::CallbackServerContext* context,
                                         const v1::ListSegmentsRequest* request,
                                         v1::ListSegmentsResponse* response) override {
    return Answer<ListSegmentsPage>(host_, context, request, response);
  }

 private:
  ServiceContext& host_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeSegmentService(ServiceContext& host) {
  return std::make_unique<SegmentServiceImpl>(host);
}

}  // namespace motiondb::server
