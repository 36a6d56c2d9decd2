#include "client/cli/plot/recognition_plot_areas.h"

#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

#include "client/cli/plot/recognition_plot_layout.h"

namespace motiondb::client {

namespace {

// Maps columns and shares of the frame to coordinates.
class ColumnFrame {
 public:
  ColumnFrame(const std::vector<AnswerColumn>& columns, const TimeAxis& time_axis,
              const PictureFrame& frame)
      : columns_(columns), time_axis_(time_axis), frame_(frame) {}

  std::size_t size() const { return columns_.size(); }
  double Left(std::size_t i) const { return X(columns_[i].cell.start); }
  double Right(std::size_t i) const { return X(columns_[i].cell.end); }
  double Y(double share) const { return frame_.bottom() - frame_.height * share; }

 private:
  double X(double seconds) const { return time_axis_.X(frame_, seconds); }

  const std::vector<AnswerColumn>& columns_;
  const TimeAxis& time_axis_;
  const PictureFrame& frame_;
};

// The area between two shares in each column. Columns where it has no height are left out.
std::vector<Outline> AreaBetween(const ColumnFrame& columns, const std::vector<double>& low,
                                 const std::vector<double>& high) {
  constexpr double kMinShare = 0.001;
  std::vector<Outline> area;
  for (std::size_t begin = 0, end = 0; begin < columns.size(); begin = end) {
    end = begin + 1;
    if (high[begin] - low[begin] < kMinShare) continue;
    while (end < columns.size() && high[end] - low[end] >= kMinShare) ++end;
    Outline& outline = area.emplace_back(Outline{{}, true});
    outline.points.push_back({columns.Left(begin), columns.Y(low[begin])});
    for (std::size_t i = begin; i < end; ++i) {
      outline.points.push_back({columns.Left(i), columns.Y(high[i])});
      outline.points.push_back({columns.Right(i), columns.Y(high[i])});
    }
    for (std::size_t i = end; i-- > begin;) {
      outline.points.push_back({columns.Right(i), columns.Y(low[i])});
      outline.points.push_back({columns.Left(i), columns.Y(low[i])});
    }
  }
  return area;
}

// An area of the picture, its style and its name.
struct NamedArea {
  std::string style;
  std::string name;
  std::vector<Outline> outlines;
};

}  // namespace

bool DrawProbabilityAreas(Canvas& canvas, const RecognitionAnswer& answer,
                          const std::vector<bool>& drawn, const TimeAxis& time_axis,
                          const PictureFrame& frame) {
  const ColumnFrame columns(answer.columns, time_axis, frame);
  const std::size_t count = columns.size();
  std::vector<double> low(count), high(count), others(count);
  std::vector<NamedArea> areas;
  for (std::size_t label = 0; label < drawn.size(); ++label) {
    for (std::size_t i = 0; i < count; ++i) {
      (drawn[label] ? high : others)[i] += answer.columns[i].probabilities[label];
    }
    if (!drawn[label]) continue;
    areas.push_back({"label " + LabelAreaStyle(static_cast<int>(label)), answer.labels[label].name,
                     AreaBetween(columns, low, high)});
    low = high;
  }
  for (std::size_t i = 0; i < count; ++i) high[i] += others[i];
  areas.push_back({"others", "other labels", AreaBetween(columns, low, high)});
  for (std::size_t i = 0; i < count; ++i) low[i] = 1 - answer.columns[i].unknown;
  areas.push_back(
      {"unknown", "unknown", AreaBetween(columns, low, std::vector<double>(count, 1.0))});
  bool any = false;
  canvas.BeginGroup();
  for (NamedArea& area : areas) {
    if (area.outlines.empty()) continue;
    canvas.Path(area.style, std::move(area.outlines)).tooltip = area.name;
    any = true;
  }
  canvas.EndGroup();
  return any;
}

void DrawFamiliarity(Canvas& canvas, const RecognitionAnswer& answer, const TimeAxis& time_axis,
                     const PictureFrame& frame) {
  const ColumnFrame columns(answer.columns, time_axis, frame);
  std::vector<Outline> lines;
  bool is_gap = true;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const double familiarity = answer.columns[i].familiarity;
    const bool was_gap = std::exchange(is_gap, !std::isfinite(familiarity));
    if (is_gap) continue;
    if (was_gap) lines.emplace_back();
    lines.back().points.push_back({columns.Left(i), columns.Y(familiarity)});
    lines.back().points.push_back({columns.Right(i), columns.Y(familiarity)});
  }
  if (lines.empty()) return;
  canvas.BeginGroup();
  canvas.Path("familiarity", std::move(lines));
  canvas.EndGroup();
}

void AddTooltips(Canvas& canvas, const RecognitionAnswer& answer, const TimeAxis& time_axis,
                 const PictureFrame& frame) {
  canvas.BeginGroup();
  for (const AnswerColumn& column : answer.columns) {
    const double left = time_axis.X(frame, column.cell.start);
    canvas.HoverArea({left, frame.top, time_axis.X(frame, column.cell.end) - left, frame.height},
                     column.tooltip);
  }
  canvas.EndGroup();
}

void AddAreaStyles(Canvas& canvas) {
  canvas.AddStyle("label", {.crisp = true});
  canvas.AddStyle("others", {.fill = "#e4e4e4", .crisp = true});
  canvas.AddStyle("unknown", {.fill = "#777", .pattern = FillPattern::kHatching, .crisp = true});
  canvas.AddStyle("familiarity", {.fill = "none", .stroke = "#222", .stroke_width = 1.6});
}

}  // namespace motiondb::client
