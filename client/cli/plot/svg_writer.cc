// SvgOf: text stays text, so that it can be searched, and rules of the style sheet are classes.

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <string>

#include "absl/strings/str_split.h"
#include "client/cli/plot/canvas.h"

namespace motiondb::client {

std::string SvgText(std::string_view text) {
  std::string escaped;
  for (const char c : PictureText(text)) {
    if (c == '&') {
      escaped += "&amp;";
    } else if (c == '<') {
      escaped += "&lt;";
    } else if (c == '>') {
      escaped += "&gt;";
    } else if (c == '"') {
      escaped += "&quot;";
    } else {
      escaped += c;
    }
  }
  return escaped;
}

std::string SvgNumber(double value) {
  const bool nothing = !std::isfinite(value) || std::abs(value) < 0.005;
  return fmt::format("{:.2f}", nothing ? 0.0 : value);
}

namespace {

constexpr int kPatternSize = 6;

std::string N(double value) { return SvgNumber(value); }

std::string PatternId(const ShapeStyle& style) {
  const char* kind = style.pattern == FillPattern::kDots      ? "dots"
                     : style.pattern == FillPattern::kStripes ? "stripes"
                                                              : "hatching";
  return fmt::format("{}-{}", kind, style.fill.substr(1));
}

std::string PatternSvg(const ShapeStyle& style) {
  const bool hatching = style.pattern == FillPattern::kHatching;
  const std::string_view ground = hatching ? "#fff" : style.fill;
  const std::string mark =
      style.pattern == FillPattern::kDots
          ? "<circle cx=\"3\" cy=\"3\" r=\"1.2\" fill=\"#fff\"/>"
          : fmt::format("<rect x=\"{}\" width=\"1.6\" height=\"6\" fill=\"{}\"/>", hatching ? 0 : 2,
                        hatching ? style.fill : "#fff");
  return fmt::format(
      "<pattern id=\"{0}\" width=\"{1}\" height=\"{1}\" patternUnits=\"userSpaceOnUse\"{2}>"
      "<rect width=\"{1}\" height=\"{1}\" fill=\"{3}\"/>{4}</pattern>\n",
      PatternId(style), kPatternSize, hatching ? " patternTransform=\"rotate(45)\"" : "", ground,
      mark);
}

std::string RuleSvg(const std::string& name, const ShapeStyle& style) {
  std::string text;
  const auto add = [&](std::string_view property, const auto& value) {
    text += fmt::format(" {}: {};", property, value);
  };
  if (!style.fill.empty()) {
    add("fill", style.pattern == FillPattern::kPlain ? std::string(style.fill)
                                                     : "url(#" + PatternId(style) + ")");
  }
  if (style.fill_opacity) add("fill-opacity", *style.fill_opacity);
  if (!style.stroke.empty()) add("stroke", style.stroke);
  if (style.stroke_width) add("stroke-width", *style.stroke_width);
  if (style.stroke_opacity) add("stroke-opacity", *style.stroke_opacity);
  if (!style.dashes.empty())
    add("stroke-dasharray", fmt::format("{}", fmt::join(style.dashes, " ")));
  if (style.round) text += " stroke-linejoin: round; stroke-linecap: round;";
  if (style.crisp) add("shape-rendering", "crispEdges");
  if (style.font_size) add("font-size", fmt::format("{}px", *style.font_size));
  if (style.bold) add("font-weight", "bold");
  std::string rule = fmt::format("    .{} {{{} }}\n", name, text);
  if (style.hover_width) {
    rule += fmt::format("    .{}:hover {{ stroke-width: {}; stroke-opacity: 1; }}\n", name,
                        *style.hover_width);
  }
  return rule;
}

std::string PointsText(const std::vector<Point>& points) {
  std::string text;
  for (const Point& point : points) {
    text += fmt::format("{}{},{}", text.empty() ? "" : " ", N(point.x), N(point.y));
  }
  return text;
}

// Horizontal and vertical lines have their short forms.
std::string PathData(const std::vector<Outline>& outlines) {
  std::string data;
  for (const Outline& outline : outlines) {
    std::string last_x, last_y;
    for (const Point& point : outline.points) {
      const std::string x = N(point.x), y = N(point.y);
      if (last_x.empty()) {
        data += fmt::format("M{} {}", x, y);
      } else if (x == last_x) {
        if (y != last_y) data += "V" + y;
      } else if (y == last_y) {
        data += "H" + x;
      } else {
        data += fmt::format("L{} {}", x, y);
      }
      last_x = x;
      last_y = y;
    }
    if (outline.closed) data += "Z";
  }
  return data;
}

// Returns the element's name and its attributes with the geometry.
struct ElementText {
  std::string name;
  std::string attributes;
};

ElementText TextOf(const LineShape& line) {
  return {"line", fmt::format("x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\"", N(line.from.x),
                              N(line.from.y), N(line.to.x), N(line.to.y))};
}

ElementText TextOf(const CircleShape& circle) {
  return {"circle", fmt::format("cx=\"{}\" cy=\"{}\" r=\"{}\"", N(circle.centre.x),
                                N(circle.centre.y), N(circle.radius))};
}

ElementText TextOf(const EllipseShape& ellipse) {
  const std::string x = N(ellipse.centre.x), y = N(ellipse.centre.y);
  return {
      "ellipse",
      fmt::format("cx=\"{0}\" cy=\"{1}\" rx=\"{2}\" ry=\"{3}\" transform=\"rotate({4} {0} {1})\"",
                  x, y, N(ellipse.radius_x), N(ellipse.radius_y),
                  N(-ellipse.angle * 180 / std::numbers::pi))};
}

ElementText TextOf(const PictureFrame& frame) {
  return {"rect", fmt::format("x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"", N(frame.left),
                              N(frame.top), N(frame.width), N(frame.height))};
}

ElementText TextOf(const RectangleShape& rectangle) { return TextOf(rectangle.frame); }
ElementText TextOf(const HoverShape& hover) { return TextOf(hover.frame); }

ElementText TextOf(const PolylineShape& line) {
  return {"polyline", fmt::format("points=\"{}\"", PointsText(line.points))};
}

ElementText TextOf(const PolygonShape& polygon) {
  return {"polygon", fmt::format("points=\"{}\"", PointsText(polygon.points))};
}

ElementText TextOf(const PathShape& path) {
  return {"path", fmt::format("d=\"{}\"", PathData(path.outlines))};
}

ElementText TextOf(const SectorShape& sector) {
  const auto edge = [&](double angle) {
    return fmt::format("{} {}", N(sector.centre.x + sector.radius * std::cos(angle)),
                       N(sector.centre.y - sector.radius * std::sin(angle)));
  };
  return {"path",
          fmt::format("d=\"M {} {} L {} A {} {} 0 {} 0 {} Z\"", N(sector.centre.x),
                      N(sector.centre.y), edge(sector.from), N(sector.radius), N(sector.radius),
                      sector.to - sector.from > std::numbers::pi ? 1 : 0, edge(sector.to))};
}

ElementText TextOf(const LabelShape& label) {
  const std::string x = N(label.at.x), y = N(label.at.y);
  std::string attributes = fmt::format("x=\"{}\" y=\"{}\"", x, y);
  if (label.anchor == Anchor::kMiddle) attributes += " text-anchor=\"middle\"";
  if (label.anchor == Anchor::kEnd) attributes += " text-anchor=\"end\"";
  if (label.vertical) attributes += fmt::format(" transform=\"rotate(-90 {} {})\"", x, y);
  return {"text", attributes};
}

class SvgWriter {
 public:
  std::string TakeText() { return std::move(svg_); }

