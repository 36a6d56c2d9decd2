#include "core/motion/error.h"
#include "motiondb/v1/observe.grpc.pb.h"
#include "server/rpc/call.h"
#include "server/rpc/observe_reactor.h"
#include "server/rpc/query_subject.h"
#include "server/rpc/services.h"
#include "server/translate/observation.h"
#include "server/translate/observe_message.h"

namespace motiondb::server {
namespace {

absl::Status Represent(const Call& call, const v1::RepresentRequest& request,
                       v1::RepresentResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const QuerySubject subject,
                            FindSubject(call.engine, "database", request.database()));
  MOTIONDB_ASSIGN_OR_RETURN(const auto markers,
                            MarkersFrom("observation", request.observation(), call.engine,
                                        *subject.database, call.terms()));
  SetMarkers(markers, *response.mutable_markers());
  return absl::OkStatus();
}

class ObserveServiceImpl final : public v1::ObserveService::CallbackService {
 public:
  explicit ObserveServiceImpl(CallHost& host) : host_(host) {}

  grpc::ServerBidiReactor<v1::ObserveRequest, v1::ObserveResponse>* Observe(
      grpc::CallbackServerContext* context) override {
    return NewObserveReactor(host_, *context);
  }
  grpc::ServerUnaryReactor* Represent(grpc::CallbackServerContext* context,
                                      const v1::RepresentRequest* request,
                                      v1::RepresentResponse* response) override {
    return Answer<server::Represent>(host_, context, request, response);
  }

 private:
  CallHost& host_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeObserveService(CallHost& host) {
  return std::make_unique<ObserveServiceImpl>(host);
}

}  // namespace motiondb::server
