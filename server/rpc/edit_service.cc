#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/motion/error.h"
#include "motiondb/v1/edit.grpc.pb.h"
#include "server/rpc/edit_call.h"
#include "server/rpc/services.h"
#include "server/translate/annotation_message.h"
#include "server/translate/annotation_request.h"
#include "server/translate/page.h"
#include "server/translate/resource_name.h"

namespace motiondb::server {
namespace {

// Number of edits in one read of a list: one may have a thousand objects of a kilobyte each.
constexpr int kEditsPerRead = 8;

absl::Status BatchEdit(const Call& call, const v1::BatchEditRequest& request,
                       v1::BatchEditResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::string id, ParseDatabaseName("parent", request.parent()));
  MOTIONDB_ASSIGN_OR_RETURN(const auto changes, ParseChanges(id, request));
  const auto audit = call.entry.AuditRecordForChange(request.parent());
  MOTIONDB_ASSIGN_OR_RETURN(
      const Edited edited,
      call.engine.Edit(id, changes, audit.principal, {&audit, call.cancelled}, EditFields::kBatch));
  SetEdit(edited.edit, *response.mutable_edit());
  SetEdited(call, edited, response);
  return absl::OkStatus();
}

absl::Status ListEdits(const Call& call, const v1::ListEditsRequest& request,
                       v1::ListEditsResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::string id, ParseDatabaseName("parent", request.parent()));
  std::string clip;
  if (!request.clip().empty()) {
    MOTIONDB_ASSIGN_OR_RETURN(const MemberId member, ParseClipName("clip", request.clip()));
    if (member.database != id) {
      return core::FieldViolation("clip", "expected a clip of database '{}', got one of '{}'", id,
                                  member.database);
    }
    clip = member.id;
  }
  MOTIONDB_ASSIGN_OR_RETURN(const int size, PageSize(request.page_size(), 100, 1000));
  const std::string scope = fmt::format("edits of {} in {}", clip, id);
  MOTIONDB_ASSIGN_OR_RETURN(std::string after, DecodePageToken(scope, request.page_token()));
  MOTIONDB_RETURN_IF_ERROR(call.engine.FindDatabase(id).status());
  const auto read =
      [&](const std::string& last) -> absl::StatusOr<std::vector<storage::EditRecord>> {
    std::int64_t before = 0;
    if (!last.empty()) {
      MOTIONDB_ASSIGN_OR_RETURN(const EditId edit, ParseEditName("page_token", last));
      before = edit.id;
    }
    return call.engine.store().annotations().ListEdits(id, clip, before, kEditsPerRead);
  };
  MOTIONDB_ASSIGN_OR_RETURN(
      *response.mutable_next_page_token(),
      FillPageByReads(std::move(after), size, scope, *response.mutable_edits(), read, SetEdit,
                      [](const auto& record) { return EditName(record.database, record.id); }));
  return absl::OkStatus();
}

absl::Status UndoEdit(const Call& call, const v1::UndoEditRequest& request,
                      v1::UndoEditResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const EditId id, ParseEditName("name", request.name()));
  const auto audit = call.entry.AuditRecordForChange(request.name());
  MOTIONDB_ASSIGN_OR_RETURN(
      const Edited edited,
      call.engine.UndoEdit(id.database, id.id, audit.principal, {&audit, call.cancelled}));
  SetEdit(edited.edit, *response.mutable_edit());
  SetEdited(call, edited, response);
  return absl::OkStatus();
}

class EditServiceImpl final : public v1::EditService::CallbackService {
 public:
  explicit EditServiceImpl(ServiceContext& host) : host_(host) {}

  grpc::ServerUnaryReactor* BatchEdit(grpc::CallbackServerContext* context,
                                      const v1::BatchEditRequest* request,
                                      v1::BatchEditResponse* response) override {
    return Answer<server::BatchEdit>(host_, context, request, response);
  }
  grpc::ServerUnaryReactor* ListEdits(grpc::CallbackServerContext* context,
                                      const v1::ListEditsRequest* request,
                                      v1::ListEditsResponse* response) override {
    return Answer<server::ListEdits>(host_, context, request, response);
  }
  grpc::ServerUnaryReactor* UndoEdit(grpc::CallbackServerContext* context,
                                     const v1::UndoEditRequest* request,
                                     v1::UndoEditResponse* response) override {
    return Answer<server::UndoEdit>(host_, context, request, response);
  }

 private:
  ServiceContext& host_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeEditService(ServiceContext& host) {
  return std::make_unique<EditServiceImpl>(host);
}

}  // namespace motiondb::server
