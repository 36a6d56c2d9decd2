// The HTTP/2 session of a connection: libnghttp2 with its options and its callbacks, which hand
// headers and data to the connection's streams. Lives on the connection's thread.
#pragma once

#include <nghttp2/nghttp2.h>

#include <memory>

namespace motiondb::server {

class Connection;

using Session = std::unique_ptr<nghttp2_session, decltype(&nghttp2_session_del)>;

// Of a server, which acknowledges what it took by nghttp2_session_consume. The connection outlives
// it. Throws std::bad_alloc.
Session NewSession(Connection& connection);

}  // namespace motiondb::server
