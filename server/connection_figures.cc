#include "server/connection_figures.h"

#include <google/protobuf/struct.pb.h>
#include <google/protobuf/util/json_util.h>
#include <grpc/grpc.h>
#include <grpc/support/alloc.h>

#include <memory>

#include "absl/strings/escaping.h"
#include "absl/strings/numbers.h"

namespace motiondb::server {
namespace {

using google::protobuf::Struct;
using google::protobuf::Value;

constexpr std::intptr_t kPage = 500;

// Of what a function of channelz returned, which is freed. Empty where there is nothing.
Struct Parse(char* json) {
  const std::unique_ptr<char, decltype(&gpr_free)> text(json, gpr_free);
  Struct parsed;
  if (json == nullptr || !google::protobuf::util::JsonStringToMessage(json, &parsed).ok()) {
    parsed.Clear();
  }
  return parsed;
}

// Empty where the field is not there.
const Value& Field(const Struct& in, const char* name) {
  const auto field = in.fields().find(name);
  return field == in.fields().end() ? Value::default_instance() : field->second;
}

const Struct& Part(const Struct& in, const char* name) { return Field(in, name).struct_value(); }

// Numbers of 64 bits are text in JSON; one that is 0 is left out.
std::int64_t Number(const Struct& in, const char* name) {
  std::int64_t number = 0;
  return absl::SimpleAtoi(Field(in, name).string_value(), &number) ? number : 0;
}

// All 0 where the connection has ended meanwhile.
ConnectionFigures FiguresOf(std::int64_t id) {
  const Struct answer = Parse(grpc_channelz_get_socket(static_cast<std::intptr_t>(id)));
  const Struct& socket = Part(answer, "socket");
  const Struct& client = Part(Part(socket, "remote"), "tcpip_address");
  ConnectionFigures figures;
  figures.id = id;
  absl::Base64Unescape(Field(client, "ip_address").string_value(), &figures.address);
  figures.port = static_cast<int>(Field(client, "port").number_value());
  const Struct& calls = Part(socket, "data");
  figures.kept_calls = Number(calls, "streamsStarted") - Number(calls, "streamsSucceeded") -
                       Number(calls, "streamsFailed");
  return figures;
}

void ListConnectionsOf(std::int64_t server, std::vector<ConnectionFigures>& connections) {
  for (std::int64_t next = 0;;) {
    const Struct page = Parse(grpc_channelz_get_server_sockets(
        static_cast<std::intptr_t>(server), static_cast<std::intptr_t>(next), kPage));
    for (const Value& reference : Field(page, "socketRef").list_value().values()) {
      const std::int64_t id = Number(reference.struct_value(), "socketId");
      connections.push_back(FiguresOf(id));
      next = id + 1;
    }
    if (Field(page, "end").bool_value() || !page.fields().contains("socketRef")) return;
  }
}

}  // namespace

std::int64_t CountUnansweredCalls() {
  std::int64_t count = 0;
  const Struct answer = Parse(grpc_channelz_get_servers(0));
  for (const Value& server : Field(answer, "server").list_value().values()) {
    const Struct& calls = Part(server.struct_value(), "data");
    count += Number(calls, "callsStarted") - Number(calls, "callsSucceeded");
  }
  return count;
}

std::vector<ConnectionFigures> ListConnections() {
  std::vector<ConnectionFigures> connections;
  const Struct answer = Parse(grpc_channelz_get_servers(0));
  for (const Value& server : Field(answer, "server").list_value().values()) {
    ListConnectionsOf(Number(Part(server.struct_value(), "ref"), "serverId"), connections);
  }
  return connections;
}

}  // namespace motiondb::server
