#include "client/cli/plan_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "client/cli/resource_name.h"
#include "client/cli/terminal/print.h"
#include "text/display_text.h"

namespace motiondb::client {
namespace {

constexpr int kShownSegments = 8;
constexpr std::size_t kShownLimits = 3;

std::string SegmentsText(const v1::PlannedMotion& motion) {
  if (motion.segments_size() == 0) return "";  // made from node means
  std::string text = "plays ";
  for (int i = 0; i < std::min(motion.segments_size(), kShownSegments); ++i) {
    const v1::PlayedSegment& segment = motion.segments(i);
    text += fmt::format("{}{} {:.2f}-{:.2f} s", i > 0 ? ", " : "",
                        text::DisplayText(ShortName(segment.clip())), segment.start_seconds(),
                        segment.end_seconds());
  }
  if (motion.segments_size() > kShownSegments) {
    text += fmt::format(" and {} more", motion.segments_size() - kShownSegments);
  }
  return text + "\n";
}

// A row of the table: a quality value, its unit and its text.
struct QualityRow {
  const char* name;
  const char* unit;
  std::string (*text)(const v1::PlanQuality&);
};

const std::vector<QualityRow>& QualityRows() {
  static const std::vector<QualityRow> kRows = {
      {"distance from goal", "m",
       [](const auto& q) { return fmt::format("{:.3f}", q.position_error_m()); }},
      {"heading error", "rad",
       [](const auto& q) { return fmt::format("{:.3f}", q.heading_error_rad()); }},
      {"duration", "s", [](const auto& q) { return fmt::format("{:.2f}", q.duration_seconds()); }},
      {"length", "m", [](const auto& q) { return fmt::format("{:.2f}", q.length_m()); }},
      {"path correction", "m",
       [](const auto& q) { return fmt::format("{:.3f}", q.correction_m()); }},
      {"path rotation", "rad",
       [](const auto& q) { return fmt::format("{:.3f}", q.correction_heading_rad()); }},
      {"foot slide", "cm/s",
       [](const auto& q) { return fmt::format("{:.2f}", 100 * q.foot_slide_m_per_s()); }},
      {"floor penetration", "cm",
       [](const auto& q) { return fmt::format("{:.2f}", 100 * q.floor_penetration_m()); }},
      {"peak marker jerk", "m/s^3",
       [](const auto& q) { return fmt::format("{:.0f}", q.peak_marker_jerk_m_s3()); }},
      {"peak joint speed", "rad/s",
       [](const auto& q) { return fmt::format("{:.2f}", q.peak_joint_speed_rad_s()); }},
      {"peak joint jerk", "rad/s^3",
       [](const auto& q) { return fmt::format("{:.0f}", q.peak_joint_jerk_rad_s3()); }},
      {"joint limits exceeded", "",
       [](const auto& q) {
         return fmt::format("{}", q.joint_limit_violations() + q.joint_speed_violations() +
                                      q.joint_acceleration_violations());
       }},
      {"marker fit error (rms)", "m",
       [](const auto& q) { return fmt::format("{:.3f}", q.marker_fit_rms_m()); }},
      {"unlike stored motion", "",
       [](const auto& q) {
         return q.has_unknown_probability()
                    ? fmt::format("{:.2f} at {:.2f} s", q.unknown_probability(),
                                  q.unknown_at_seconds())
                    : std::string("-");
       }},
      {"smallest clearance", "m",
       [](const auto& q) {
         return q.has_smallest_clearance_m() ? fmt::format("{:.2f}", q.smallest_clearance_m())
                                             : std::string("-");
       }},
  };
  return kRows;
}

std::string QualityText(const std::vector<const v1::PlannedMotion*>& motions) {
  std::vector<Table::Column> columns = {{""}, {""}};
  for (size_t i = 0; i < motions.size(); ++i) {
    columns.push_back({motions.size() == 1 ? ""
                       : i == 0            ? "BEST"
                                           : std::to_string(i + 1),
                       Align::kRight});
  }
  Table table(columns);
  if (motions.size() > 1) {
    std::vector<Cell> row = {"  outcome", ""};
    for (const auto* motion : motions) row.push_back(OutcomeText(motion->outcome()));
    table.AddRow(row);
  }
  for (const QualityRow& value : QualityRows()) {
    std::vector<Cell> row = {std::string("  ") + value.name, value.unit};
    for (const auto* motion : motions) row.push_back(value.text(motion->quality()));
    table.AddRow(row);
  }
  return table.ToString();
}

// Returns the durations without and with joint limits, and a line for each of the most slowed
// parts.
std::string SlowedText(const v1::PlannedMotion& motion) {
  if (motion.slowed_parts_size() == 0) return "";
  std::vector<const v1::SlowedPart*> parts;
  for (const v1::SlowedPart& part : motion.slowed_parts()) parts.push_back(&part);
  std::stable_sort(parts.begin(), parts.end(),
                   [](const auto* a, const auto* b) { return a->factor() > b->factor(); });
  std::string text =
      fmt::format("slowed by joint limits from {:.2f} s to {:.2f} s\n",
                  motion.quality().stored_duration_seconds(), motion.quality().duration_seconds());
  for (std::size_t i = 0; i < std::min(parts.size(), kShownLimits); ++i) {
    const v1::SlowedPart& part = *parts[i];
    text += fmt::format("  {:.2f} times at {:.2f}-{:.2f} s by the {} of {}\n", part.factor(),
                        part.start_seconds(), part.end_seconds(),
                        part.limit() == v1::JOINT_LIMIT_ACCELERATION ? "acceleration" : "speed",
                        text::DisplayText(part.dof_name()));
  }
  if (parts.size() > kShownLimits) {
    text += fmt::format("  less in {} more parts\n", parts.size() - kShownLimits);
  }
  return text;
}

double ShareOfLimit(const v1::JointEffort& effort) {
  return effort.has_effort_limit() ? effort.peak_effort() / effort.effort_limit() : 0;
}

// Returns a line for each of the largest efforts relative to their limits, and one for the balance.
std::string ForcesText(const v1::PlannedMotion& motion) {
  std::vector<const v1::JointEffort*> efforts;
  for (const v1::JointEffort& effort : motion.joint_efforts()) {
    if (effort.has_effort_limit()) efforts.push_back(&effort);
  }
  std::stable_sort(efforts.begin(), efforts.end(), [](const auto* a, const auto* b) {
    return ShareOfLimit(*a) > ShareOfLimit(*b);
  });
  std::string text;
  for (std::size_t i = 0; i < std::min(efforts.size(), kShownLimits); ++i) {
    const v1::JointEffort& effort = *efforts[i];
    text += fmt::format("{} needs an effort of {:.3g} at {:.2f} s, limit {:.3g}\n",
                        text::DisplayText(effort.dof_name()), effort.peak_effort(),
                        effort.at_seconds(), effort.effort_limit());
  }
  if (motion.has_balance()) {
    const v1::Balance& balance = motion.balance();
    text += fmt::format(
        "zero-moment point {:.3f} m {} the soles at {:.2f} s, outside for {:.2f} of {:.2f} s\n",
        std::abs(balance.smallest_margin_m()),
        balance.smallest_margin_m() < 0 ? "outside" : "inside", balance.at_seconds(),
        balance.outside_seconds(), balance.supported_seconds());
  }
  return text;
}

std::string EffortText(const v1::PlanResponse& response) {
  const v1::SearchEffort& effort = response.effort();
  return fmt::format(
      "searched {} in {:.3f} s, {}{}; {:.3f} s including the motion; leg length {:.3f} m\n",
      CountText(effort.expansions(), "state"), effort.search_seconds(),
      CountText(effort.improvements(), "improvement"), effort.complete() ? ", search complete" : "",
      effort.total_seconds(), response.leg_length_m());
}

}  // namespace

std::string OutcomeText(v1::PlanOutcome outcome) {
  const std::string& name = v1::PlanOutcome_Name(outcome);
  if (name.empty()) return fmt::format("outcome {}", static_cast<int>(outcome));
  return name.substr(std::string_view("PLAN_OUTCOME_").size());
}

std::string PlanSummary(const v1::PlanQuality& quality) {
  std::string text = fmt::format("{:.2f} s, {:.2f} m, ends {:.3f} m and {:.3f} rad from the goal",
                                 quality.duration_seconds(), quality.length_m(),
                                 quality.position_error_m(), quality.heading_error_rad());
  if (quality.has_smallest_clearance_m()) {
    text += fmt::format(", clearance {:.2f} m", quality.smallest_clearance_m());
  }
  return text;
}

std::string PlanText(const v1::PlanResponse& response) {
  std::string text = OutcomeText(response.outcome());
  if (!response.missing().empty()) text += ": " + text::DisplayText(response.missing());
  text += "\n";
  if (response.has_motion()) {
    text += SegmentsText(response.motion());
    std::vector<const v1::PlannedMotion*> motions = {&response.motion()};
    for (const v1::PlannedMotion& other : response.alternatives()) motions.push_back(&other);
    text += QualityText(motions) + SlowedText(response.motion()) + ForcesText(response.motion());
  }
  return text + EffortText(response);
}

}  // namespace motiondb::client
