#include "core/format/urdf_file.h"

#include <tinyxml2.h>

#include <algorithm>
#include <array>
#include <utility>

#include "core/format/gunzip.h"
#include "core/format/motion_file.h"
#include "core/format/text_scanner.h"
#include "core/format/urdf_elements.h"
#include "core/motion/error.h"

namespace motiondb::core {
namespace {

using tinyxml2::XMLElement;

constexpr std::size_t kMaxTag = 4096;
constexpr double kMinAxis = 1e-6;

constexpr std::array<std::pair<std::string_view, UrdfJoint::Type>, 6> kTypes = {{
    {"revolute", UrdfJoint::Type::kRevolute},
    {"continuous", UrdfJoint::Type::kContinuous},
    {"prismatic", UrdfJoint::Type::kPrismatic},
    {"fixed", UrdfJoint::Type::kFixed},
    {"floating", UrdfJoint::Type::kFloating},
    {"planar", UrdfJoint::Type::kPlanar},
}};

// Length of a tag: up to the first '>' outside quotes.
std::size_t TagLength(std::string_view text) {
  char quote = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (quote != 0) {
      if (text[i] == quote) quote = 0;
    } else if (text[i] == '"' || text[i] == '\'') {
      quote = text[i];
    } else if (text[i] == '>') {
      return i;
    }
  }
  return text.size();
}

// Returns the offset of the first tag longer than kMaxTag. The parser compares each attribute with
// all previous ones of its tag: a megabyte of attributes would take minutes.
std::optional<std::size_t> FindLongTag(std::string_view bytes) {
  std::size_t at = bytes.find('<');
  while (at != bytes.npos) {
    const std::string_view rest = bytes.substr(at);
    std::size_t end = 0;
    if (rest.starts_with("<!--")) {
      end = rest.find("-->");
    } else if (rest.starts_with("<![CDATA[")) {
      end = rest.find("]]>");
    } else if (rest.starts_with("<?")) {
      end = rest.find("?>");
    } else if (rest.starts_with("<!")) {
      end = rest.find('>');
    } else {
      end = TagLength(rest);
      if (end > kMaxTag) return at;
    }
    if (end == rest.npos) return std::nullopt;
    at = bytes.find('<', at + end);
  }
  return std::nullopt;
}

class UrdfFileReader {
 public:
  explicit UrdfFileReader(SourceFile file) : file_(file) {}

  absl::StatusOr<UrdfFile> Read() {
    MOTIONDB_RETURN_IF_ERROR(Parse());
    MOTIONDB_RETURN_IF_ERROR(CheckTopLevel());
    const XMLElement& robot = *document_.RootElement();
    if (const char* name = robot.Attribute("name")) urdf_.name = ToUtf8(name);
    const UrdfMaterials materials(file_.name, robot);
    for (const XMLElement* element = robot.FirstChildElement(); element != nullptr;
         element = element->NextSiblingElement()) {
      const std::string_view kind = element->Name();
      if (kind.starts_with("xacro:")) {
        return Error(*element, "expected URDF, found <{}>: expand the file with xacro first",
                     Shown(kind));
      }
      if (kind == "link") {
        UrdfLink& link = urdf_.links.emplace_back();
        link.line = element->GetLineNum();
        MOTIONDB_RETURN_IF_ERROR(ReadName(*element, "name", link.name));
        MOTIONDB_RETURN_IF_ERROR(ReadInertia(*element, link));
        ReadVisuals(*element, materials, link);
      } else if (kind == "joint") {
        MOTIONDB_RETURN_IF_ERROR(ReadJoint(*element));
      }
    }
    return std::move(urdf_);
  }

 private:
  template <typename... Args>
  absl::Status ErrorAt(int line, fmt::format_string<Args...> format, Args&&... args) const {
    return InvalidArgument("{}:{}: {}", file_.name, line,
                           fmt::format(format, std::forward<Args>(args)...));
  }

  template <typename... Args>
  absl::Status Error(const XMLElement& element, fmt::format_string<Args...> format,
                     Args&&... args) const {
    return UrdfError(file_.name, element, format, std::forward<Args>(args)...);
  }

  int LineOf(std::size_t at) const {
    return 1 + static_cast<int>(std::count(file_.bytes.begin(), file_.bytes.begin() + at, '\n'));
  }

  absl::Status Parse() {
    // The parsed document uses about 30 times as much.
    if (file_.bytes.size() > kMaxSkeletonBytes) {
      return InvalidArgument("{}: expected a URDF of at most {} bytes, found {}", file_.name,
                             kMaxSkeletonBytes, file_.bytes.size());
    }
    if (const auto zero = file_.bytes.find('\0'); zero != file_.bytes.npos) {
      return ErrorAt(LineOf(zero), "expected text in UTF-8, found a zero byte");
    }
    if (const auto tag = FindLongTag(file_.bytes)) {
      return ErrorAt(LineOf(*tag), "expected a tag of at most {} bytes (is a quote left open?)",
                     kMaxTag);
    }
    if (document_.Parse(file_.bytes.data(), file_.bytes.size()) != tinyxml2::XML_SUCCESS) {
      return ErrorAt(std::max(1, document_.ErrorLineNum()),
                     "expected well-formed XML, found {} (truncated?)", document_.ErrorName());
    }
    return absl::OkStatus();
  }

