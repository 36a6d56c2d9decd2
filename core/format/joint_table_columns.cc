#include <algorithm>
#include <cstddef>
#include <unordered_map>
#include <utility>

#include "core/format/conventions.h"
#include "core/format/joint_table.h"
#include "core/format/text_scanner.h"
#include "core/format/urdf_file.h"
#include "core/motion/error.h"

namespace motiondb::core {
namespace {

constexpr std::array<std::string_view, 3> kRootTranslate = {"root_translateX", "root_translateY",
                                                            "root_translateZ"};
constexpr std::array<std::string_view, 3> kRootRotate = {"root_rotateX", "root_rotateY",
                                                         "root_rotateZ"};
constexpr std::array<std::string_view, 4> kRootQuaternion = {"root_qx", "root_qy", "root_qz",
                                                             "root_qw"};
constexpr std::array<std::string_view, 3> kRootPosition = {"root_x_", "root_y_", "root_z_"};
constexpr int kRootColumns = 7;  // of a table without header

template <typename Names>
int IndexIn(const Names& names, std::string_view name) {
  const auto at = std::find(names.begin(), names.end(), name);
  return at == names.end() ? -1 : static_cast<int>(at - names.begin());
}

// "'a', 'b', 'c' and 4 more".
std::string ListOfJoints(const std::vector<std::string>& names) {
  constexpr std::size_t kShown = 3;
  std::string list;
  for (std::size_t i = 0; i < std::min(kShown, names.size()); ++i) {
    list += fmt::format("{}'{}'", i == 0 ? "" : ", ", Shown(names[i]));
  }
  if (names.size() > kShown) list += fmt::format(" and {} more", names.size() - kShown);
  return list;
}

// The columns that the joints of a robot can have, with the names of WriteJointTable.
class JointNames {
 public:
  explicit JointNames(const UrdfRobot& robot) {
    const Skeleton& skeleton = robot.skeleton;
    for (int j = 1; j < skeleton.joint_count(); ++j) {
      const Joint& joint = skeleton.joints()[j];
      const auto count = static_cast<int>(joint.dofs.size());
      for (int k = 0; k < count; ++k) {
        Add(count == 1 ? joint.name : fmt::format("{}/{}", joint.name, k + 1),
            {.dof = skeleton.first_dof(j) + k, .unit = {}});
      }
    }
    for (const MimicJoint& mimic : robot.mimics) {
      const int master = skeleton.FindJoint(mimic.master);
      if (master < 0) continue;
      Add(mimic.joint, {.dof = skeleton.first_dof(master), .mimic = &mimic, .unit = {}});
    }
  }

  // Returns the joint of a column, without its number. The name may end in a unit, or in "_dof" as
  // in BONES-SEED.
  std::optional<JointColumn> Find(const std::string& name) const {
    struct Ending {
      std::string_view text;
      std::optional<AngleUnit> unit;
    };
    for (const Ending& ending :
         {Ending{"", std::nullopt}, Ending{"_dof", std::nullopt}, Ending{"_m", std::nullopt},
          Ending{"_rad", AngleUnit::kRadians}, Ending{"_deg", AngleUnit::kDegrees}}) {
      if (!name.ends_with(ending.text)) continue;
      const auto at = columns_.find(name.substr(0, name.size() - ending.text.size()));
      if (at == columns_.end()) continue;
      JointColumn column = at->second;
      column.unit = ending.unit;
      return column;
    }
    return std::nullopt;
  }

  // All names, mimic joints last, in the skeleton's order.
  const std::vector<std::string>& names() const { return names_; }

 private:
  void Add(const std::string& joint, const JointColumn& column) {
    // As CsvRows returns it.
    const auto first = joint.find_first_not_of(' ');
    std::string name =
        first == joint.npos ? joint : joint.substr(first, joint.find_last_not_of(' ') - first + 1);
    if (columns_.emplace(name, column).second) names_.push_back(std::move(name));
  }

  std::unordered_map<std::string, JointColumn> columns_;
  std::vector<std::string> names_;
};

// Reads the columns of time and root.
class RootColumns {
 public:
  RootColumns(const CsvRows& rows, JointTableColumns& columns) : rows_(rows), columns_(columns) {}

