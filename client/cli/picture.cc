#include "client/cli/picture.h"

#include <fmt/format.h>

#include <algorithm>

#include "client/cli/svg.h"
#include "text/utf8.h"

namespace motiondb::client {
namespace {

constexpr double kTitleHeight = 30, kLineHeight = 20, kBelowHeading = 18;
constexpr double kCharacterWidth = 6.6;  // of the lines below the title, about
constexpr double kLegendRowHeight = 22;
constexpr double kSampleWidth = 26;

constexpr const char* kStyle = R"(
    text { font-family: Helvetica, Arial, sans-serif; fill: #222; }
    .title { font-size: 18px; font-weight: bold; }
    .line { font-size: 13px; fill: #444; }
    .tick { font-size: 12px; fill: #555; }
    .grid { stroke: #e6e6e6; stroke-width: 1; }
    .frame { fill: none; stroke: #888; stroke-width: 1; })";

}  // namespace

std::string PictureHead(double width, double height, std::string_view title,
                        std::string_view style) {
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" "
      "viewBox=\"0 0 {0} {1}\">\n"
      "<title>{2}</title>\n<style>{3}{4}</style>\n",
      SvgNumber(width), SvgNumber(height), SvgText(title), kStyle, style);
}

std::string BackgroundSvg(double width, double height) {
  return fmt::format("<rect width=\"{}\" height=\"{}\" fill=\"#fff\"/>\n", SvgNumber(width),
                     SvgNumber(height));
}

std::string FittingText(const std::string& text, double width) {
  constexpr std::string_view kCut = "...";
  const auto most = static_cast<std::size_t>(std::max(0.0, width) / kCharacterWidth);
  if (text.size() <= most) return text;
  if (most <= kCut.size()) return "";
  return std::string(text::CutAt(text, most - kCut.size())).append(kCut);
}

std::string HeadingSvg(double left, double width, const std::string& title,
                       const std::vector<std::string>& lines) {
  double y = kTitleHeight;
  std::string svg = SvgLabel("title", left, y, FittingText(title, width));
  for (const std::string& line : lines) {
    y += kLineHeight;
    svg += SvgLabel("line", left, y, FittingText(line, width));
  }
  return svg;
}

double HeadingHeight(std::size_t lines) {
  return kTitleHeight + kBelowHeading + kLineHeight * static_cast<double>(lines);
}

Legend LegendSvg(const std::vector<LegendEntry>& entries, double left, double right, double y,
                 double between) {
  Legend legend{"", y};
  double x = left;
  for (const LegendEntry& entry : entries) {
    const double width =
        kSampleWidth + between + kCharacterWidth * static_cast<double>(entry.name.size());
    if (x + width > right && x > left) {
      x = left;
      legend.last_y += kLegendRowHeight;
    }
    legend.svg += entry.sample(x, legend.last_y) +
                  SvgLabel("line", x + kSampleWidth, legend.last_y + 4, entry.name);
    x += width;
  }
  return legend;
}

}  // namespace motiondb::client
