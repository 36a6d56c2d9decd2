#include "client/cli/plot/recognition_plot.h"

#include <fmt/format.h>
#include <motiondb/v1/query.pb.h>

#include <algorithm>
#include <cstddef>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "client/cli/database_text.h"
#include "client/cli/plot/picture.h"
#include "client/cli/plot/recognition_plot_answer.h"
#include "client/cli/plot/recognition_plot_areas.h"
#include "client/cli/plot/recognition_plot_layout.h"
#include "client/cli/terminal/print.h"

namespace motiondb::client {

namespace {

void AddAnswerStyles(Canvas& canvas) {
  canvas.AddStyle("panel-title", {.fill = "#333", .font_size = 14, .bold = true});
  canvas.AddStyle("threshold-halo", {.stroke = "#fff", .stroke_width = 3, .stroke_opacity = 0.7});
  canvas.AddStyle("threshold", {.stroke = "#222", .stroke_width = 1, .dashes = {6, 4}});
  canvas.AddStyle("plate", {.fill = "#fff"});
  canvas.AddStyle("clip", {.fill_opacity = 0.3, .stroke = "#fff", .stroke_width = 0.6});
  canvas.AddStyle("answer-name", {.font_size = 12});
  canvas.AddStyle("clip-name", {.font_size = 12});
  canvas.AddStyle("clip-number", {.font_size = 11});
}

constexpr double kAnswerTitleHeight = 24, kProbabilityHeight = 170, kFamiliarityHeight = 64;
constexpr double kStripsGap = 5, kAnswerHeight = 24, kClipHeight = 20, kBelowStrips = 12;
constexpr double kLegendNameWidth = 190, kLegendClipWidth = 230;

struct AnswerLayout {
  PictureFrame probability;
  PictureFrame familiarity;
  double answer_top = 0;
  double clip_top = 0;
};

AnswerLayout AnswerLayoutBelow(double heading_height) {
  AnswerLayout layout;
  layout.probability = {kPlotLeft, heading_height + kAnswerTitleHeight, kPlotWidth,
                        kProbabilityHeight};
  layout.answer_top = layout.probability.bottom() + kStripsGap;
  layout.clip_top = layout.answer_top + kAnswerHeight + kStripsGap;
  layout.familiarity = {kPlotLeft,
                        layout.clip_top + kClipHeight + kBelowStrips + kAnswerTitleHeight,
                        kPlotWidth, kFamiliarityHeight};
  return layout;
}

// Returns which labels are drawn: those that win a window, or are probable in any column.
std::vector<bool> DrawnLabels(const RecognitionAnswer& answer) {
  constexpr double kMinProbability = 0.05;
  std::vector<bool> drawn;
  for (std::size_t i = 0; i < answer.labels.size(); ++i) {
    double highest = 0;
    for (const AnswerColumn& column : answer.columns) {
      highest = std::max(highest, column.probabilities[i]);
    }
    const bool relevant = answer.labels[i].windows_won > 0 || highest >= kMinProbability;
    drawn.push_back(relevant && i < kLabelStyles);
  }
  return drawn;
}

// Strips, legends and frames of the answer.
class AnswerPlot {
 public:
  AnswerPlot(const RecognitionAnswer& answer, double unknown_threshold, const AnswerLayout& layout)
      : answer_(answer),
        columns_(answer.columns),
        threshold_(unknown_threshold),
        layout_(layout),
        drawn_(DrawnLabels(answer)) {
    for (const AnswerColumn& column : columns_) time_axis_.Add(column.cell);
    answer_parts_ = AnswerParts();
    clip_parts_ = ClipParts();
  }

  const TimeAxis& time_axis() const { return time_axis_; }

  void Draw(Canvas& canvas) const {
    const PictureFrame& probability = layout_.probability;
    const PictureFrame& familiarity = layout_.familiarity;
    const double height = familiarity.bottom() - probability.top;
    DrawTitledGrid(canvas, probability, "Probability of labels", 0.2);
    DrawAreas(canvas);
    canvas.Rectangle("frame", probability);
    DrawThreshold(canvas);
    DrawStripTitle(canvas, "answer", layout_.answer_top, kAnswerHeight);
    DrawStrip(canvas, "answer", answer_parts_, layout_.answer_top, kAnswerHeight);
    DrawStripTitle(canvas, "best clip", layout_.clip_top, kClipHeight);
    DrawStrip(canvas, "clip", clip_parts_, layout_.clip_top, kClipHeight);
    DrawTitledGrid(canvas, familiarity,
                   "Familiarity: share of stored windows that are less familiar", 0.5);
    canvas.Rectangle("frame", familiarity);
    DrawFamiliarity(canvas, answer_, time_axis_, familiarity);
    AddTooltips(canvas, answer_, time_axis_, {kPlotLeft, probability.top, kPlotWidth, height});
  }

