#include "client/cli/inspection_text.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <vector>

#include "client/cli/print.h"

namespace motiondb::client {
namespace {

using Json = nlohmann::json;

std::string NumberText(const Json& value, const char* unit) {
  if (!value.is_number()) return "unknown";
  return fmt::format("{:.3g} {}", value.get<double>(), unit);
}

// Appends the point and, below it, its children.
void AppendPointTree(const Json& points, const std::vector<std::vector<int>>& children, int point,
                     int depth, Table& table) {
  constexpr int kMaxDepth = 40;
  const Json& shown = points[point];
  const std::string role = shown.value("role", "");
  const double missing = shown.value("missing_fraction", 0.0);
  table.AddRow({std::string(2 * static_cast<std::size_t>(std::min(depth, kMaxDepth)), ' ') +
                    shown.value("name", ""),
                role, role.empty() ? "" : fmt::format("{:.2f}", shown.value("confidence", 0.0)),
                missing > 0 ? fmt::format("{:.1f} %", 100 * missing) : ""});
  for (const int child : children[point]) {
    AppendPointTree(points, children, child, depth + 1, table);
  }
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
               {"body part"},
               {"confidence", Align::kRight},
               {"missing", Align::kRight}});
  for (const int root : roots) AppendPointTree(points, children, root, 0, table);
  return table.ToString();
}

void AppendList(const Json& inspection, const char* field, const char* title, std::string& text) {
  for (const Json& item : inspection.at(field)) {
    text += fmt::format("{:<12}{}\n", title, item.get<std::string>());
  }
}

// Returns the options in the problems, such as "--up-axis z", without --force.
std::string SuggestedFlags(const Json& inspection) {
  std::string flags;
  for (const Json& item : inspection.at("problems")) {
    const auto problem = item.get<std::string>();
    for (std::size_t begin = 0; (begin = problem.find("(--", begin)) != std::string::npos;) {
      const std::size_t end = std::min(problem.find(')', begin), problem.size());
      const std::string flag = problem.substr(begin + 1, end - begin - 1);
      if (flag != "--force") flags += (flags.empty() ? "" : " ") + flag;
      begin = end;
    }
  }
  return flags;
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
  if (IsAccepted(inspection)) return text + "plausible   yes: ingest would accept the file\n";
  AppendList(inspection, "problems", "problem", text);
  if (const std::string flags = SuggestedFlags(inspection); !flags.empty()) {
    text += fmt::format("try         {}\n", flags);
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
