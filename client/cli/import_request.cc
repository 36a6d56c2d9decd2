#include "client/cli/import_request.h"

#include "text/utf8.h"

namespace motiondb::client {

absl::StatusOr<nlohmann::json> ImportRequest(const std::filesystem::path& file,
                                             const SourceOptions& source) {
  if (!text::IsUtf8(file.string())) {
    return absl::InvalidArgumentError("the name is not UTF-8 text");
  }
  nlohmann::json request = {{"file", file.string()}};
  const auto skeleton = SkeletonFor(file, source.skeleton);
  if (!skeleton.ok()) return skeleton.status();
  if (!skeleton->empty()) request["skeleton"] = skeleton->string();
  if (source.metres_per_unit > 0) request["metres_per_unit"] = source.metres_per_unit;
  if (source.frame_rate_hz > 0) request["frame_rate_hz"] = source.frame_rate_hz;
  if (source.leg_length_m > 0) request["leg_length_m"] = source.leg_length_m;
  if (!source.up_axis.empty()) request["up_axis"] = source.up_axis;
  if (!source.take.empty()) request["take"] = source.take;
  return request;
}

std::string LineOf(const nlohmann::json& request) {
  return request.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + '\n';
}

}  // namespace motiondb::client
