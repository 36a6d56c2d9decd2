#include "client/cli/plot/canvas.h"

#include <algorithm>

#include "text/display_text.h"

namespace motiondb::client {

namespace {

void Override(const ShapeStyle& rule, ShapeStyle& style) {
  if (!rule.fill.empty()) {
    style.fill = rule.fill;
    style.pattern = rule.pattern;
  }
  if (rule.fill_opacity) style.fill_opacity = rule.fill_opacity;
  if (!rule.stroke.empty()) style.stroke = rule.stroke;
  if (rule.stroke_width) style.stroke_width = rule.stroke_width;
  if (rule.stroke_opacity) style.stroke_opacity = rule.stroke_opacity;
  if (!rule.dashes.empty()) style.dashes = rule.dashes;
  style.round = style.round || rule.round;
  style.crisp = style.crisp || rule.crisp;
  if (rule.font_size) style.font_size = rule.font_size;
  style.bold = style.bold || rule.bold;
}

// Returns whether `name` is one of the names in `list`, which are separated by spaces.
bool Names(std::string_view list, std::string_view name) {
  while (!list.empty()) {
    const std::size_t end = std::min(list.find(' '), list.size());
    if (list.substr(0, end) == name) return true;
    list.remove_prefix(std::min(end + 1, list.size()));
  }
  return false;
}

}  // namespace

Canvas::Canvas() {
  AddStyle("title", {.font_size = 18, .bold = true});
  AddStyle("line", {.fill = "#444", .font_size = 13});
  AddStyle("tick", {.fill = "#555", .font_size = 12});
  AddStyle("grid", {.stroke = "#e6e6e6", .stroke_width = 1});
  AddStyle("frame", {.fill = "none", .stroke = "#888", .stroke_width = 1});
}

void Canvas::SetSize(double width, double height) {
  width_ = width;
  height_ = height;
}

void Canvas::AddStyle(std::string name, ShapeStyle style) {
  styles_.emplace_back(std::move(name), std::move(style));
}

Shape& Canvas::Add(Shape shape) { return shapes_.emplace_back(std::move(shape)); }

Shape& Canvas::Line(std::string_view style, double x1, double y1, double x2, double y2) {
  return Add({LineShape{{x1, y1}, {x2, y2}}, std::string(style), {}, {}});
}

Shape& Canvas::Circle(std::string_view style, double x, double y, double radius) {
  return Add({CircleShape{{x, y}, radius}, std::string(style), {}, {}});
}

Shape& Canvas::Ellipse(std::string_view style, const EllipseShape& ellipse) {
  return Add({ellipse, std::string(style), {}, {}});
}

Shape& Canvas::Rectangle(std::string_view style, const PictureFrame& frame) {
  return Add({RectangleShape{frame}, std::string(style), {}, {}});
}

Shape& Canvas::Polyline(std::string_view style, std::vector<Point> points) {
  return Add({PolylineShape{std::move(points)}, std::string(style), {}, {}});
}

Shape& Canvas::Polygon(std::string_view style, std::vector<Point> points) {
  return Add({PolygonShape{std::move(points)}, std::string(style), {}, {}});
}

Shape& Canvas::Path(std::string_view style, std::vector<Outline> outlines) {
  return Add({PathShape{std::move(outlines)}, std::string(style), {}, {}});
}

Shape& Canvas::Sector(std::string_view style, const SectorShape& sector) {
  return Add({sector, std::string(style), {}, {}});
}

Shape& Canvas::Label(std::string_view style, double x, double y, std::string_view text,
                     Anchor anchor) {
  return Add({LabelShape{{x, y}, std::string(text), anchor, false}, std::string(style), {}, {}});
}

Shape& Canvas::VerticalLabel(std::string_view style, double x, double y, std::string_view text) {
  return Add(
      {LabelShape{{x, y}, std::string(text), Anchor::kMiddle, true}, std::string(style), {}, {}});
}

Shape& Canvas::HoverArea(const PictureFrame& frame, std::string tooltip) {
  return Add({HoverShape{frame}, "hover", {}, std::move(tooltip)});
}

Shape& Canvas::BeginGroup(std::optional<PictureFrame> clip) {
  return Add({GroupBegin{clip}, "", {}, {}});
}

void Canvas::EndGroup() { Add({GroupEnd{}, "", {}, {}}); }

ShapeStyle Canvas::StyleOf(const Shape& shape) const {
  ShapeStyle style;
  for (const auto& [name, rule] : styles_) {
    if (Names(shape.style, name)) Override(rule, style);
  }
  if (shape.stroke_width) style.stroke_width = shape.stroke_width;
  return style;
}

std::string PictureText(std::string_view text) {
  std::string line;
  for (const char c : text::DisplayLines(text)) line += c == '\n' ? ' ' : c;
  return line;
}

}  // namespace motiondb::client