  // Whether the column is one of these.
  absl::StatusOr<bool> Take(int column, const std::string& name) {
    if (name == "time_s") {
      columns_.time = column;
    } else if (const int part = IndexIn(kRootQuaternion, name); part >= 0) {
      quaternion_[part] = column;
    } else if (const int angle = IndexIn(kRootRotate, name); angle >= 0) {
      rotate_[angle] = column;
    } else if (const int axis = IndexIn(kRootTranslate, name); axis >= 0) {
      columns_.position[axis] = column;
    } else {
      return TakePosition(column, name);
    }
    return true;
  }

  absl::Status Check() {
    const auto lacks = [](const auto& some) {
      return std::find(some.begin(), some.end(), -1) != some.end();
    };
    const bool seed = columns_.layout == TableLayout::kBonesSeed;
    if (lacks(columns_.position)) {
      return rows_.Error("expected columns {}", seed ? "root_translateX, root_translateY and "
                                                       "root_translateZ"
                                                     : "root_x_m, root_y_m and root_z_m");
    }
    if (!lacks(quaternion_)) {
      columns_.rotation.assign(quaternion_.begin(), quaternion_.end());
    } else if (!lacks(rotate_)) {
      columns_.rotation.assign(rotate_.begin(), rotate_.end());
    } else {
      return rows_.Error("expected columns {}", seed ? "root_rotateX, root_rotateY and root_rotateZ"
                                                     : "root_qx, root_qy, root_qz and root_qw");
    }
    return absl::OkStatus();
  }

 private:
  // "root_x_m", or with another unit.
  absl::StatusOr<bool> TakePosition(int column, const std::string& name) {
    for (std::size_t axis = 0; axis < kRootPosition.size(); ++axis) {
      if (!name.starts_with(kRootPosition[axis])) continue;
      const auto unit = MetresPerUnitNamed(name.substr(kRootPosition[axis].size()));
      if (!unit) return false;
      if (unit != columns_.metres_per_unit.value_or(*unit)) {
        return rows_.Error("expected one unit for the position of the root, found column '{}'",
                           Shown(name));
      }
      columns_.metres_per_unit = unit;
      columns_.position[axis] = column;
      return true;
    }
    return false;
  }

