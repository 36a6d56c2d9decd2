// PngOf: draws the shapes with cairo. On a system without fonts, cairo draws text with a font of
// its own, which has ASCII only.

#include <cairo.h>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>
#include <numbers>

#include "absl/cleanup/cleanup.h"
#include "absl/status/status.h"
#include "client/cli/plot/canvas.h"

namespace motiondb::client {

namespace {

constexpr double kMaxPixels = 1e8;
constexpr double kMaxSide = 32000;       // of cairo
constexpr double kFarAway = 1e6;         // coordinates outside are not visible
constexpr double kDefaultFontSize = 16;  // as in SVG
constexpr const char* kTextColour = "#222";

double Shown(double value) {
  return std::isfinite(value) ? std::clamp(value, -kFarAway, kFarAway) : 0;
}

struct RgbColour {
  double red = 0, green = 0, blue = 0;
};

// "#rgb" or "#rrggbb".
RgbColour ColourOf(std::string_view code) {
  unsigned value = 0;
  std::from_chars(code.data() + 1, code.data() + code.size(), value, 16);
  const auto part = [&](int index) {
    return code.size() == 4 ? ((value >> (8 - 4 * index)) & 0xF) / 15.0
                            : ((value >> (16 - 8 * index)) & 0xFF) / 255.0;
  };
  return {part(0), part(1), part(2)};
}

void SetColour(cairo_t* cairo, std::string_view code, double opacity) {
  const RgbColour colour = ColourOf(code);
  cairo_set_source_rgba(cairo, colour.red, colour.green, colour.blue, opacity);
}

// Sets a tile of 6 x 6 pixels, as in the SVG file.
void SetPattern(cairo_t* cairo, const ShapeStyle& style) {
  constexpr int kSize = 6;
  cairo_surface_t* tile = cairo_image_surface_create(CAIRO_FORMAT_RGB24, kSize, kSize);
  cairo_t* painter = cairo_create(tile);
  const bool hatching = style.pattern == FillPattern::kHatching;
  SetColour(painter, hatching ? "#fff" : style.fill, 1);
  cairo_paint(painter);
  SetColour(painter, hatching ? style.fill : "#fff", 1);
  if (style.pattern == FillPattern::kDots) {
    cairo_arc(painter, 3, 3, 1.2, 0, 2 * std::numbers::pi);
  } else {
    cairo_rectangle(painter, hatching ? 0 : 2, 0, 1.6, kSize);
  }
  cairo_fill(painter);
  cairo_destroy(painter);
  cairo_pattern_t* pattern = cairo_pattern_create_for_surface(tile);
  cairo_surface_destroy(tile);
  cairo_pattern_set_extend(pattern, CAIRO_EXTEND_REPEAT);
  if (hatching) {
    cairo_matrix_t rotation;
    cairo_matrix_init_rotate(&rotation, -std::numbers::pi / 4);
    cairo_pattern_set_matrix(pattern, &rotation);
  }
  cairo_set_source(cairo, pattern);
  cairo_pattern_destroy(pattern);
}

class PngPainter {
 public:
  PngPainter(cairo_t* cairo, const Canvas& canvas) : cairo_(cairo), canvas_(canvas) {}

  void Draw(const Shape& shape) {
    std::visit([&](const auto& geometry) { Draw(geometry, shape); }, shape.geometry);
  }

 private:
  void Draw(const GroupBegin& group, const Shape&) {
    cairo_save(cairo_);
    if (!group.clip) return;
    Trace(RectangleShape{*group.clip});
    cairo_clip(cairo_);
  }

  void Draw(const GroupEnd&, const Shape&) { cairo_restore(cairo_); }
  void Draw(const HoverShape&, const Shape&) {}