  // The parser accepts text before the first element, several root elements and document types.
  absl::Status CheckTopLevel() const {
    const XMLElement* robot = document_.RootElement();
    for (const tinyxml2::XMLNode* node = document_.FirstChild(); node != nullptr;
         node = node->NextSibling()) {
      const int line = node->GetLineNum();
      if (node->ToUnknown() != nullptr) return ErrorAt(line, "expected no document type");
      if (node->ToText() != nullptr) return ErrorAt(line, "expected <robot>, found text");
      if (node->ToElement() != nullptr && node != robot) {
        return ErrorAt(line, "expected the file to end after <robot>, found <{}>",
                       Shown(node->Value()));
      }
    }
    if (robot == nullptr) return ErrorAt(1, "expected <robot>, found no element");
    if (std::string_view(robot->Name()) != "robot") {
      return Error(*robot, "expected <robot>, found <{}>", Shown(robot->Name()));
    }
    return absl::OkStatus();
  }

  absl::Status ReadName(const XMLElement& element, const char* attribute, std::string& name) const {
    const char* value = element.Attribute(attribute);
    if (value == nullptr || *value == '\0') {
      return Error(element, "expected <{}> to have a {}, found none", element.Name(), attribute);
    }
    name = ToUtf8(value);
    return absl::OkStatus();
  }

  template <std::size_t kCount>
  absl::Status ReadNumbers(const XMLElement& element, const char* attribute,
                           const std::array<double*, kCount>& values) const {
    return ReadUrdfNumbers(file_.name, element, attribute, values);
  }

  // Leaves `value` unchanged without the attribute, and if it is 0, which stands for an unknown
  // value.
  absl::Status ReadPositive(const XMLElement& element, const char* attribute,
                            std::string_view owner, double& value) const {
    double read = 0;
    MOTIONDB_RETURN_IF_ERROR(ReadNumbers<1>(element, attribute, {&read}));
    if (read < 0) {
      return Error(element, "{}: expected {} >= 0, found {}", owner, attribute, read);
    }
    if (read > 0) value = read;
    return absl::OkStatus();
  }

  absl::Status ReadInertia(const XMLElement& element, UrdfLink& link) const {
    const XMLElement* inertial = element.FirstChildElement("inertial");
    if (inertial == nullptr) return absl::OkStatus();
    LinkInertia& read = link.inertia;
    if (const XMLElement* mass = inertial->FirstChildElement("mass")) {
      const std::string owner = fmt::format("mass of link '{}'", Shown(link.name));
      MOTIONDB_RETURN_IF_ERROR(ReadPositive(*mass, "value", owner, read.mass_kg));
    }
    UrdfOrigin origin;
    MOTIONDB_RETURN_IF_ERROR(ReadUrdfOrigin(file_.name, *inertial, origin));
    read.centre_m = origin.xyz_m;
    Eigen::Matrix3d& inertia = read.inertia_kg_m2;
    if (const XMLElement* given = inertial->FirstChildElement("inertia")) {
      constexpr std::array<const char*, 6> kNames = {"ixx", "ixy", "ixz", "iyy", "iyz", "izz"};
      constexpr std::array<std::pair<int, int>, 6> kPlaces = {
          {{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}}};
      for (std::size_t i = 0; i < kNames.size(); ++i) {
        const auto [row, column] = kPlaces[i];
        MOTIONDB_RETURN_IF_ERROR(ReadNumbers<1>(*given, kNames[i], {&inertia(row, column)}));
        inertia(column, row) = inertia(row, column);
      }
    }
    const Eigen::Matrix3d turn = FromRollPitchYaw(origin.rpy_rad);
    inertia = turn * inertia * turn.transpose();
    return absl::OkStatus();
  }

  void ReadVisuals(const XMLElement& element, const UrdfMaterials& materials, UrdfLink& link) {
    auto read = ReadLinkVisuals(file_.name, element, materials, visual_count_);
    if (!read.ok()) {
      if (++urdf_.invalid_visual_links == 1) {
        urdf_.first_visual_error = std::string(read.status().message());
      }
      return;
    }
    visual_count_ += read->size();
    link.visuals = *std::move(read);
  }

  absl::Status ReadType(const XMLElement& element, UrdfJoint& joint) const {
    std::string type;
    MOTIONDB_RETURN_IF_ERROR(ReadName(element, "type", type));
    const auto* known = std::find_if(kTypes.begin(), kTypes.end(),
                                     [&](const auto& entry) { return entry.first == type; });
    if (known == kTypes.end()) {
      return Error(element,
                   "joint '{}': expected the type revolute, continuous, prismatic, fixed, "
                   "floating or planar, found '{}'",
                   Shown(joint.name), Shown(type));
    }
    joint.type = known->second;
    return absl::OkStatus();
  }

