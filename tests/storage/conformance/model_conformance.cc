#include "tests/storage/conformance/model_conformance.h"

#include <string>
#include <vector>

#include "core/model/model_builder.h"
#include "tests/storage/faults/store_pages.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"

namespace motiondb::tests {
namespace {

using absl::StatusCode;
using storage::NewClip;

core::Model Extended(const core::Model& model, const NewClip& clip) {
  return Require(core::ExtendModel(
      model, {{clip.record.id, clip.record.label, clip.states, clip.record.subject}},
      core::RunSerially));
}

}  // namespace

void TestModels(StoreUnderTest& store) {
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  REQUIRE_ERROR(store->ReadModel("d", core::RunSerially), StatusCode::kNotFound, "d");
  REQUIRE_ERROR(store->GetModel("d", 1), StatusCode::kNotFound, "1");
  REQUIRE_ERROR(store->ReadModel(kUnknown, core::RunSerially), StatusCode::kNotFound, kUnknown);
  REQUIRE_ERROR(store->ListModels(kUnknown, 0, 10), StatusCode::kNotFound, kUnknown);
  REQUIRE_ERROR(store->DropModel(kUnknown), StatusCode::kNotFound, kUnknown);
  REQUIRE_ERROR(store->FindModelStaleness(kUnknown), StatusCode::kNotFound, kUnknown);
  REQUIRE(Require(store->ListModels("d", 0, 10)).empty());
  REQUIRE_OK(store->DropModel("d"));

  const std::vector<NewClip> clips{SampleClip("d", "walk", 1), SampleClip("d", "run", 2)};
  for (const NewClip& clip : clips) REQUIRE_OK(store->AddClip(clip));
  const core::Model model = SampleModel(clips);  // clips not in order of id
  REQUIRE_ERROR(store->PutModel(kUnknown, model), StatusCode::kNotFound, kUnknown);
  storage::ModelRecord first = Require(store->PutModel("d", model));
  REQUIRE(first.database == "d");
  REQUIRE(first.version == 1);
  REQUIRE(first.current);
  REQUIRE(first.create_time_us == kPutTime);
  REQUIRE(first.build_seconds == 0.25);
  REQUIRE(first.frame_count == 120);
  REQUIRE(first.clip_count == 2);
  REQUIRE(first.dimension_count == 18);
  REQUIRE(static_cast<int>(first.nodes_per_layer.size()) == model.layer_count());
  REQUIRE(first.nodes_per_layer.back() == model.tree().node_count(model.layer_count()));
  REQUIRE(model.layer_count() > 2);
  REQUIRE(Same(Require(store->GetModel("d", 1)), first));
  REQUIRE(Same(Require(store->ReadModel("d", core::RunSerially)), model));

  SECTION("the next model replaces the last one") {
    REQUIRE_OK(store->AddClip(SampleClip("d", "jump", 3)));
    REQUIRE(Same(Require(store->ReadModel("d", core::RunSerially)), model));
    const core::Model next = SampleModel({clips[0], SampleClip("d", "jump", 3)});
    const auto second = Require(store->PutModel("d", next));
    REQUIRE(second.version == 2);
    REQUIRE(Same(Require(store->ReadModel("d", core::RunSerially)), next));
    first.current = false;
    REQUIRE(Same(Require(store->GetModel("d", 1)), first));
    const auto listed = Require(store->ListModels("d", 0, 10));
    REQUIRE(listed.size() == 2);
    REQUIRE(Same(listed[0], second));
    REQUIRE(Same(listed[1], first));
    REQUIRE(Require(store->ListModels("d", 0, 1)).at(0).version == 2);
    REQUIRE(Require(store->ListModels("d", 2, 10)).at(0).version == 1);
    REQUIRE(Require(store->ListModels("d", 1, 10)).empty());
  }
  SECTION("a deleted clip stays only in the model") {
    REQUIRE(Require(store->FindModelStaleness("d")).empty());
    REQUIRE_OK(store->DeleteClip("d", "walk"));
    REQUIRE(Require(store->FindModelStaleness("d")).removed == 1);
    REQUIRE(Require(store->FindModelStaleness("d")).missing.empty());
    REQUIRE(Same(Require(store->ReadModel("d", core::RunSerially)), model));
    REQUIRE_ERROR(store->ReadClipStates("d", "walk"), StatusCode::kNotFound, "walk");
    REQUIRE(ClipIds(store, "d", 10) == std::vector<std::string>{"run"});
    // A new clip with the same id is not the clip of the model.
    REQUIRE(Require(store->AddClip(SampleClip("d", "walk", 9))).id == "walk");
    REQUIRE(Same(Require(store->ReadModel("d", core::RunSerially)), model));
    REQUIRE(Require(store->FindModelStaleness("d")).removed == 1);
    REQUIRE(Require(store->FindModelStaleness("d")).missing == std::vector<std::string>{"walk"});
    const core::Model next = SampleModel({clips[1], SampleClip("d", "walk", 9)});
    REQUIRE(Require(store->PutModel("d", next)).version == 2);
    REQUIRE(Same(Require(store->ReadModel("d", core::RunSerially)), next));
  }
  SECTION("a clip that is deleted or replaced during a build stays in this model only") {
    REQUIRE_OK(store->DeleteClip("d", "walk"));
    REQUIRE(Require(store->PutModel("d", model)).version == 2);
    REQUIRE(Require(store->FindModelStaleness("d")).removed == 1);
    REQUIRE_OK(store->AddClip(SampleClip("d", "walk", 9)));
    REQUIRE(Require(store->PutModel("d", model)).version == 3);
    REQUIRE(Same(Require(store->ReadModel("d", core::RunSerially)), model));
    REQUIRE(Require(store->FindModelStaleness("d")).removed == 1);
    REQUIRE(Require(store->FindModelStaleness("d")).missing == std::vector<std::string>{"walk"});
    const core::Model next = SampleModel({clips[1]});
    REQUIRE(Require(store->PutModel("d", next)).version == 4);
    REQUIRE_ERROR(store->PutModel("d", model), StatusCode::kNotFound, "walk");
    REQUIRE(Same(Require(store->ReadModel("d", core::RunSerially)), next));
    REQUIRE(Require(store->ListModels("d", 0, 10)).size() == 4);
  }
  SECTION("so does a clip that was in no model before") {
    const NewClip jump = SampleClip("d", "jump", 3);
    REQUIRE_OK(store->AddClip(jump));
    const core::Model built = SampleModel({clips[1], jump, clips[0]});
    REQUIRE_OK(store->DeleteClip("d", "jump"));
    REQUIRE(Require(store->PutModel("d", built)).version == 2);
    REQUIRE(Same(Require(store->ReadModel("d", core::RunSerially)), built));
    REQUIRE(ClipIds(store, "d", 10) == std::vector<std::string>{"run", "walk"});
    REQUIRE(Require(store->FindModelStaleness("d")).removed == 1);
  }
  SECTION("deleted clips are purged unless the current model uses them") {
    const NewClip jump = SampleClip("d", "jump", 3);
    REQUIRE_OK(store->AddClip(jump));
    const core::Model built = SampleModel({clips[1], jump});
    REQUIRE_OK(store->DeleteClip("d", "jump"));
    REQUIRE_OK(store->DeleteClip("d", "walk"));
    REQUIRE_OK(store->PurgeDeletedClips("d"));
    REQUIRE_ERROR(store->PutModel("d", built), StatusCode::kNotFound, "jump");
    REQUIRE(Same(Require(store->ReadModel("d", core::RunSerially)), model));
    REQUIRE(Require(store->PutModel("d", model)).version == 2);
    REQUIRE_OK(store->PurgeDeletedClips("d"));
    REQUIRE(Same(Require(store->ReadModel("d", core::RunSerially)), model));
    REQUIRE_ERROR(store->PurgeDeletedClips(kUnknown), StatusCode::kNotFound, kUnknown);
  }
  SECTION("a clip that is deleted and added again is the same clip") {
    REQUIRE_OK(store->DeleteClip("d", "walk"));
    REQUIRE_OK(store->AddClip(clips[0]));
    REQUIRE(Require(store->PutModel("d", model)).version == 2);
    REQUIRE(Same(Require(store->ReadModel("d", core::RunSerially)), model));
  }
  SECTION("an extended model is stored with the build that it extends") {
    const NewClip jump = SampleClip("d", "jump", 3);
    const NewClip hop = SampleClip("d", "hop", 4);
    const core::Model extended = Extended(model, jump);
    REQUIRE_ERROR(store->PutExtension("d", extended, 0.25), StatusCode::kNotFound, "jump");
    REQUIRE_OK(store->AddClip(jump));
    REQUIRE_ERROR(store->PutExtension(kUnknown, extended, 0.25), StatusCode::kNotFound, kUnknown);
    const auto second = Require(store->PutExtension("d", extended, 0.25));
    REQUIRE(second.version == 2);
    REQUIRE(second.current);
    REQUIRE(second.clip_count == 3);
    REQUIRE(second.added_clip_count == 1);
    REQUIRE(second.added_frame_count == jump.record.frame_count);
    REQUIRE(second.drift_fraction == 0.25);
    REQUIRE(Same(Require(store->ReadModel("d", core::RunSerially)), extended));
    first.current = false;
    REQUIRE(Same(Require(store->GetModel("d", 1)), first));
    // A model does not extend itself, nor a build with other clips.
    REQUIRE_ERROR(store->PutExtension("d", extended, 0), StatusCode::kFailedPrecondition, "d");

    REQUIRE_OK(store->AddClip(hop));
    REQUIRE_ERROR(store->PutExtension("d", Extended(model, hop), 0),
                  StatusCode::kFailedPrecondition, "d");
    const core::Model again = Extended(extended, hop);
    REQUIRE(Require(store->FindModelStaleness("d")).missing == std::vector<std::string>{"hop"});
    const auto third = Require(store->PutExtension("d", again, 0.5));
    REQUIRE(Require(store->FindModelStaleness("d")).empty());
    REQUIRE(third.added_clip_count == 2);
    const core::Model read = Require(store->ReadModel("d", core::RunSerially));
    REQUIRE(read.clips().size() == 4);
    REQUIRE(read.states() == again.states());
    REQUIRE(read.tree().frame_order() == again.tree().frame_order());

    // Delete a clip of the build and an added clip: both stay in the model.
    REQUIRE_OK(store->DeleteClip("d", "walk"));
    REQUIRE_OK(store->DeleteClip("d", "hop"));
    REQUIRE(Require(store->ReadModel("d", core::RunSerially)).clips().size() == 4);
    const core::Model next = SampleModel({clips[1], jump});
    REQUIRE(Require(store->PutModel("d", next)).version == 4);
    REQUIRE(Same(Require(store->ReadModel("d", core::RunSerially)), next));
    REQUIRE(Require(store->GetModel("d", 4)).added_clip_count == 0);
    REQUIRE(Require(store->ListModels("d", 0, 10)).size() == 4);
  }
  SECTION("only the current model can be extended") {
    const NewClip jump = SampleClip("d", "jump", 3);
    REQUIRE_OK(store->AddClip(jump));
    REQUIRE_OK(store->DropModel("d"));
    REQUIRE(Require(store->FindModelStaleness("d")).missing ==
            std::vector<std::string>{"jump", "run", "walk"});
    REQUIRE_ERROR(store->PutExtension("d", Extended(model, jump), 0),
                  StatusCode::kFailedPrecondition, "d");
  }
  SECTION("after DropModel the record stays and versions continue") {
    REQUIRE_OK(store->DeleteClip("d", "walk"));
    REQUIRE_OK(store->DeleteClip("d", "run"));
    REQUIRE_OK(store->DropModel("d"));
    REQUIRE_ERROR(store->ReadModel("d", core::RunSerially), StatusCode::kNotFound, "d");
    first.current = false;
    REQUIRE(Same(Require(store->GetModel("d", 1)), first));
    for (const NewClip& clip : clips) REQUIRE_OK(store->AddClip(clip));
    REQUIRE(Require(store->PutModel("d", model)).version == 2);
  }
}

}  // namespace motiondb::tests