  void Draw(const LabelShape& label, const Shape& shape) {
    const ShapeStyle style = canvas_.StyleOf(shape);
    cairo_select_font_face(cairo_, "sans-serif", CAIRO_FONT_SLANT_NORMAL,
                           style.bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(cairo_, style.font_size.value_or(kDefaultFontSize));
    SetColour(cairo_, style.fill.empty() ? kTextColour : style.fill, 1);
    const std::string text = PictureText(label.text);
    cairo_text_extents_t extents;
    cairo_text_extents(cairo_, text.c_str(), &extents);
    const double share = label.anchor == Anchor::kStart ? 0
                         : label.anchor == Anchor::kEnd ? 1
                                                        : 0.5;
    cairo_save(cairo_);
    cairo_translate(cairo_, Shown(label.at.x), Shown(label.at.y));
    if (label.vertical) cairo_rotate(cairo_, -std::numbers::pi / 2);
    cairo_move_to(cairo_, -share * extents.x_advance, 0);
    cairo_show_text(cairo_, text.c_str());
    cairo_restore(cairo_);
  }

  template <typename Geometry>
  void Draw(const Geometry& geometry, const Shape& shape) {
    const ShapeStyle style = canvas_.StyleOf(shape);
    cairo_set_antialias(cairo_, style.crisp ? CAIRO_ANTIALIAS_NONE : CAIRO_ANTIALIAS_DEFAULT);
    cairo_new_path(cairo_);
    Trace(geometry);
    if (style.fill != "none" && !std::is_same_v<Geometry, LineShape>) {
      if (style.pattern == FillPattern::kPlain) {
        SetColour(cairo_, style.fill.empty() ? "#000" : style.fill, style.fill_opacity.value_or(1));
      } else {
        SetPattern(cairo_, style);
      }
      cairo_fill_preserve(cairo_);
    }
    if (!style.stroke.empty() && style.stroke != "none") Stroke(style);
    cairo_new_path(cairo_);
  }

  void Stroke(const ShapeStyle& style) {
    SetColour(cairo_, style.stroke, style.stroke_opacity.value_or(1));
    cairo_set_line_width(cairo_, style.stroke_width.value_or(1));
    cairo_set_line_cap(cairo_, style.round ? CAIRO_LINE_CAP_ROUND : CAIRO_LINE_CAP_BUTT);
    cairo_set_line_join(cairo_, style.round ? CAIRO_LINE_JOIN_ROUND : CAIRO_LINE_JOIN_MITER);
    cairo_set_dash(cairo_, style.dashes.data(), static_cast<int>(style.dashes.size()), 0);
    cairo_stroke_preserve(cairo_);
  }

  void Trace(const std::vector<Point>& points, bool closed) {
    for (const Point& point : points) {
      if (&point == &points.front()) {
        cairo_move_to(cairo_, Shown(point.x), Shown(point.y));
      } else {
        cairo_line_to(cairo_, Shown(point.x), Shown(point.y));
      }
    }
    if (closed && !points.empty()) cairo_close_path(cairo_);
  }

  void Trace(const LineShape& line) { Trace({line.from, line.to}, false); }

  void Trace(const CircleShape& circle) {
    Trace(EllipseShape{circle.centre, circle.radius, circle.radius, 0});
  }

  void Trace(const EllipseShape& ellipse) {
    constexpr double kMinRadius = 1e-3;  // a smaller one has no inverse
    cairo_matrix_t before;
    cairo_get_matrix(cairo_, &before);
    cairo_translate(cairo_, Shown(ellipse.centre.x), Shown(ellipse.centre.y));
    cairo_rotate(cairo_, -Shown(ellipse.angle));
    cairo_scale(cairo_, std::max(Shown(ellipse.radius_x), kMinRadius),
                std::max(Shown(ellipse.radius_y), kMinRadius));
    cairo_arc(cairo_, 0, 0, 1, 0, 2 * std::numbers::pi);
    cairo_close_path(cairo_);
    cairo_set_matrix(cairo_, &before);
  }

  void Trace(const RectangleShape& rectangle) {
    const PictureFrame& frame = rectangle.frame;
    cairo_rectangle(cairo_, Shown(frame.left), Shown(frame.top), Shown(frame.width),
                    Shown(frame.height));
  }

  void Trace(const PolylineShape& line) { Trace(line.points, false); }
  void Trace(const PolygonShape& polygon) { Trace(polygon.points, true); }

  void Trace(const PathShape& path) {
    for (const Outline& outline : path.outlines) Trace(outline.points, outline.closed);
  }

  void Trace(const SectorShape& sector) {
    const double x = Shown(sector.centre.x), y = Shown(sector.centre.y);
    cairo_move_to(cairo_, x, y);
    cairo_arc_negative(cairo_, x, y, Shown(sector.radius), -Shown(sector.from), -Shown(sector.to));
    cairo_close_path(cairo_);
  }

  cairo_t* cairo_;
  const Canvas& canvas_;
};

cairo_status_t AppendBytes(void* file, const unsigned char* bytes, unsigned size) {
  static_cast<std::string*>(file)->append(reinterpret_cast<const char*>(bytes), size);
  return CAIRO_STATUS_SUCCESS;
}

}  // namespace

absl::StatusOr<std::string> PngOf(const Canvas& canvas) {
  const double width = std::ceil(canvas.width()), height = std::ceil(canvas.height());
  if (!(width >= 1 && height >= 1 && width <= kMaxSide && height <= kMaxSide &&
        width * height <= kMaxPixels)) {
    return absl::ResourceExhaustedError(
        fmt::format("a PNG of {} x {} pixels is too large; write FILE.svg", width, height));
  }
  cairo_surface_t* surface = cairo_image_surface_create(CAIRO_FORMAT_RGB24, static_cast<int>(width),
                                                        static_cast<int>(height));
  cairo_t* cairo = cairo_create(surface);
  const absl::Cleanup destroy = [&] {
    cairo_destroy(cairo);
    cairo_surface_destroy(surface);
  };
  SetColour(cairo, "#fff", 1);
  cairo_paint(cairo);
  PngPainter painter(cairo, canvas);
  for (const Shape& shape : canvas.shapes()) painter.Draw(shape);
  std::string file;
  cairo_status_t status = cairo_status(cairo);
  if (status == CAIRO_STATUS_SUCCESS) {
    status = cairo_surface_write_to_png_stream(surface, AppendBytes, &file);
  }
  if (status != CAIRO_STATUS_SUCCESS) {
    return absl::InternalError(
        fmt::format("the PNG cannot be drawn: {}", cairo_status_to_string(status)));
  }
  return file;
}

}  // namespace motiondb::client