  const CsvRows& rows_;
  JointTableColumns& columns_;
  std::array<int, 4> quaternion_ = {-1, -1, -1, -1};
  std::array<int, 3> rotate_ = {-1, -1, -1};
};

absl::Status CheckJointsOfHeader(const CsvRows& rows, const std::vector<std::string>& missing,
                                 const std::vector<std::string>& unknown) {
  if (missing.empty() && unknown.empty()) return absl::OkStatus();
  std::string found;
  if (!missing.empty()) found = "no column for " + ListOfJoints(missing);
  if (!unknown.empty()) {
    found += fmt::format("{}{}, not joints of the URDF", found.empty() ? "" : ", and ",
                         ListOfJoints(unknown));
  }
  return rows.Error("expected a column for each joint of the URDF, found {}", found);
}

}  // namespace

bool IsJointTableHeader(std::span<const std::string> header) {
  const auto has = [&](std::string_view name) { return IndexIn(header, name) >= 0; };
  return std::any_of(kRootQuaternion.begin(), kRootQuaternion.end(), has) ||
         std::any_of(kRootTranslate.begin(), kRootTranslate.end(), has) ||
         std::any_of(kRootRotate.begin(), kRootRotate.end(), has);
}

absl::StatusOr<JointTableColumns> ColumnsOfHeader(const CsvRows& rows,
                                                  std::span<const std::string> header,
                                                  const UrdfRobot& robot) {
  const JointNames joints(robot);
  JointTableColumns columns;
  columns.layout = IndexIn(header, kRootTranslate[0]) >= 0 || IndexIn(header, kRootRotate[0]) >= 0
                       ? TableLayout::kBonesSeed
                       : TableLayout::kMotiondb;
  RootColumns root(rows, columns);
  std::unordered_map<std::string_view, int> seen;  // names, with their columns
  std::vector<std::string> unknown;
  // For each degree of freedom, its column, and the same for mimic joints.
  std::unordered_map<int, int> of_dof;
  std::unordered_map<const MimicJoint*, int> of_mimic;
  for (int c = 0; c < static_cast<int>(header.size()); ++c) {
    const std::string& name = header[c];
    if (!seen.emplace(name, c).second) {
      return rows.Error("expected columns of different names, found '{}' twice", Shown(name));
    }
    MOTIONDB_ASSIGN_OR_RETURN(const bool is_root, root.Take(c, name));
    if (is_root) continue;
    std::optional<JointColumn> joint = joints.Find(name);
    if (!joint && IsKeyword(name, "frame")) {
      columns.frame = c;
      continue;
    }
    if (!joint) {
      unknown.push_back(name);
      continue;
    }
    joint->column = c;
    const bool first = joint->mimic == nullptr ? of_dof.emplace(joint->dof, c).second
                                               : of_mimic.emplace(joint->mimic, c).second;
    if (!first) {
      return rows.Error("expected one column for each joint, found '{}' after another",
                        Shown(name));
    }
    columns.joints.push_back(*joint);
  }
  MOTIONDB_RETURN_IF_ERROR(root.Check());
  std::vector<std::string> missing;
  for (const std::string& name : joints.names()) {
    const std::optional<JointColumn> joint = joints.Find(name);
    if (joint->mimic == nullptr && !of_dof.contains(joint->dof)) missing.push_back(name);
  }
  MOTIONDB_RETURN_IF_ERROR(CheckJointsOfHeader(rows, missing, unknown));
  columns.names.assign(header.begin(), header.end());
  return columns;
}

absl::StatusOr<JointTableColumns> ColumnsWithoutHeader(const CsvRows& rows, int width,
                                                       SourceFile urdf, const UrdfRobot& robot) {
  MOTIONDB_ASSIGN_OR_RETURN(const UrdfFile file, ReadUrdfFile(urdf));
  const Skeleton& skeleton = robot.skeleton;
  std::unordered_map<std::string_view, int> joint_index;
  for (int j = 1; j < skeleton.joint_count(); ++j) {
    joint_index.emplace(skeleton.joints()[j].name, j);
  }
  std::unordered_map<std::string_view, const MimicJoint*> mimics;
  for (const MimicJoint& mimic : robot.mimics) mimics.emplace(mimic.joint, &mimic);

  std::vector<JointColumn> all;
  std::vector<std::string_view> names;  // of all
  for (const UrdfJoint& urdf_joint : file.joints) {
    const auto at = joint_index.find(urdf_joint.name);
    if (at == joint_index.end()) continue;  // the base
    if (const auto mimic = mimics.find(urdf_joint.name); mimic != mimics.end()) {
      const int master = skeleton.FindJoint(mimic->second->master);
      all.push_back({.dof = skeleton.first_dof(master), .mimic = mimic->second, .unit = {}});
      names.push_back(urdf_joint.name);
      continue;
    }
    const auto count = static_cast<int>(skeleton.joints()[at->second].dofs.size());
    for (int k = 0; k < count; ++k) {
      all.push_back({.dof = skeleton.first_dof(at->second) + k, .unit = {}});
      names.push_back(urdf_joint.name);
    }
  }
  const auto with_mimics = static_cast<int>(all.size());
  const auto without = static_cast<int>(
      std::count_if(all.begin(), all.end(), [](const auto& c) { return c.mimic == nullptr; }));
  if (width != kRootColumns + without && width != kRootColumns + with_mimics) {
    const std::string or_more =
        with_mimics == without
            ? ""
            : fmt::format(" (or {} with its mimic joints)", kRootColumns + with_mimics);
    return rows.Error(
        "expected {} numbers{}: position and quaternion of the root and {} joints of the URDF, "
        "found {} cells",
        kRootColumns + without, or_more, without, width);
  }

  JointTableColumns columns;
  columns.position = {0, 1, 2};
  columns.rotation = {3, 4, 5, 6};
  columns.names = {"root x", "root y", "root z", "root qx", "root qy", "root qz", "root qw"};
  bool in_order = true;
  int last_dof = -1;
  for (std::size_t i = 0; i < all.size(); ++i) {
    JointColumn& joint = all[i];
    if (joint.mimic != nullptr && width != kRootColumns + with_mimics) continue;
    if (joint.mimic == nullptr) {
      in_order = in_order && joint.dof > last_dof;
      last_dof = joint.dof;
    }
    joint.column = static_cast<int>(columns.names.size());
    columns.joints.push_back(joint);
    columns.names.emplace_back(names[i]);
  }
  if (!in_order) {
    columns.notes.push_back("columns are in the order of the joints in the URDF file");
  }
  return columns;
}

}  // namespace motiondb::core
