#include "motiondb/v1/store.grpc.pb.h"
#include "server/rpc/backup_store.h"
#include "server/rpc/call.h"
#include "server/rpc/restore_reactor.h"
#include "server/rpc/server_status.h"
#include "server/rpc/services.h"
#include "server/rpc/stream_reactor.h"
#include "server/rpc/verify_store.h"

namespace motiondb::server {
namespace {

class StoreServiceImpl final : public v1::StoreService::CallbackService {
 public:
  explicit StoreServiceImpl(CallHost& host) : host_(host) {}

  grpc::ServerUnaryReactor* GetServerStatus(grpc::CallbackServerContext* context,
                                            const v1::GetServerStatusRequest* request,
                                            v1::GetServerStatusResponse* response) override {
    return Answer<server::GetServerStatus>(host_, context, request, response);
  }
  grpc::ServerWriteReactor<v1::VerifyStoreResponse>* VerifyStore(
      grpc::CallbackServerContext* context, const v1::VerifyStoreRequest* request) override {
    return new StreamReactor<v1::VerifyStoreRequest, v1::VerifyStoreResponse>(host_, context,
                                                                              request, OpenVerify);
  }
  grpc::ServerWriteReactor<v1::BackupStoreResponse>* BackupStore(
      grpc::CallbackServerContext* context, const v1::BackupStoreRequest* request) override {
    return new StreamReactor<v1::BackupStoreRequest, v1::BackupStoreResponse>(host_, context,
                                                                              request, OpenBackup);
  }
  grpc::ServerReadReactor<v1::RestoreStoreRequest>* RestoreStore(
      grpc::CallbackServerContext* context, v1::RestoreStoreResponse* response) override {
    return NewRestoreReactor(host_, *context, *response);
  }

 private:
  CallHost& host_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeStoreService(CallHost& host) {
  return std::make_unique<StoreServiceImpl>(host);
}

}  // namespace motiondb::server
