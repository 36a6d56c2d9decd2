#include "tests/import/scene/scene_player.h"

#include <algorithm>
#include <limits>

namespace motiondb::tests {

namespace {

template <typename Key, typename Blend>
auto ValueAt(const Key* keys, unsigned count, double ticks, const Blend& blend) {
  const Key* const next =
      std::find_if(keys, keys + count, [&](const Key& key) { return key.mTime > ticks; });
  if (next == keys) return keys[0].mValue;
  if (next == keys + count) return keys[count - 1].mValue;
  const Key& last = next[-1];
  return blend(last.mValue, next->mValue,
               static_cast<float>((ticks - last.mTime) / (next->mTime - last.mTime)));
}

aiVector3D VectorAt(const aiVectorKey* keys, unsigned count, double ticks) {
  return ValueAt(keys, count, ticks,
                 [](const aiVector3D& a, const aiVector3D& b, float t) { return a + (b - a) * t; });
}

}  // namespace

ScenePlayer::ScenePlayer(const aiScene& scene, unsigned animation)
    : scene_(scene), animation_(*scene.mAnimations[animation]) {
  for (unsigned c = 0; c < animation_.mNumChannels; ++c) {
    channels_[animation_.mChannels[c]->mNodeName.C_Str()] = animation_.mChannels[c];
  }
}

double ScenePlayer::FirstTick() const {
  double first = std::numeric_limits<double>::infinity();
  for (const auto& [name, channel] : channels_) {
    if (channel->mNumPositionKeys > 1) first = std::min(first, channel->mPositionKeys[0].mTime);
    if (channel->mNumRotationKeys > 1) first = std::min(first, channel->mRotationKeys[0].mTime);
    if (channel->mNumScalingKeys > 1) first = std::min(first, channel->mScalingKeys[0].mTime);
  }
  return std::max(first, 0.0);
}

std::map<std::string, Eigen::Vector3d> ScenePlayer::At(double ticks) const {
  std::map<std::string, Eigen::Vector3d> positions;
  Visit(*scene_.mRootNode, aiMatrix4x4(), ticks, positions);
  return positions;
}

aiMatrix4x4 ScenePlayer::Local(const aiNode& node, double ticks) const {
  const auto found = channels_.find(node.mName.C_Str());
  if (found == channels_.end()) return node.mTransformation;
  const aiNodeAnim& channel = *found->second;
  const aiQuaternion turn = ValueAt(channel.mRotationKeys, channel.mNumRotationKeys, ticks,
                                    [](const aiQuaternion& a, const aiQuaternion& b, float t) {
                                      aiQuaternion between;
                                      aiQuaternion::Interpolate(between, a, b, t);
                                      return between;
                                    });
  aiMatrix4x4 move;
  aiMatrix4x4 scale;
  aiMatrix4x4::Translation(VectorAt(channel.mPositionKeys, channel.mNumPositionKeys, ticks), move);
  aiMatrix4x4::Scaling(VectorAt(channel.mScalingKeys, channel.mNumScalingKeys, ticks), scale);
  aiQuaternion unit = turn;
  return move * aiMatrix4x4(unit.Normalize().GetMatrix()) * scale;
}

void ScenePlayer::Visit(const aiNode& node, const aiMatrix4x4& above, double ticks,
                        std::map<std::string, Eigen::Vector3d>& positions) const {
  const aiMatrix4x4 here = above * Local(node, ticks);
  positions[node.mName.C_Str()] = {here.a4, here.b4, here.c4};
  for (unsigned c = 0; c < node.mNumChildren; ++c) {
    Visit(*node.mChildren[c], here, ticks, positions);
  }
}

}  // namespace motiondb::tests
