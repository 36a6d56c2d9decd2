#include "tests/soak/broken_clients.h"

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <cstring>
#include <limits>
#include <thread>
#include <vector>

#include "motiondb/v1/clip.pb.h"
#include "motiondb/v1/observe.pb.h"
#include "motiondb/v1/query.pb.h"
#include "tests/support/stick_figure.h"

namespace motiondb::tests {
namespace {

using absl::StatusCode;
using boost::asio::ip::tcp;

std::string Noise(std::mt19937& random, std::size_t size) {
  std::string bytes(size, '\0');
  for (char& byte : bytes) byte = static_cast<char>(random());
  return bytes;
}

template <typename T>
absl::Status StatusOf(const absl::StatusOr<T>& result) {
  return result.status();
}

}  // namespace

void SendNoise(const std::string& address, std::mt19937& random) {
  constexpr std::string_view kGreeting = "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";
  boost::asio::io_context context;
  tcp::socket socket(context);
  boost::system::error_code error;
  const std::size_t colon = address.rfind(':');
  socket.connect({boost::asio::ip::make_address(address.substr(0, colon)),
                  static_cast<std::uint16_t>(std::stoi(address.substr(colon + 1)))},
                 error);
  if (error) return;
  std::string bytes;
  switch (random() % 5) {
    case 0:
      break;
    case 1:
      bytes = Noise(random, 1 + random() % 4096);
      break;
    case 2:
      bytes = std::string(kGreeting.substr(0, random() % kGreeting.size()));
      break;
    case 3:
      bytes = std::string(kGreeting) + Noise(random, 1 + random() % 4096);
      break;
    default:
      bytes = "GET /metrics HTTP/1.1\r\nHost: motiondb\r\n\r\n";
  }
  boost::asio::write(socket, boost::asio::buffer(bytes), error);
  if (random() % 2 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(random() % 500));
}

void IngestGarbage(const client::Client& client, std::mt19937& random, Tally& tally) {
  v1::IngestClipHeader header;
  header.set_parent("databases/soak");
  header.set_file_name("garbage.bvh");
  std::string bytes = Noise(random, random() % 10'000);
  if (random() % 2 == 0) {
    bytes = WriteBvh({});
    bytes.resize(bytes.size() / 2);
  }
  tally.Add("Ingest of garbage", StatusOf(client.IngestBytes(header, bytes)),
            {StatusCode::kInvalidArgument});
}

void SendInvalidQueries(const client::Client& client, std::mt19937& random, Tally& tally) {
  v1::RecognizeRequest question;
  question.set_database(random() % 2 == 0 ? "databases/nobody" : "databases/soak");
  v1::MarkerObservation& markers = *question.mutable_observation()->mutable_markers();
  markers.set_frame_rate_hz(random() % 2 == 0 ? 60 : std::numeric_limits<double>::quiet_NaN());
  markers.set_frame_count(static_cast<int>(random()));
  markers.set_positions(Noise(random, random() % 1000));
  tally.Add("Nonsense", StatusOf(client.Recognize(question)),
            {StatusCode::kInvalidArgument, StatusCode::kNotFound, StatusCode::kFailedPrecondition});
  v1::DeleteClipRequest gone;
  gone.set_name("databases/soak/clips/nobody");
  tally.Add("Nonsense", StatusOf(client.DeleteClip(gone)), {StatusCode::kNotFound});
}

void ObserveWithoutReading(const client::Client& client, const std::string& database,
                           const std::string& positions, int frame_count, int marker_count,
                           double seconds) {
  v1::ObserveStart start;
  start.set_database("databases/" + database);
  start.set_frame_rate_hz(60);
  client::ObserveStream stream = client.Observe(start);
  std::vector<float> frame(static_cast<std::size_t>(3 * marker_count));
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  const std::size_t width = frame.size() * sizeof(float);
  // Flow control would block a client that sends more than the server reads; this one disconnects.
  for (int f = 0; f < 50 && std::chrono::steady_clock::now() < end; ++f) {
    std::memcpy(frame.data(), positions.data() + static_cast<std::size_t>(f % frame_count) * width,
                width);
    if (!stream.Send(f, 1, frame)) break;
  }
  std::this_thread::sleep_until(end);
  stream.Cancel();
  stream.Finish().IgnoreError();
}

}  // namespace motiondb::tests