  std::vector<LegendEntry> LabelLegend() const {
    std::vector<LegendEntry> entries;
    int other_count = 0, other_windows = 0;
    for (std::size_t i = 0; i < drawn_.size(); ++i) {
      const PlotLabel& label = answer_.labels[i];
      if (drawn_[i]) {
        entries.push_back(AreaEntry(TruncateToWidth(label.name, kLegendNameWidth),
                                    label.windows_won, LabelAreaStyle(static_cast<int>(i))));
      } else {
        ++other_count;
        other_windows += label.windows_won;
      }
    }
    if (other_count > 0) {
      entries.push_back(AreaEntry(CountText(other_count, "other label"), other_windows, "others"));
    }
    if (answer_.has_unknown) {
      entries.push_back(AreaEntry("unknown", answer_.unknown_windows, "unknown"));
    }
    return entries;
  }

  // The names of the clips that have numbers in the strip.
  std::vector<LegendEntry> ClipLegend() const {
    std::vector<LegendEntry> entries;
    for (const int index : numbered_clips_) {
      const AnswerClip& clip = answer_.clips[static_cast<std::size_t>(index)];
      entries.push_back({fmt::format("{}: {}", TruncateToWidth(clip.name, kLegendClipWidth),
                                     CountText(clip.windows_won, "window")),
                         [index](Canvas& canvas, double x, double y) {
                           canvas.Label("clip-number", x, y + 4, NumberText(index));
                         }});
    }
    return entries;
  }

 private:
  static LegendEntry AreaEntry(const std::string& name, int windows, const std::string& style) {
    return {windows > 0 ? fmt::format("{}: {}", name, CountText(windows, "window")) : name,
            [style](Canvas& canvas, double x, double y) {
              canvas.Rectangle(style, {x, y - 6, 20, 12});
            }};
  }

  static std::string NumberText(int clip) { return fmt::format("#{}", clip + 1); }

  static void DrawStripTitle(Canvas& canvas, const std::string& title, double top, double height) {
    canvas.Label("tick", kPlotLeft - 8, top + height / 2 + 4, title, Anchor::kEnd);
  }

  void DrawTitledGrid(Canvas& canvas, const PictureFrame& frame, const std::string& title,
                      double step) const {
    const std::vector<Tick> ticks = LinearTicks(
        0, 1, step, [&](double value) { return frame.bottom() - frame.height * value; });
    canvas.Label("panel-title", frame.left, frame.top - 8, title);
    DrawGrid(canvas, frame, time_axis_.Ticks(frame), ticks);
    DrawYTicks(canvas, frame, ticks);
  }

  void DrawAreas(Canvas& canvas) const {
    const PictureFrame& frame = layout_.probability;
    if (DrawProbabilityAreas(canvas, answer_, drawn_, time_axis_, frame)) return;
    canvas.Label("line", frame.left + frame.width / 2, frame.top + frame.height / 2,
                 columns_.empty() ? "no windows" : "no labels", Anchor::kMiddle);
  }

  void DrawThreshold(Canvas& canvas) const {
    if (!answer_.has_unknown || !(threshold_ > 0 && threshold_ < 1)) return;
    const PictureFrame& frame = layout_.probability;
    const double y = frame.top + frame.height * threshold_;
    canvas.Line("threshold-halo", frame.left, y, frame.right(), y);
    canvas.Line("threshold", frame.left, y, frame.right(), y);
  }

  std::string AreaStyle(int label) const {
    if (label == AnswerColumn::kUnknown) return "unknown";
    return drawn_[static_cast<std::size_t>(label)] ? LabelAreaStyle(label) : "others";
  }

