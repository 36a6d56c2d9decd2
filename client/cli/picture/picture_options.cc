#include "client/cli/picture/picture_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "client/cli/plan_request.h"
#include "client/cli/plot/picture_file.h"
#include "client/cli/terminal/print.h"
#include "client/output_file.h"

namespace motiondb::client {

void AddOutOption(CLI::App& command, std::string& out) {
  command.add_option("--out", out, "Picture to write; the extension selects the format")
      ->type_name(kPictureFile)
      ->required();
}

absl::Status CheckOut(const std::string& out) {
  absl::Status status = CheckPictureFile("--out", out);
  return status.ok() ? CheckCanWrite({out}) : status;
}

absl::Status WriteOut(const std::string& out, const Canvas& picture, const GlobalOptions& global) {
  absl::Status status = WritePicture(out, picture);
  if (status.ok() && !global.json) PrintLine("wrote {}", out);
  return status;
}

namespace {

std::optional<MapAxes> ParseAxes(const std::string& text) {
  const auto numbers = ParseNumbers(text);
  if (!numbers || numbers->size() < 2 || numbers->size() > 3) return std::nullopt;
  MapAxes axes;
  for (const double number : *numbers) {
    if (number != 1 && number != 2 && number != 3) return std::nullopt;
    axes.push_back(static_cast<int>(number));
  }
  MapAxes sorted = axes;
  std::sort(sorted.begin(), sorted.end());
  const bool differ = std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end();
  return differ ? std::optional(axes) : std::nullopt;
}

}  // namespace

void AddMapOptions(CLI::App& command, MapOptions& options) {
  constexpr double kMinSize = 400, kMaxSize = 6000;
  command
      .add_option_function<std::string>(
          "--axes", [&options](const std::string& text) { options.axes = *ParseAxes(text); },
          "Principal axes to the right and upwards; three axes: an oblique view")
      ->type_name("A,B[,C]")
      ->check(CLI::Validator(
          [](const std::string& text) {
            return ParseAxes(text) ? std::string()
                                   : fmt::format(
                                         "expected two or three different axes of 1, 2 "
                                         "and 3, for example 1,3; got {}",
                                         text);
          },
          ""))
      ->default_str("1,2");
  command
      .add_option_function<std::string>(
          "--colour",
          [&options](const std::string& word) {
            options.colouring = word == "clip" ? MapColouring::kByClip : MapColouring::kByLabel;
          },
          "What the colours show")
      ->type_name("label|clip")
      ->check(CLI::IsMember({"label", "clip"}))
      ->default_str("label");
  command.add_option("--width", options.width, "Width of the picture in pixels")
      ->type_name("PIXELS")
      ->check(CLI::Range(kMinSize, kMaxSize))
      ->capture_default_str();
  command.add_option("--height", options.height, "Height of the picture in pixels")
      ->type_name("PIXELS")
      ->check(CLI::Range(kMinSize, kMaxSize))
      ->capture_default_str();
}

void AddMapLayerOption(CLI::App& command, int& layer) {
  command.add_option("--layer", layer, "Layer of the tree, from 1; else the bottom layer")
      ->type_name("N")
      ->check(PositiveNumber());
}

}  // namespace motiondb::client
