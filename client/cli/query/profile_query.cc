#include "client/cli/query/profile_query.h"

#include <motiondb/v1/query.pb.h>

#include <utility>

#include "client/cli/plot/recognition_plot_profile.h"

namespace motiondb::client {

absl::StatusOr<Canvas> AskForProfile(const Client& client, v1::RecognizeRequest request,
                                     const std::vector<int>& layers) {
  request.clear_top_count();
  request.clear_layer();
  request.set_method(v1::METHOD_PAPER);
  std::vector<v1::RecognizeResponse> responses;
  const auto ask = [&](int layer) {
    if (layer > 0) request.set_layer(layer);
    auto response = client.Recognize(request);
    if (!response.ok()) return response.status();
    responses.push_back(*std::move(response));
    return absl::OkStatus();
  };
  const bool is_default = layers.empty();
  absl::Status status = ask(is_default ? 0 : layers.front());
  std::vector<int> others;
  if (!is_default) {
    others.assign(layers.begin() + 1, layers.end());
  } else if (status.ok() && responses[0].windows_size() > 0) {
    others = PlottedLayers(responses[0].windows(0).layer());
  }
  for (const int layer : others) {
    if (status.ok()) status = ask(layer);
  }
  if (!status.ok()) return status;
  if (is_default) {
    request.clear_layer();
  } else {
    request.set_layer(layers.front());
  }
  return ProfilePicture(request, responses);
}

}  // namespace motiondb::client
