#include "motiondb/v1/store.grpc.pb.h"
#include "server/rpc/call.h"
#include "server/rpc/server_status.h"
#include "server/rpc/services.h"

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

 private:
  CallHost& host_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeStoreService(CallHost& host) {
  return std::make_unique<StoreServiceImpl>(host);
}

}  // namespace motiondb::server
