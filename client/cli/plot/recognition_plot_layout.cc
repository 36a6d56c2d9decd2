#include "client/cli/plot/recognition_plot_layout.h"

#include <fmt/format.h>
#include <motiondb/v1/query.pb.h>

#include <algorithm>
#include <iterator>
#include <tuple>

#include "client/cli/resource_name.h"

namespace motiondb::client {

namespace {

bool HasValidTimes(const v1::RecognitionWindow& window) {
  constexpr double kMaxSeconds = 1e8;
  return window.start_seconds() >= 0 && window.start_seconds() <= window.end_seconds() &&
         window.end_seconds() <= kMaxSeconds;
}

}  // namespace

PlotWindows PlotWindowsOf(const v1::RecognizeResponse& response) {
  PlotWindows drawn;
  std::vector<WindowCell>& cells = drawn.cells;
  for (const v1::RecognitionWindow& window : response.windows()) {
    if (!HasValidTimes(window)) continue;
    drawn.windows.push_back(&window);
    cells.push_back({window.start_seconds(), (window.start_seconds() + window.end_seconds()) / 2,
                     window.end_seconds()});
  }
  const std::size_t count = cells.size();
  for (std::size_t i = 0; i + 1 < count; ++i) {
    cells[i].end = cells[i + 1].start = (cells[i].middle + cells[i + 1].middle) / 2;
  }
  if (count > 1) {  // first and last are symmetric; a single window keeps its own times
    cells.front().start = 2 * cells.front().middle - cells.front().end;
    cells.back().end = 2 * cells.back().middle - cells.back().start;
  }
  return drawn;
}

std::string WindowsText(const std::vector<WindowCell>& cells, double window_seconds) {
  if (cells.empty()) return "no windows";
  if (cells.size() == 1) return fmt::format("one window of {:.3g} s", window_seconds);
  const double hop =
      (cells.back().middle - cells.front().middle) / static_cast<double>(cells.size() - 1);
  return fmt::format("{} windows of {:.3g} s, every {:.3g} s", cells.size(), window_seconds, hop);
}

void TimeAxis::Add(const WindowCell& cell) {
  start_ = is_empty_ ? cell.start : std::min(start_, cell.start);
  end_ = is_empty_ ? cell.end : std::max(end_, cell.end);
  is_empty_ = false;
}

namespace {

double SpanSeconds(bool is_empty, double start, double end) {
  constexpr double kMinSeconds = 0.01;
  return is_empty ? 1 : std::max(end - start, kMinSeconds);
}

}  // namespace

double TimeAxis::X(const PictureFrame& frame, double seconds) const {
  return frame.left + frame.width * (seconds - start_) / SpanSeconds(is_empty_, start_, end_);
}

std::vector<Tick> TimeAxis::Ticks(const PictureFrame& frame) const {
  const double span = SpanSeconds(is_empty_, start_, end_);
  return LinearTicks(start_, start_ + span, TickStep(frame.width / span),
                     [&](double seconds) { return X(frame, seconds); });
}

std::string PlotTitle(const std::string& what, const v1::RecognizeRequest& request) {
  constexpr double kNameWidth = 230;
  return fmt::format("{}: {} in {}", what,
                     TruncateToWidth(request.observation().file().file_name(), kNameWidth),
                     TruncateToWidth(ShortName(request.database()), kNameWidth));
}

void FinishPlot(Canvas& canvas, const std::string& title, const TimeAxis& time_axis, double bottom,
                const std::vector<std::vector<LegendEntry>>& legends) {
  constexpr double kRightMargin = 26, kBelowPlot = 66;  // below: the time axis
  constexpr double kBetweenLegends = 32, kBelowLegends = 24;
  const double width = kPlotLeft + kPlotWidth + kRightMargin;
  const PictureFrame frame{kPlotLeft, 0, kPlotWidth, bottom};
  DrawXTicks(canvas, bottom, time_axis.Ticks(frame));
  DrawXCaption(canvas, frame, bottom, "middle of the window (s)");
  double y = bottom + kBelowPlot;
  for (const std::vector<LegendEntry>& entries : legends) {
    if (entries.empty()) continue;
    y = DrawLegend(canvas, entries, kPlotLeft, width, y, kLegendGap) + kBetweenLegends;
  }
  canvas.SetTitle(title);
  canvas.SetSize(width, y - kBetweenLegends + kBelowLegends);
  AddLabelStyles(canvas);
}

namespace {

struct Colour {
  const char* code;
  const char* text;  // colour of text on it
};

constexpr Colour kColours[] = {
    {"#0072b2", "#fff"}, {"#d55e00", "#fff"}, {"#009e73", "#fff"}, {"#cc79a7", "#222"},
    {"#e69f00", "#222"}, {"#56b4e9", "#222"}, {"#222222", "#fff"}, {"#999999", "#222"},
};
constexpr int kColourCount = static_cast<int>(std::size(kColours));

// Of lines and of areas.
const std::vector<double> kDashes[] = {{}, {6, 3}, {2, 2}};
constexpr FillPattern kPatterns[] = {FillPattern::kPlain, FillPattern::kDots,
                                     FillPattern::kStripes};
constexpr int kVariants = static_cast<int>(std::size(kPatterns));
static_assert(std::size(kDashes) == std::size(kPatterns) &&
              kLabelStyles == kColourCount * kVariants);

int VariantOf(int place) { return place / kColourCount % kVariants; }

}  // namespace

std::vector<PlotLabel> SortedLabels(const std::map<std::string, PlotLabel>& by_name) {
  std::vector<PlotLabel> labels;
  for (const auto& [name, label] : by_name) labels.emplace_back(label).name = name;
  if (static_cast<int>(labels.size()) <= kColourCount) return labels;
  std::stable_sort(labels.begin(), labels.end(), [](const PlotLabel& a, const PlotLabel& b) {
    return std::tie(a.windows_won, a.probability, a.line_count, a.clip_count) >
           std::tie(b.windows_won, b.probability, b.line_count, b.clip_count);
  });
  return labels;
}

std::map<std::string, int> LabelIndices(const std::vector<PlotLabel>& labels) {
  std::map<std::string, int> places;
  for (const PlotLabel& label : labels) places.emplace(label.name, static_cast<int>(places.size()));
  return places;
}

std::string LabelLineStyle(int place) {
  const int variant = VariantOf(place);
  return fmt::format("c{}{}", place % kColourCount,
                     variant > 0 ? fmt::format(" d{}", variant) : "");
}

std::string LabelAreaStyle(int place) { return fmt::format("a{}", place % kLabelStyles); }

std::string LabelTextStyle(int place) { return fmt::format("t{}", place % kColourCount); }

std::string LabelPlateStyle(int place) {
  return VariantOf(place) > 0 ? fmt::format("a{}", place % kColourCount) : "";
}

void AddLabelStyles(Canvas& canvas) {
  for (int i = 0; i < kColourCount; ++i) {
    canvas.AddStyle(fmt::format("c{}", i), {.stroke = kColours[i].code});
    canvas.AddStyle(fmt::format("t{}", i), {.fill = kColours[i].text});
  }
  for (int i = 0; i < kLabelStyles; ++i) {
    canvas.AddStyle(fmt::format("a{}", i),
                    {.fill = kColours[i % kColourCount].code, .pattern = kPatterns[VariantOf(i)]});
  }
  for (int i = 1; i < kVariants; ++i) {
    canvas.AddStyle(fmt::format("d{}", i), {.dashes = kDashes[i]});
  }
}

namespace {

constexpr double kNameMargin = 5;
constexpr double kNameCharacter = 8;  // width of a plate, for wide fonts

}  // namespace

bool NameFits(std::string_view text, double width) {
  return TruncateToWidth(std::string(text), width - 2 * kNameMargin) == text;
}

std::string FittingName(const std::string& name, double width) {
  constexpr double kMinWidth = 70;
  return width < kMinWidth ? name : TruncateToWidth(name, width - 2 * kNameMargin);
}

void DrawStrip(Canvas& canvas, std::string_view kind, const std::vector<StripPart>& parts,
               double top, double height) {
  for (const StripPart& part : parts) {
    canvas.BeginGroup().tooltip = part.tooltip;
    canvas.Rectangle(fmt::format("{} {}", kind, part.area_style),
                     {part.left, top, part.width, height});
    if (!part.text.empty() && NameFits(part.text, part.width)) {
      const double middle = part.left + part.width / 2;
      if (!part.plate_style.empty()) {
        const double width =
            std::min(part.width, kNameCharacter * static_cast<double>(part.text.size()));
        canvas.Rectangle(part.plate_style, {middle - width / 2, top, width, height});
      }
      canvas.Label(
          fmt::format("{}-name{}{}", kind, part.text_style.empty() ? "" : " ", part.text_style),
          middle, top + height / 2 + 4, part.text, Anchor::kMiddle);
    }
    canvas.EndGroup();
  }
}

}  // namespace motiondb::client