  // Calls `add(value, part)` for each run of columns with the same value. The part has the place of
  // the run.
  template <typename Add>
  void ForRuns(int AnswerColumn::*value, const Add& add) const {
    for (std::size_t begin = 0, end = 0; begin < columns_.size(); begin = end) {
      const int common = columns_[begin].*value;
      while (end < columns_.size() && columns_[end].*value == common) ++end;
      if (common == AnswerColumn::kNone) continue;
      StripPart part;
      part.left = time_axis_.X(layout_.probability, columns_[begin].cell.start);
      part.width = time_axis_.X(layout_.probability, columns_[end - 1].cell.end) - part.left;
      add(common, std::move(part));
    }
  }

  std::vector<StripPart> AnswerParts() const {
    std::vector<StripPart> parts;
    ForRuns(&AnswerColumn::answer, [&](int answer, StripPart part) {
      part.area_style = AreaStyle(answer);
      if (answer == AnswerColumn::kUnknown) {
        part.text = "unknown";
        part.text_style = "unknown-text";
        part.plate_style = "plate";
      } else {
        part.text = FittingName(answer_.labels[static_cast<std::size_t>(answer)].name, part.width);
        if (part.area_style != "others") {
          part.text_style = LabelTextStyle(answer);
          part.plate_style = LabelPlateStyle(answer);
        }
      }
      parts.push_back(std::move(part));
    });
    return parts;
  }

  std::vector<StripPart> ClipParts() {
    constexpr int kMaxNumber = 12;
    std::vector<StripPart> parts;
    ForRuns(&AnswerColumn::clip, [&](int index, StripPart part) {
      const AnswerClip& clip = answer_.clips[static_cast<std::size_t>(index)];
      part.area_style = AreaStyle(clip.label);
      part.text = clip.name;
      if (!NameFits(part.text, part.width)) {
        part.text = index < kMaxNumber ? NumberText(index) : "";
        if (index < kMaxNumber && NameFits(part.text, part.width)) numbered_clips_.insert(index);
      }
      parts.push_back(std::move(part));
    });
    return parts;
  }

  const RecognitionAnswer& answer_;
  const std::vector<AnswerColumn>& columns_;
  const double threshold_;
  const AnswerLayout layout_;
  const std::vector<bool> drawn_;
  TimeAxis time_axis_;
  std::set<int> numbered_clips_;  // their names do not fit in a part of the strip
  std::vector<StripPart> answer_parts_;
  std::vector<StripPart> clip_parts_;
};

// Returns why the response has no probability of unknown motion.
std::string NoUnknownText(const v1::RecognizeRequest& request,
                          const v1::RecognizeResponse& response) {
  std::string text;
  if (request.method() != v1::METHOD_PAPER) text = UnknownNote(response.calibration());
  if (text.empty()) return "no probability of unknown motion";
  text.pop_back();  // end of line
  return text;
}

std::vector<std::string> AnswerHeading(const v1::RecognizeRequest& request,
                                       const v1::RecognizeResponse& response,
                                       const RecognitionAnswer& answer, double unknown_threshold) {
  std::string what = WindowsText(answer.windows, answer.window_seconds);
  if (answer.windows.empty()) return {what};
  if (answer.windows_per_column > 1) {
    what += fmt::format("; each column is the mean of {}",
                        CountText(answer.windows_per_column, "window"));
  }
  if (request.method() == v1::METHOD_PAPER) what += "; only the tree and its graphs";
  if (!answer.has_unknown) return {what, NoUnknownText(request, response)};
  return {what, fmt::format("Hatched: unknown motion. It is the answer if its probability is above "
                            "{:g}: the hatching crosses the dashed line.",
                            unknown_threshold)};
}

}  // namespace

Canvas RecognitionPicture(const v1::RecognizeRequest& request,
                          const v1::RecognizeResponse& response, double unknown_threshold) {
  const RecognitionAnswer answer = RecognitionAnswerFrom(response, unknown_threshold);
  const std::string title = PlotTitle("Recognition", request);
  const std::vector<std::string> lines =
      AnswerHeading(request, response, answer, unknown_threshold);
  const AnswerLayout layout = AnswerLayoutBelow(HeadingHeight(lines.size()));
  const AnswerPlot plot(answer, unknown_threshold, layout);
  Canvas canvas;
  AddAreaStyles(canvas);
  AddAnswerStyles(canvas);
  DrawHeading(canvas, kPlotLeft, kPlotWidth, title, lines);
  plot.Draw(canvas);
  FinishPlot(canvas, title, plot.time_axis(), layout.familiarity.bottom(),
             {plot.LabelLegend(), plot.ClipLegend()});
  return canvas;
}

}  // namespace motiondb::client
