// A picture as a list of shapes, which SvgOf and PngOf convert to a file. Coordinates and sizes are
// pixels, x to the right, y downwards. Values that are not finite are drawn as 0.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "absl/status/statusor.h"

namespace motiondb::client {

enum class FillPattern { kPlain, kDots, kStripes, kHatching };  // white dots or stripes on the fill

// A rule of the style sheet. Members without a value do not change the style. Colours are "#rgb",
// "#rrggbb" or "none".
struct ShapeStyle {
  std::string_view fill = "";
  FillPattern pattern = FillPattern::kPlain;  // of `fill`
  std::optional<double> fill_opacity = std::nullopt;
  std::string_view stroke = "";
  std::optional<double> stroke_width = std::nullopt;
  std::optional<double> stroke_opacity = std::nullopt;
  std::vector<double> dashes = {};
  bool round = false;  // round ends and corners of lines
  bool crisp = false;  // no antialiasing
  std::optional<double> font_size = std::nullopt;
  bool bold = false;
  std::optional<double> hover_width = std::nullopt;  // of a stroke below the pointer; only SVG
};

struct Point {
  double x = 0;
  double y = 0;
};

// The rectangle of a picture that shows data.
struct PictureFrame {
  double left = 0;
  double top = 0;
  double width = 0;
  double height = 0;

  double right() const { return left + width; }
  double bottom() const { return top + height; }
};

enum class Anchor { kStart, kMiddle, kEnd };

struct LineShape {
  Point from, to;
};
struct CircleShape {
  Point centre;
  double radius = 0;
};
// Half axes; the first one points to `angle` (rad), counterclockwise.
struct EllipseShape {
  Point centre;
  double radius_x = 0, radius_y = 0, angle = 0;
};
struct RectangleShape {
  PictureFrame frame;
};
struct PolylineShape {
  std::vector<Point> points;
};
struct PolygonShape {
  std::vector<Point> points;
};
struct Outline {
  std::vector<Point> points;
  bool closed = false;
};
struct PathShape {
  std::vector<Outline> outlines;
};
// A sector of a circle between two angles (rad, counterclockwise from the x axis).
struct SectorShape {
  Point centre;
  double radius = 0, from = 0, to = 0;
};
// A line of text with its base line at y; a vertical one runs upwards.
struct LabelShape {
  Point at;
  std::string text;
  Anchor anchor = Anchor::kStart;
  bool vertical = false;
};
// An invisible rectangle for a tooltip; only SVG.
struct HoverShape {
  PictureFrame frame;
};
// The shapes up to GroupEnd belong together; with a frame, only its inside is visible.
struct GroupBegin {
  std::optional<PictureFrame> clip;
};
struct GroupEnd {};

// A shape and the names of its rules, separated by spaces. In the style sheet, later rules override
// earlier ones.
struct Shape {
  std::variant<LineShape, CircleShape, EllipseShape, RectangleShape, PolylineShape, PolygonShape,
               PathShape, SectorShape, LabelShape, HoverShape, GroupBegin, GroupEnd>
      geometry;
  std::string style;
  std::optional<double> stroke_width;  // overrides the style
  std::string tooltip;                 // only SVG
};

// Records shapes. The result of each function can be used until the next call.
class Canvas {
 public:
  // Has the shared styles title, line, tick, grid and frame.
  Canvas();

  void SetTitle(std::string title) { title_ = std::move(title); }
  void SetSize(double width, double height);
  // Appends a rule.
  void AddStyle(std::string name, ShapeStyle style);

  Shape& Line(std::string_view style, double x1, double y1, double x2, double y2);
  Shape& Circle(std::string_view style, double x, double y, double radius);
  Shape& Ellipse(std::string_view style, const EllipseShape& ellipse);
  Shape& Rectangle(std::string_view style, const PictureFrame& frame);
  Shape& Polyline(std::string_view style, std::vector<Point> points);
  Shape& Polygon(std::string_view style, std::vector<Point> points);
  Shape& Path(std::string_view style, std::vector<Outline> outlines);
  Shape& Sector(std::string_view style, const SectorShape& sector);
  Shape& Label(std::string_view style, double x, double y, std::string_view text,
               Anchor anchor = Anchor::kStart);
  Shape& VerticalLabel(std::string_view style, double x, double y, std::string_view text);
  Shape& HoverArea(const PictureFrame& frame, std::string tooltip);
  Shape& BeginGroup(std::optional<PictureFrame> clip = std::nullopt);
  void EndGroup();

  const std::string& title() const { return title_; }
  double width() const { return width_; }
  double height() const { return height_; }
  const std::vector<std::pair<std::string, ShapeStyle>>& styles() const { return styles_; }
  const std::vector<Shape>& shapes() const { return shapes_; }

  // Returns the style of a shape: the rules that it names, applied in order.
  ShapeStyle StyleOf(const Shape& shape) const;

 private:
  Shape& Add(Shape shape);

  std::string title_;
  double width_ = 0;
  double height_ = 0;
  std::vector<std::pair<std::string, ShapeStyle>> styles_;
  std::vector<Shape> shapes_;
};

// Returns text in one line: control characters and invalid UTF-8 are replaced by U+FFFD.
std::string PictureText(std::string_view text);

// Returns text for an XML element or attribute: as PictureText, with XML characters escaped.
std::string SvgText(std::string_view text);

// Returns a coordinate with two decimals, never "-0.00"; 0 if it is not finite.
std::string SvgNumber(double value);

// Returns a self-contained SVG file. Equal pictures give equal bytes.
std::string SvgOf(const Canvas& canvas);

// Returns a PNG file with one pixel for each unit of the canvas. RESOURCE_EXHAUSTED: the picture is
// too large.
absl::StatusOr<std::string> PngOf(const Canvas& canvas);

}  // namespace motiondb::client