  void Write(const Shape& shape) {
    std::visit([&](const auto& geometry) { Write(geometry, shape); }, shape.geometry);
  }

 private:
  void Write(const GroupBegin& group, const Shape& shape) {
    if (group.clip) {
      const std::string id = fmt::format("clip-{}", ++clip_count_);
      svg_ +=
          fmt::format("<clipPath id=\"{0}\"><rect {1}/></clipPath>\n<g clip-path=\"url(#{0})\">",
                      id, TextOf(*group.clip).attributes);
    } else {
      svg_ += "<g>";
    }
    svg_ += TooltipOf(shape) + "\n";
  }

  void Write(const GroupEnd&, const Shape&) { svg_ += "</g>\n"; }

  template <typename Geometry>
  void Write(const Geometry& geometry, const Shape& shape) {
    const auto [name, attributes] = TextOf(geometry);
    svg_ += fmt::format("<{} class=\"{}\" {}", name, shape.style, attributes);
    if (shape.stroke_width) {
      svg_ += fmt::format(" style=\"stroke-width:{}\"", N(*shape.stroke_width));
    }
    std::string content = TooltipOf(shape);
    if constexpr (std::is_same_v<Geometry, LabelShape>) content += SvgText(geometry.text);
    svg_ += content.empty() && name != "text" ? "/>\n" : fmt::format(">{}</{}>\n", content, name);
  }

  static std::string TooltipOf(const Shape& shape) {
    return shape.tooltip.empty() ? "" : "<title>" + SvgText(shape.tooltip) + "</title>";
  }

  std::string svg_;
  int clip_count_ = 0;
};

std::set<std::string> UsedRules(const Canvas& canvas) {
  std::set<std::string> used;
  std::string last;
  for (const Shape& shape : canvas.shapes()) {
    if (shape.style == last) continue;
    last = shape.style;
    for (const auto name : absl::StrSplit(shape.style, ' ')) used.emplace(name);
  }
  return used;
}

constexpr char kElementRules[] = R"(
    text { font-family: Helvetica, Arial, sans-serif; fill: #222; }
    .hover { fill: none; pointer-events: all; }
    .hover:hover { stroke: #222; stroke-width: 1; }
)";

}  // namespace

std::string SvgOf(const Canvas& canvas) {
  const std::string width = N(canvas.width()), height = N(canvas.height());
  std::string svg = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" "
      "viewBox=\"0 0 {0} {1}\">\n"
      "<title>{2}</title>\n<style>{3}",
      width, height, SvgText(canvas.title()), kElementRules);
  const std::set<std::string> used = UsedRules(canvas);
  std::map<std::string, std::string> patterns;
  for (const auto& [name, style] : canvas.styles()) {
    if (!used.contains(name)) continue;
    svg += RuleSvg(name, style);
    if (style.pattern != FillPattern::kPlain) patterns[PatternId(style)] = PatternSvg(style);
  }
  svg += "</style>\n";
  for (const auto& [id, pattern] : patterns) svg += pattern;
  svg += fmt::format("<rect width=\"{}\" height=\"{}\" fill=\"#fff\"/>\n", width, height);
  SvgWriter writer;
  for (const Shape& shape : canvas.shapes()) writer.Write(shape);
  return svg + writer.TakeText() + "</svg>\n";
}

}  // namespace motiondb::client
