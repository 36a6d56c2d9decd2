// Reads GLB files that we write, and checks their structure against the specification.
#pragma once

#include <Eigen/Geometry>
#include <bit>
#include <catch2/catch.hpp>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace motiondb::tests {

// A file of a JSON chunk and a binary chunk. REQUIREs both, with lengths and padding.
class GlbFile {
 public:
  explicit GlbFile(std::string_view bytes) {
    REQUIRE(bytes.size() >= 28);
    REQUIRE(bytes.substr(0, 4) == "glTF");
    REQUIRE(Word(bytes, 4) == 2);
    REQUIRE(Word(bytes, 8) == bytes.size());
    const std::size_t json_size = Word(bytes, 12);
    REQUIRE(json_size % 4 == 0);
    REQUIRE(bytes.substr(16, 4) == "JSON");
    REQUIRE(bytes.size() >= 28 + json_size);
    json = nlohmann::json::parse(bytes.substr(20, json_size));
    REQUIRE(Word(bytes, 20 + json_size) == bytes.size() - 28 - json_size);
    REQUIRE(bytes.substr(24 + json_size, 4) == std::string_view("BIN\0", 4));
    buffer = bytes.substr(28 + json_size);
    REQUIRE(json["buffers"].size() == 1);
    REQUIRE(json["buffers"][0]["byteLength"] == buffer.size());
    REQUIRE(buffer.size() % 4 == 0);
  }

  // Returns the elements of an accessor, one a column.
  Eigen::MatrixXd Read(std::size_t index) const {
    const nlohmann::json& accessor = json["accessors"].at(index);
    const nlohmann::json& view = json["bufferViews"].at(accessor["bufferView"].get<std::size_t>());
    const int rows = ComponentCount(accessor["type"]);
    const std::size_t size = ComponentSize(accessor["componentType"]);
    const auto count = accessor["count"].get<Eigen::Index>();
    const std::size_t in_view = accessor.value("byteOffset", std::size_t{0});
    const std::size_t offset = view["byteOffset"].get<std::size_t>() + in_view;
    const std::size_t bytes = size * static_cast<std::size_t>(rows * count);
    REQUIRE(count > 0);
    REQUIRE(offset % size == 0);
    REQUIRE(in_view + bytes <= view["byteLength"].get<std::size_t>());
    REQUIRE(offset + bytes <= buffer.size());
    Eigen::MatrixXd values(rows, count);
    for (Eigen::Index i = 0; i < values.size(); ++i) {
      const std::size_t at = offset + size * static_cast<std::size_t>(i);
      values.data()[i] = size == 2 ? Word(buffer, at) & 0xFFFF
                                   : static_cast<double>(std::bit_cast<float>(Word(buffer, at)));
    }
    return values;
  }

  // REQUIREs that views follow each other, and that accessors fill them, are finite and within
  // exact bounds.
  void CheckAccessors() const {
    std::size_t end = 0;
    for (const auto& view : json["bufferViews"]) {
      REQUIRE(view["buffer"] == 0);
      REQUIRE(view["byteOffset"] == end);
      REQUIRE(end % 4 == 0);
      end += view["byteLength"].get<std::size_t>();
    }
    REQUIRE(end == buffer.size());
    for (std::size_t a = 0; a < json["accessors"].size(); ++a) {
      CAPTURE(a);
      const Eigen::MatrixXd values = Read(a);
      REQUIRE(values.allFinite());
      if (!json["accessors"][a].contains("min")) continue;
      for (Eigen::Index row = 0; row < values.rows(); ++row) {
        const auto component = static_cast<std::size_t>(row);
        REQUIRE(json["accessors"][a]["min"].at(component) == values.row(row).minCoeff());
        REQUIRE(json["accessors"][a]["max"].at(component) == values.row(row).maxCoeff());
      }
    }
  }

  // Returns the transforms of the nodes to the scene, with the keys of a frame; at rest if it is
  // negative.
  std::vector<Eigen::Isometry3d> WorldPoses(Eigen::Index frame) const {
    const std::size_t count = json["nodes"].size();
    std::vector<Eigen::Vector3d> translations(count, Eigen::Vector3d::Zero());
    std::vector<Eigen::Quaterniond> rotations(count, Eigen::Quaterniond::Identity());
    for (std::size_t n = 0; n < count; ++n) {
      const auto t = json["nodes"][n].value("translation", std::vector<double>{0, 0, 0});
      const auto r = json["nodes"][n].value("rotation", std::vector<double>{0, 0, 0, 1});
      translations[n] = Eigen::Vector3d(t.data());
      rotations[n] = Eigen::Quaterniond(r.data());
    }
    for (const auto& channel : json["animations"][0]["channels"]) {
      if (frame < 0) break;
      const auto& sampler = json["animations"][0]["samplers"].at(channel["sampler"].get<int>());
      const Eigen::MatrixXd keys = Read(sampler["output"]);
      const auto node = channel["target"]["node"].get<std::size_t>();
      if (channel["target"]["path"] == "translation") {
        translations.at(node) = keys.col(frame);
      } else {
        rotations.at(node) = Eigen::Quaterniond(Eigen::Vector4d(keys.col(frame)));
      }
    }
    std::vector<Eigen::Isometry3d> poses(count, Eigen::Isometry3d::Identity());
    std::vector<int> visits(count);
    const auto visit = [&](const auto& self, std::size_t node,
                           const Eigen::Isometry3d& parent) -> void {
      ++visits.at(node);
      poses[node] = parent * Eigen::Translation3d(translations[node]) * rotations[node];
      const auto children = json["nodes"][node].value("children", std::vector<std::size_t>{});
      for (const std::size_t child : children) self(self, child, poses[node]);
    };
    for (const auto& root : json["scenes"][0]["nodes"]) {
      visit(visit, root, Eigen::Isometry3d::Identity());
    }
    REQUIRE(visits == std::vector<int>(count, 1));  // a tree
    return poses;
  }

  nlohmann::json json;
  std::string_view buffer;  // in the file's bytes, which the caller keeps

 private:
  static std::uint32_t Word(std::string_view bytes, std::size_t offset) {
    std::uint32_t word = 0;
    std::memcpy(&word, bytes.data() + offset, std::min<std::size_t>(4, bytes.size() - offset));
    return word;
  }
  static int ComponentCount(const std::string& type) {
    return type == "SCALAR" ? 1 : type == "VEC3" ? 3 : type == "VEC4" ? 4 : 16;
  }
  static std::size_t ComponentSize(int type) {
    REQUIRE((type == 5123 || type == 5126));
    return type == 5123 ? 2 : 4;
  }
};

}  // namespace motiondb::tests
