#include "tests/bench/connect_client.h"

#include <google/protobuf/util/json_util.h>

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>

#include "core/motion/error.h"

namespace motiondb::tests {
namespace {
namespace beast = boost::beast;
namespace http = beast::http;
using boost::asio::ip::tcp;

class ConnectClient final : public LoadClient {
 public:
  ConnectClient(const std::string& url, ConnectCodec codec,
                const std::vector<v1::RecognizeRequest>& requests, std::size_t first)
      : host_(url.substr(url.find("//") + 2)), codec_(codec), requests_(requests), next_(first) {
    const std::size_t colon = host_.rfind(':');
    tcp::resolver resolver(context_);
    const auto addresses =
        resolver.resolve(host_.substr(0, colon), host_.substr(colon + 1), failure_);
    if (!failure_) boost::asio::connect(socket_, addresses, failure_);
    if (!failure_) socket_.set_option(tcp::no_delay(true), failure_);
  }

  absl::Status Ask() override {
    if (failure_) return absl::UnavailableError(failure_.message());
    const v1::RecognizeRequest& asked = requests_[next_++ % requests_.size()];
    http::request<http::string_body> request(http::verb::post,
                                             "/motiondb.v1.QueryService/Recognize", 11);
    request.set(http::field::host, host_);
    request.set(http::field::content_type, IsJson() ? "application/json" : "application/proto");
    request.set("connect-protocol-version", "1");
    if (!IsJson()) {
      request.body() = asked.SerializeAsString();
    } else if (!google::protobuf::util::MessageToJsonString(asked, &request.body()).ok()) {
      return absl::InternalError("the request is no JSON");
    }
    request.prepare_payload();
    http::write(socket_, request, failure_);
    http::response<http::string_body> response;
    if (!failure_) http::read(socket_, buffer_, response, failure_);
    if (failure_) return absl::UnavailableError(failure_.message());
    if (response.result() != http::status::ok) {
      return core::InvalidArgument("HTTP {}: {}", response.result_int(), response.body());
    }
    answer_.Clear();
    const bool parsed =
        IsJson() ? google::protobuf::util::JsonStringToMessage(response.body(), &answer_).ok()
                 : answer_.ParseFromString(response.body());
    return parsed ? absl::OkStatus() : absl::InternalError("the answer cannot be parsed");
  }
  std::string Reply() const override { return answer_.SerializeAsString(); }

 private:
  bool IsJson() const { return codec_ == ConnectCodec::kJson; }

  const std::string host_;  // HOST:PORT
  const ConnectCodec codec_;
  const std::vector<v1::RecognizeRequest>& requests_;
  std::size_t next_;
  boost::asio::io_context context_;
  tcp::socket socket_{context_};
  beast::flat_buffer buffer_;
  beast::error_code failure_;
  v1::RecognizeResponse answer_;
};

}  // namespace

std::unique_ptr<LoadClient> NewConnectClient(const std::string& url, ConnectCodec codec,
                                             const std::vector<v1::RecognizeRequest>& requests,
                                             std::size_t first) {
  return std::make_unique<ConnectClient>(url, codec, requests, first);
}

}  // namespace motiondb::tests