  absl::Status ReadEnd(const XMLElement& element, const UrdfJoint& joint, const char* end,
                       std::string& link) const {
    const XMLElement* child = element.FirstChildElement(end);
    if (child != nullptr) return ReadName(*child, "link", link);
    return Error(element, "joint '{}': expected <{} link=...>, found none", Shown(joint.name), end);
  }

  absl::Status ReadJoint(const XMLElement& element) {
    UrdfJoint joint;
    joint.line = element.GetLineNum();
    MOTIONDB_RETURN_IF_ERROR(ReadName(element, "name", joint.name));
    // The base counts as one more joint.
    if (urdf_.joints.size() + 1 >= kMaxFileJoints) {
      return Error(element, "expected at most {} joints, found joint '{}' after them",
                   kMaxFileJoints - 1, Shown(joint.name));
    }
    MOTIONDB_RETURN_IF_ERROR(ReadType(element, joint));
    MOTIONDB_RETURN_IF_ERROR(ReadEnd(element, joint, "parent", joint.parent));
    MOTIONDB_RETURN_IF_ERROR(ReadEnd(element, joint, "child", joint.child));
    MOTIONDB_RETURN_IF_ERROR(ReadUrdfOrigin(file_.name, element, joint.origin));
    if (joint.type != UrdfJoint::Type::kFixed) {
      MOTIONDB_RETURN_IF_ERROR(ReadAxis(element, joint));
      MOTIONDB_RETURN_IF_ERROR(ReadLimit(element, joint));
      MOTIONDB_RETURN_IF_ERROR(ReadMimic(element, joint));
    }
    urdf_.joints.push_back(std::move(joint));
    return absl::OkStatus();
  }

  absl::Status ReadAxis(const XMLElement& element, UrdfJoint& joint) const {
    const XMLElement* axis = element.FirstChildElement("axis");
    if (axis == nullptr) return absl::OkStatus();
    MOTIONDB_RETURN_IF_ERROR(ReadUrdfVector(file_.name, *axis, "xyz", joint.axis));
    if (!(joint.axis.norm() >= kMinAxis)) {
      return Error(*axis, "joint '{}': expected a nonzero axis, found '{}'", Shown(joint.name),
                   Shown(axis->Attribute("xyz")));
    }
    joint.axis.normalize();
    return absl::OkStatus();
  }

  absl::Status ReadLimit(const XMLElement& element, UrdfJoint& joint) const {
    const bool continuous = joint.type == UrdfJoint::Type::kContinuous;
    if (joint.type != UrdfJoint::Type::kRevolute && joint.type != UrdfJoint::Type::kPrismatic &&
        !continuous) {
      return absl::OkStatus();
    }
    const XMLElement* limit = element.FirstChildElement("limit");
    if (limit == nullptr && continuous) return absl::OkStatus();
    if (limit == nullptr) {
      return Error(element, "joint '{}': expected <limit>, found none", Shown(joint.name));
    }
    const std::string owner = fmt::format("joint '{}'", Shown(joint.name));
    MOTIONDB_RETURN_IF_ERROR(ReadPositive(*limit, "velocity", owner, joint.max_speed));
    MOTIONDB_RETURN_IF_ERROR(ReadPositive(*limit, "effort", owner, joint.max_effort));
    if (continuous) return absl::OkStatus();
    MOTIONDB_RETURN_IF_ERROR(ReadNumbers<1>(*limit, "lower", {&joint.lower}));
    MOTIONDB_RETURN_IF_ERROR(ReadNumbers<1>(*limit, "upper", {&joint.upper}));
    if (joint.lower <= joint.upper) return absl::OkStatus();
    return Error(*limit, "joint '{}': expected lower <= upper, found {} > {}", Shown(joint.name),
                 joint.lower, joint.upper);
  }

  absl::Status ReadMimic(const XMLElement& element, UrdfJoint& joint) const {
    const XMLElement* mimic = element.FirstChildElement("mimic");
    if (mimic == nullptr) return absl::OkStatus();
    UrdfMimic& made = joint.mimic.emplace();
    MOTIONDB_RETURN_IF_ERROR(ReadName(*mimic, "joint", made.master));
    MOTIONDB_RETURN_IF_ERROR(ReadNumbers<1>(*mimic, "multiplier", {&made.multiplier}));
    return ReadNumbers<1>(*mimic, "offset", {&made.offset});
  }

  SourceFile file_;
  tinyxml2::XMLDocument document_;
  UrdfFile urdf_;
  std::size_t visual_count_ = 0;
};

}  // namespace

absl::StatusOr<UrdfFile> ReadUrdfFile(SourceFile file) { return UrdfFileReader(file).Read(); }

}  // namespace motiondb::core
