#include "client/cli/plot/recognition_plot_areas.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <utility>

#include "client/cli/plot/recognition_plot_labels.h"

namespace motiondb::client {

namespace {

// Maps columns and shares of the frame to coordinates.
class ColumnFrame {
 public:
  ColumnFrame(const std::vector<AnswerColumn>& columns, const TimeAxis& time_axis,
              const PictureFrame& frame)
      : columns_(columns), time_axis_(time_axis), frame_(frame) {}

  std::size_t size() const { return columns_.size(); }
  std::string Left(std::size_t i) const { return X(columns_[i].cell.start); }
  std::string Right(std::size_t i) const { return X(columns_[i].cell.end); }
  std::string Y(double share) const { return SvgNumber(frame_.bottom() - frame_.height * share); }

 private:
  std::string X(double seconds) const { return SvgNumber(time_axis_.X(frame_, seconds)); }

  const std::vector<AnswerColumn>& columns_;
  const TimeAxis& time_axis_;
  const PictureFrame& frame_;
};

// The area between two shares in each column. Columns where it has no height are left out.
std::string AreaSvg(const ColumnFrame& columns, const std::string& style, const std::string& title,
                    const std::vector<double>& low, const std::vector<double>& high) {
  constexpr double kMinShare = 0.001;
  std::string data;
  for (std::size_t begin = 0, end = 0; begin < columns.size(); begin = end) {
    end = begin + 1;
    if (high[begin] - low[begin] < kMinShare) continue;
    while (end < columns.size() && high[end] - low[end] >= kMinShare) ++end;
    data += fmt::format("M{} {}", columns.Left(begin), columns.Y(low[begin]));
    for (std::size_t i = begin; i < end; ++i) {
      data += fmt::format("V{}H{}", columns.Y(high[i]), columns.Right(i));
    }
    for (std::size_t i = end; i-- > begin;) {
      data += fmt::format("V{}H{}", columns.Y(low[i]), columns.Left(i));
    }
    data += "Z";
  }
  if (data.empty()) return "";
  return fmt::format("<path class=\"{}\" d=\"{}\"><title>{}</title></path>\n", style, data,
                     SvgText(title));
}

}  // namespace

std::string ProbabilityAreasSvg(const RecognitionAnswer& answer, const std::vector<bool>& drawn,
                                const TimeAxis& time_axis, const PictureFrame& frame) {
  const ColumnFrame columns(answer.columns, time_axis, frame);
  const std::size_t count = columns.size();
  std::vector<double> low(count), high(count), others(count);
  std::string svg;
  for (std::size_t label = 0; label < drawn.size(); ++label) {
    for (std::size_t i = 0; i < count; ++i) {
      (drawn[label] ? high : others)[i] += answer.columns[i].probabilities[label];
    }
    if (!drawn[label]) continue;
    svg += AreaSvg(columns, "label " + LabelAreaStyle(static_cast<int>(label)),
                   answer.labels[label].name, low, high);
    low = high;
  }
  for (std::size_t i = 0; i < count; ++i) high[i] += others[i];
  svg += AreaSvg(columns, "others", "other labels", low, high);
  for (std::size_t i = 0; i < count; ++i) low[i] = 1 - answer.columns[i].unknown;
  svg += AreaSvg(columns, "unknown", "unknown", low, std::vector<double>(count, 1.0));
  return svg.empty() ? "" : "<g>\n" + svg + "</g>\n";
}

std::string FamiliaritySvg(const RecognitionAnswer& answer, const TimeAxis& time_axis,
                           const PictureFrame& frame) {
  const ColumnFrame columns(answer.columns, time_axis, frame);
  std::string data;
  bool is_gap = true;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const double familiarity = answer.columns[i].familiarity;
    const bool was_gap = std::exchange(is_gap, !std::isfinite(familiarity));
    if (is_gap) continue;
    data += was_gap ? fmt::format("M{} ", columns.Left(i)) : "V";
    data += fmt::format("{}H{}", columns.Y(familiarity), columns.Right(i));
  }
  if (data.empty()) return "";
  return fmt::format("<g><path class=\"familiarity\" d=\"{}\"/></g>\n", data);
}

std::string TooltipsSvg(const RecognitionAnswer& answer, const TimeAxis& time_axis,
                        const PictureFrame& frame) {
  std::string svg;
  for (const AnswerColumn& column : answer.columns) {
    const double left = time_axis.X(frame, column.cell.start);
    svg += fmt::format("<g><title>{}</title>\n", SvgText(column.tooltip)) +
           SvgRectangle("hover", left, frame.top, time_axis.X(frame, column.cell.end) - left,
                        frame.height) +
           "</g>\n";
  }
  return svg;
}

std::string AreaStyleSheet() {
  return R"(
    .label, .others, .unknown { shape-rendering: crispEdges; }
    .others { fill: #e4e4e4; }
    .unknown { fill: url(#hatching); }
    .familiarity { fill: none; stroke: #222; stroke-width: 1.6; }
    .hover { fill: none; pointer-events: all; }
    .hover:hover { stroke: #222; stroke-width: 1; }
)";
}

std::string HatchingSvg() {
  return "<pattern id=\"hatching\" width=\"6\" height=\"6\" patternUnits=\"userSpaceOnUse\" "
         "patternTransform=\"rotate(45)\"><rect width=\"6\" height=\"6\" fill=\"#fff\"/>"
         "<rect width=\"1.6\" height=\"6\" fill=\"#777\"/></pattern>\n";
}

}  // namespace motiondb::client
