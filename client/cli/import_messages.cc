#include "client/cli/import_messages.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "client/cli/terminal/print.h"
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

namespace {

using Json = nlohmann::json;

std::string NumberText(const Json& value, const char* unit) {
  if (!value.is_number()) return "unknown";
  return fmt::format("{:.3g} {}", value.get<double>(), unit);
}

std::vector<Cell> PointRow(const Json& point, std::size_t depth) {
  constexpr std::size_t kMaxDepth = 40;
  const std::string role = point.value("role", "");
  const double missing = point.value("missing_fraction", 0.0);
  return {std::string(2 * std::min(depth, kMaxDepth), ' ') + point.value("name", ""), role,
          role.empty() ? Cell() : Cell(point.value("confidence", 0.0), 2),
          missing > 0 ? Cell(100 * missing, 1) : Cell()};
}

std::string PointsText(const Json& inspection) {
  const Json& points = inspection.at("points");
  std::vector<std::vector<int>> children(points.size());
  std::vector<int> roots;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const int parent = points[i].value("parent", -1);
    const bool has_parent = parent >= 0 && parent < static_cast<int>(i);  // parents come first
    (has_parent ? children[parent] : roots).push_back(static_cast<int>(i));
  }
  Table table({{inspection.value("points_are", "points")},
               {"BODY PART"},
               {"CONFIDENCE", Align::kRight},
               {"MISSING (%)", Align::kRight}});
  // Depth first, in the order of the file.
  std::vector<std::pair<int, std::size_t>> next;
  for (auto root = roots.rbegin(); root != roots.rend(); ++root) next.emplace_back(*root, 0);
  while (!next.empty()) {
    const auto [point, depth] = next.back();
    next.pop_back();
    table.AddRow(PointRow(points[static_cast<std::size_t>(point)], depth));
    const std::vector<int>& below = children[static_cast<std::size_t>(point)];
    for (auto child = below.rbegin(); child != below.rend(); ++child) {
      next.emplace_back(*child, depth + 1);
    }
  }
  return table.ToString();
}

void AppendList(const Json& inspection, const char* field, const char* title, std::string& text) {
  for (const Json& item : inspection.at(field)) {
    text += fmt::format("{:<12}{}\n", title, item.get<std::string>());
  }
}

// All takes of a file with several, and which one the rest is about.
std::string TakesText(const Json& inspection) {
  constexpr std::size_t kMaxShown = 100;
  const Json& takes = inspection.at("takes");
  const auto count = inspection.value("take_count", takes.size());
  std::string text;
  std::size_t shown = 0;
  for (const Json& take : takes) {
    if (++shown > kMaxShown) break;
    const std::string name = take.value("name", "");
    const bool is_inspected = name == inspection.value("take", "");
    text += fmt::format("{:<12}{}  {}{}\n", shown == 1 ? "takes" : "", name,
                        NumberText(take.at("duration_seconds"), "s"),
                        is_inspected ? "  (inspected here; --take chooses another)" : "");
  }
  const std::size_t listed = std::min(kMaxShown, takes.size());
  if (count > listed) text += fmt::format("{:<12}and {} more\n", "", count - listed);
  return text;
}

std::string SuggestedOptions(const Json& inspection) {
  std::string text;
  for (const Json& option : inspection.at("suggested_options")) {
    text += (text.empty() ? "" : " ") + option.get<std::string>();
  }
  return text;
}

}  // namespace

bool IsAccepted(const Json& inspection) {
  return !inspection.contains("error") && inspection.at("problems").empty();
}

std::string RejectionText(const Json& inspection) {
  if (inspection.contains("error")) return inspection.at("error").get<std::string>();
  if (inspection.at("problems").empty()) return "";
  return inspection.at("problems").front().get<std::string>();
}

std::string InspectionText(const Json& inspection) {
  if (inspection.contains("error")) {
    return fmt::format("{}\nunreadable  {}\n", inspection.value("file", ""),
                       RejectionText(inspection));
  }
  std::string text =
      fmt::format("{}\n\n{}\n", inspection.value("file", ""), PointsText(inspection));
  text += TakesText(inspection);
  text += fmt::format("unit        {:.4g} m ({})\n", inspection.value("metres_per_unit", 0.0),
                      inspection.value("metres_per_unit_is", ""));
  text += fmt::format("up axis     {} ({})\n", inspection.value("up_axis", ""),
                      inspection.value("up_axis_is", ""));
  text += fmt::format("duration    {}, {} at {:.5g} Hz\n",
                      NumberText(inspection.at("duration_seconds"), "s"),
                      CountText(inspection.value("frame_count", 0), "frame"),
                      inspection.value("frame_rate_hz", 0.0));
  text += fmt::format("leg length  {}\n", NumberText(inspection.at("leg_length_m"), "m"));
  text += fmt::format("stature     {}\n", NumberText(inspection.at("stature_m"), "m"));
  text += fmt::format("foot slide  {}\n", NumberText(inspection.at("foot_slide_m_per_s"), "m/s"));
  if (const std::string mapping = inspection.value("mapping", ""); !mapping.empty()) {
    text += fmt::format("mapping     {}\n", mapping);
  }
  AppendList(inspection, "reader_notes", "note", text);
  AppendList(inspection, "notes", "note", text);
  if (IsAccepted(inspection))
    return text + "plausible   yes: a database of standard34 would accept the file\n";
  AppendList(inspection, "problems", "problem", text);
  if (const std::string options = SuggestedOptions(inspection); !options.empty()) {
    text += fmt::format("try         {}\n", options);
  }
  return text;
}

std::string InspectionLine(const Json& inspection) {
  return fmt::format(
      "ok        {}: {}, {:.5g} Hz, leg {}, {}", inspection.value("file", ""),
      NumberText(inspection.at("duration_seconds"), "s"), inspection.value("frame_rate_hz", 0.0),
      NumberText(inspection.at("leg_length_m"), "m"), inspection.value("mapping", ""));
}

}  // namespace motiondb::client
