#include "core/format/marker_set_file.h"
#include "core/motion/error.h"
#include "motiondb/v1/marker_set.grpc.pb.h"
#include "server/engine/marker_schemes.h"
#include "server/engine/request_checks.h"
#include "server/rpc/call.h"
#include "server/rpc/services.h"
#include "server/translate/message_fields.h"
#include "server/translate/resource_name.h"
#include "text/display_text.h"

namespace motiondb::server {
namespace {

constexpr std::size_t kMaxNameBytes = 1000;

// The resource of an audit entry; "*": several mappings.
std::string MappingName(const std::string& database, const std::string& mapping) {
  return fmt::format("{}/mappings/{}", DatabaseName(database), mapping);
}

void SetMapping(const core::MarkerSet& set, const core::MarkerMapping& mapping,
                v1::Mapping& message) {
  message.set_name(text::ValidUtf8(mapping.name));
  for (const std::string& name : mapping.signature) message.add_signature(text::ValidUtf8(name));
  message.set_text(text::ValidUtf8(core::WriteMapping(set, mapping)));
}

void SetMarkerSet(const core::MarkerScheme& scheme, v1::MarkerSet& message) {
  message.set_name(text::ValidUtf8(scheme.set.name));
  for (const std::string& name : scheme.set.markers) {
    message.add_marker_names(text::ValidUtf8(name));
  }
  const core::MarkerScheme without_mappings{scheme.set, scheme.default_rules, {}};
  message.set_text(text::ValidUtf8(core::WriteMarkerSetFile(without_mappings)));
  for (const core::MarkerMapping& mapping : scheme.mappings) {
    SetMapping(scheme.set, mapping, *message.add_mappings());
  }
}

absl::Status GetMarkerSet(const Call& call, const v1::GetMarkerSetRequest& request,
                          v1::GetMarkerSetResponse& response) {
  if (request.database().empty()) {
    SetMarkerSet(core::StandardScheme(), *response.mutable_marker_set());
    return absl::OkStatus();
  }
  MOTIONDB_ASSIGN_OR_RETURN(const std::string id,
                            ParseDatabaseName("database", request.database()));
  MOTIONDB_ASSIGN_OR_RETURN(const auto live, call.engine.FindDatabase(id));
  MOTIONDB_ASSIGN_OR_RETURN(const auto scheme, live->scheme());
  if (scheme == nullptr) return NoMarkerSet(id);
  SetMarkerSet(*scheme, *response.mutable_marker_set());
  return absl::OkStatus();
}

absl::Status AddMappings(const Call& call, const v1::AddMappingsRequest& request,
                         v1::AddMappingsResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::string id,
                            ParseDatabaseName("database", request.database()));
  MOTIONDB_RETURN_IF_ERROR(CheckPlainLines("mapping_file", request.mapping_file()));
  storage::AuditRecord audit = call.entry.AuditRecordForChange(request.database());
  const auto add = [&](const core::MarkerScheme& before) -> absl::StatusOr<core::MarkerScheme> {
    auto added = core::ReadMappings({"mapping_file", request.mapping_file()}, before);
    if (!added.ok()) return AtField("mapping_file", added.status());
    response.clear_mappings();
    for (const auto& mapping : *added) SetMapping(before.set, mapping, *response.add_mappings());
    audit.resource = MappingName(id, added->size() == 1 ? added->front().name : "*");
    return WithMappings(before, *std::move(added));
  };
  return call.engine.ChangeMarkerScheme(id, add, {&audit, call.cancelled});
}

absl::Status DeleteMapping(const Call& call, const v1::DeleteMappingRequest& request,
                           v1::DeleteMappingResponse&) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::string id,
                            ParseDatabaseName("database", request.database()));
  if (request.mapping().empty()) return FieldViolation("mapping", "is missing");
  MOTIONDB_RETURN_IF_ERROR(CheckPlainText("mapping", request.mapping(), kMaxNameBytes));
  const auto remove = [&](const core::MarkerScheme& before) {
    return WithoutMapping(before, request.mapping());
  };
  const auto audit = call.entry.AuditRecordForChange(MappingName(id, request.mapping()));
  return call.engine.ChangeMarkerScheme(id, remove, {&audit, call.cancelled});
}

class MarkerSetServiceImpl final : public v1::MarkerSetService::CallbackService {
 public:
  explicit MarkerSetServiceImpl(ServiceContext& host) : host_(host) {}

  grpc::ServerUnaryReactor* GetMarkerSet(grpc::CallbackServerContext* context,
                                         const v1::GetMarkerSetRequest* request,
                                         v1::GetMarkerSetResponse* response) override {
    return Answer<server::GetMarkerSet>(host_, context, request, response);
  }
  grpc::ServerUnaryReactor* AddMappings(grpc::CallbackServerContext* context,
                                        const v1::AddMappingsRequest* request,
                                        v1::AddMappingsResponse* response) override {
    return Answer<server::AddMappings>(host_, context, request, response);
  }
  grpc::ServerUnaryReactor* DeleteMapping(grpc::CallbackServerContext* context,
                                          const v1::DeleteMappingRequest* request,
                                          v1::DeleteMappingResponse* response) override {
    return Answer<server::DeleteMapping>(host_, context, request, response);
  }

 private:
  ServiceContext& host_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeMarkerSetService(ServiceContext& host) {
  return std::make_unique<MarkerSetServiceImpl>(host);
}

}  // namespace motiondb::server
