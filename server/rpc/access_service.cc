#include <charconv>

#include "core/motion/error.h"
#include "motiondb/v1/access.grpc.pb.h"
#include "server/engine/work/clock.h"
#include "server/rpc/call.h"
#include "server/rpc/services.h"
#include "server/translate/access_message.h"
#include "server/translate/message_fields.h"
#include "server/translate/page.h"
#include "server/translate/resource_name.h"
#include "text/display_text.h"

namespace motiondb::server {
namespace {

constexpr char kTokens[] = "tokens";
constexpr char kAuditEntries[] = "audit entries";

absl::Status CreateToken(const Call& call, const v1::CreateTokenRequest& request,
                         v1::CreateTokenResponse& response) {
  const std::int64_t now_us = NowMicroseconds();
  MOTIONDB_ASSIGN_OR_RETURN(const NewTokenSpec wanted, ParseCreateToken(request, now_us));
  if (!wanted.database.empty()) {
    MOTIONDB_RETURN_IF_ERROR(call.engine.FindDatabase(wanted.database).status());
  }
  const auto audit = [&](const storage::TokenRecord& token) {
    return call.entry.AuditRecordForChange(TokenName(token.id));
  };
  MOTIONDB_ASSIGN_OR_RETURN(
      const CreatedToken made,
      call.entry.access().tokens().Make(wanted.role, wanted.database, wanted.description, now_us,
                                        wanted.expire_time_us, audit, call.cancelled));
  SetToken(made.record, *response.mutable_token());
  response.set_secret(made.secret);
  return absl::OkStatus();
}

absl::Status ListTokens(const Call& call, const v1::ListTokensRequest& request,
                        v1::ListTokensResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const int size, PageSize(request.page_size(), 100, 1000));
  MOTIONDB_ASSIGN_OR_RETURN(const std::string after,
                            DecodePageToken(kTokens, request.page_token()));
  MOTIONDB_ASSIGN_OR_RETURN(const auto records,
                            call.entry.access().store().ListTokens(after, size + 1));
  response.set_next_page_token(FillPageFrom(records, size, kTokens, *response.mutable_tokens(),
                                            SetToken,
                                            [](const auto& record) { return record.id; }));
  return absl::OkStatus();
}

absl::Status RevokeToken(const Call& call, const v1::RevokeTokenRequest& request,
                         v1::RevokeTokenResponse& response) {
  const std::string name = text::RedactSecrets(request.name());
  if (name != request.name()) {
    return FieldViolation("name", "expected tokens/{{token}}, the id without the secret, got '{}'",
                          name);
  }
  MOTIONDB_ASSIGN_OR_RETURN(const std::string id, ParseTokenName("name", name));
  const auto audit = call.entry.AuditRecordForChange(name);
  MOTIONDB_ASSIGN_OR_RETURN(
      const auto record,
      call.entry.access().RevokeToken(id, NowMicroseconds(), {&audit, call.cancelled}));
  SetToken(record, *response.mutable_token());
  return absl::OkStatus();
}

absl::Status ListAuditEntries(const Call& call, const v1::ListAuditEntriesRequest& request,
                              v1::ListAuditEntriesResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const int size, PageSize(request.page_size(), 100, 1000));
  MOTIONDB_ASSIGN_OR_RETURN(const std::string token,
                            DecodePageToken(kAuditEntries, request.page_token()));
  std::int64_t before = 0;
  std::from_chars(token.data(), token.data() + token.size(), before);
  MOTIONDB_ASSIGN_OR_RETURN(const auto records,
                            call.entry.access().store().ListAuditRecords(before, size + 1));
  response.set_next_page_token(
      FillPageFrom(records, size, kAuditEntries, *response.mutable_entries(), SetAuditEntry,
                   [](const auto& record) { return std::to_string(record.sequence); }));
  return absl::OkStatus();
}

class AccessServiceImpl final : public v1::AccessService::CallbackService {
 public:
  explicit AccessServiceImpl(ServiceContext& host) : host_(host) {}

  grpc::ServerUnaryReactor* CreateToken(grpc::CallbackServerContext* context,
                                        const v1::CreateTokenRequest* request,
                                        v1::CreateTokenResponse* response) override {
    return Answer<server::CreateToken>(host_, context, request, response);
  }
  grpc::ServerUnaryReactor* ListTokens(grpc::CallbackServerContext* context,
                                       const v1::ListTokensRequest* request,
                                       v1::ListTokensResponse* response) override {
    return Answer<server::ListTokens>(host_, context, request, response);
  }
  grpc::ServerUnaryReactor* RevokeToken(grpc::CallbackServerContext* context,
                                        const v1::RevokeTokenRequest* request,
                                        v1::RevokeTokenResponse* response) override {
    return Answer<server::RevokeToken>(host_, context, request, response);
  }
  grpc::ServerUnaryReactor* ListAuditEntries(grpc::CallbackServerContext* context,
                                             const v1::ListAuditEntriesRequest* request,
                                             v1::ListAuditEntriesResponse* response) override {
    return Answer<server::ListAuditEntries>(host_, context, request, response);
  }

 private:
  ServiceContext& host_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeAccessService(ServiceContext& host) {
  return std::make_unique<AccessServiceImpl>(host);
}

}  // namespace motiondb::server
