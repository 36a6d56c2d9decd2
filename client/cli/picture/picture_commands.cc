// motiondb picture map|layer|clip: pictures of a model.

#include <fmt/format.h>

#include <string>
#include <vector>

#include "client/cli/picture/picture_geometry.h"
#include "client/cli/picture/picture_options.h"
#include "client/cli/resource_name.h"

namespace motiondb::client {

namespace {

struct ModelPictureOptions {
  std::string database;
  std::string clip;
  int layer = 0;
  int points = 5000;
  bool no_poses = false;
  int poses = 0;
  MapOptions map;
  std::string out;
};

void DeclareModelPicture(CLI::App& command, ModelPictureOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
  AddOutOption(command, options.out);
  AddMapLayerOption(command, options.layer);
}

void DeclareMapPicture(CLI::App& command, ModelPictureOptions& options) {
  DeclareModelPicture(command, options);
  AddMapOptions(command, options.map);
  command.add_option("--points", options.points, "Maximum number of frames as points")
      ->type_name("N")
      ->check(CLI::Range(0, 100000))
      ->capture_default_str();
  command.add_flag("--no-poses", options.no_poses,
                   "Omit the mean poses of the nodes at the ends of the axes");
}

void DeclareLayerPicture(CLI::App& command, ModelPictureOptions& options) {
  DeclareModelPicture(command, options);
  AddMapOptions(command, options.map);
}

void DeclareClipPicture(CLI::App& command, ModelPictureOptions& options) {
  DeclareModelPicture(command, options);
  command.add_option("CLIP", options.clip, "Clip")->required();
  AddMapOptions(command, options.map);
  command.add_option("--poses", options.poses, "Number of poses to draw along the clip")
      ->type_name("N")
      ->check(CLI::Range(0, 20))
      ->capture_default_str();
}

absl::Status RunMapPicture(const ModelPictureOptions& options, const GlobalOptions& global) {
  if (absl::Status status = CheckOut(options.out); !status.ok()) return status;
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  const auto map = ReadMap(*client, options.database, options.layer, "", options.points);
  if (!map.ok()) return map.status();
  std::vector<MeanPose> poses;
  Bones bones;
  if (!options.no_poses) {
    std::vector<int> ids;
    for (const ExtremeNode& extreme : ExtremeNodes(*map, options.map.axes)) {
      ids.push_back(map->nodes()[static_cast<std::size_t>(extreme.node)].id);
    }
    auto mean_poses = ReadMeanPoses(*client, options.database, map->layer(), ids);
    if (!mean_poses.ok()) return mean_poses.status();
    poses = *std::move(mean_poses);
    auto read = ReadBones(*client, options.database);
    if (!read.ok()) return read.status();
    bones = *std::move(read);
  }
  return WriteOut(options.out,
                  MapPicture(*map, ShortName(options.database), options.map, poses, bones), global);
}

absl::Status RunLayerPicture(const ModelPictureOptions& options, const GlobalOptions& global) {
  if (absl::Status status = CheckOut(options.out); !status.ok()) return status;
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  const auto map = ReadMap(*client, options.database, options.layer, "", 0);
  if (!map.ok()) return map.status();
  return WriteOut(options.out, LayerPicture(*map, ShortName(options.database), options.map),
                  global);
}

absl::Status RunClipPicture(const ModelPictureOptions& options, const GlobalOptions& global) {
  if (absl::Status status = CheckOut(options.out); !status.ok()) return status;
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  const std::string clip = ClipName(options.database, options.clip);
  const auto map = ReadMap(*client, options.database, options.layer, "", 0);
  if (!map.ok()) return map.status();
  const auto clip_map = ReadMap(*client, options.database, options.layer, clip, 0);
  if (!clip_map.ok()) return clip_map.status();
  std::vector<ClipMoment> moments;
  Bones bones;
  if (options.poses > 0) {
    auto read_moments = ReadMoments(*client, clip, options.poses);
    if (!read_moments.ok()) return read_moments.status();
    moments = *std::move(read_moments);
    auto read_bones = ReadBones(*client, options.database);
    if (!read_bones.ok()) return read_bones.status();
    bones = *std::move(read_bones);
  }
  return WriteOut(options.out,
                  ClipPicture(*map, *clip_map, ShortName(clip), options.map, moments, bones),
                  global);
}

}  // namespace

void AddPictureCommand(CommandLine line) {
  const CommandLine inner =
      AddCommandGroup(line, "picture", "Draw pictures of a database as SVG or PNG, as in the paper",
                      "motiondb picture map walks --out map.svg\n"
                      "motiondb picture clip walks 07_01 --poses 8 --out clip.png");
  AddCommand<ModelPictureOptions>(
      inner, "map", "Draw the states in principal axes (Figs. 6-8)",
      "motiondb picture map walks --out map.svg\n"
      "motiondb picture map walks --axes 1,3 --colour clip --out map.png\n"
      "motiondb picture map walks --axes 1,2,3 --no-poses --out map.svg",
      DeclareMapPicture, RunMapPicture);
  AddCommand<ModelPictureOptions>(inner, "layer",
                                  "Draw the nodes and transitions of a layer (Fig. 9)",
                                  "motiondb picture layer walks --layer 4 --out layer.svg",
                                  DeclareLayerPicture, RunLayerPicture);
  AddCommand<ModelPictureOptions>(
      inner, "clip", "Draw the transition graph of a clip (Fig. 10)",
      "motiondb picture clip walks 07_01 --out clip.svg\n"
      "motiondb picture clip walks 07_01 --layer 6 --poses 8 --out clip.png",
      DeclareClipPicture, RunClipPicture);
  AddQueryPictureCommands(inner);
}

}  // namespace motiondb::client
