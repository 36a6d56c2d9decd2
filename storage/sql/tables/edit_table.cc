#include "storage/sql/tables/edit_table.h"

#include <fmt/ranges.h>

#include <functional>
#include <limits>
#include <map>
#include <set>
#include <string_view>
#include <utility>
#include <variant>

#include "core/motion/error.h"
#include "storage/blob/annotation_codec.h"
#include "storage/edit_plan.h"
#include "storage/sql/tables/change_feed.h"
#include "storage/sql/tables/chunk_table.h"
#include "storage/sql/tables/clip_row.h"
#include "storage/sql/tables/clip_text.h"
#include "storage/sql/tables/database_table.h"
#include "storage/sql/tables/segment_table.h"

namespace motiondb::storage {
namespace {

// Returns whether the searched text of a clip can change. (The times of a segment are not in it.)
bool ChangesText(const EditedObject& object) {
  if (!object.before || !object.after) return true;
  const auto* const before = std::get_if<SegmentRecord>(&*object.before);
  return before == nullptr || before->label != std::get<SegmentRecord>(*object.after).label;
}

// Makes one edit of a database.
class EditWriter {
 public:
  EditWriter(Connection& connection, const std::string& database)
      : connection_(connection), database_(database) {}

  // `plan` returns what the edit changes, with a stamp.
  using Plan = std::function<absl::StatusOr<std::vector<EditedObject>>(const LoadClip& load,
                                                                       const ChangeStamp& stamp)>;
  absl::StatusOr<EditRecord> Run(const Plan& plan, const std::string& author,
                                 std::int64_t time_us) {
    MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key,
                              FindDatabase(connection_, database_));
    MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t revision, SelectRevision(connection_, database_));
    const LoadClip load = [this](const std::string& clip) { return Load(clip); };
    EditRecord edit;
    edit.database = database_;
    edit.author = author;
    edit.time_us = time_us;
    MOTIONDB_ASSIGN_OR_RETURN(edit.objects, plan(load, {author, time_us, revision + 1}));
    if (edit.objects.empty()) return edit;
    MOTIONDB_ASSIGN_OR_RETURN(edit.id, NextRevision(connection_, database_key));
    MOTIONDB_RETURN_IF_ERROR(Store(edit));
    MOTIONDB_RETURN_IF_ERROR(Insert(database_key, edit));
    return edit;
  }

 private:
  absl::StatusOr<AnnotatedClip> Load(const std::string& clip) {
    MOTIONDB_ASSIGN_OR_RETURN(const ClipRef ref, FindClip(connection_, database_, clip));
    AnnotatedClip loaded;
    MOTIONDB_ASSIGN_OR_RETURN(loaded.record, SelectClip(connection_, database_, clip));
    MOTIONDB_ASSIGN_OR_RETURN(loaded.segments, SelectSegments(connection_, ref));
    clips_[clip] = ref;
    return loaded;
  }

  // Stores the changed objects.
  absl::Status Store(const EditRecord& edit) {
    std::set<std::string> changed_texts;
    for (const EditedObject& object : edit.objects) {
      const std::string& clip = ClipOf(object);
      const ClipRef& ref = clips_.at(clip);
      if (ChangesText(object)) changed_texts.insert(clip);
      if (object.after && std::holds_alternative<ClipRecord>(*object.after)) {
        const auto& record = std::get<ClipRecord>(*object.after);
        MOTIONDB_RETURN_IF_ERROR(UpdateAnnotations(connection_, ref.clip_key, record));
      } else {
        MOTIONDB_RETURN_IF_ERROR(StoreSegment(ref, object, edit.id));
      }
    }
    for (const std::string& clip : changed_texts) {
      MOTIONDB_RETURN_IF_ERROR(UpdateText(clips_.at(clip)));
    }
    return connection_.FlushTexts();
  }

  absl::Status StoreSegment(const ClipRef& ref, const EditedObject& object, std::int64_t revision) {
    if (!object.after) {
      const std::string& id = std::get<SegmentRecord>(*object.before).id;
      MOTIONDB_RETURN_IF_ERROR(DeleteSegment(connection_, ref.clip_key, id));
      return BurySegment(connection_, ref, id, revision);
    }
    const auto& segment = std::get<SegmentRecord>(*object.after);
    if (object.before) return UpdateSegment(connection_, ref.clip_key, segment);
    MOTIONDB_RETURN_IF_ERROR(UnburySegment(connection_, ref, segment.id));
    return InsertSegments(connection_, ref, std::span(&segment, 1));
  }

  absl::Status UpdateText(const ClipRef& ref) {
    MOTIONDB_ASSIGN_OR_RETURN(const ClipRecord record,
                              SelectClip(connection_, database_, ref.clip));
    MOTIONDB_ASSIGN_OR_RETURN(const auto segments, SelectSegments(connection_, ref));
    return UpdateClipText(connection_, ref.clip_key, TextOf(record, segments));
  }

  absl::Status Insert(std::int64_t database_key, const EditRecord& edit) {
    std::set<std::string> changed;
    for (const EditedObject& object : edit.objects) changed.insert(ClipOf(object));
    const std::string clips = fmt::format("/{}/", fmt::join(changed, "/"));
    MOTIONDB_ASSIGN_OR_RETURN(const std::string objects, EncodeObjects(edit.objects));
    std::int64_t number = 0;
    {
      Statement last = connection_.Query(
          "SELECT COALESCE(max(number), 0) FROM edit WHERE database_key = ?", database_key);
      MOTIONDB_RETURN_IF_ERROR(last.Step().status());
      number = last.Integer(0) + 1;
    }
    MOTIONDB_RETURN_IF_ERROR(connection_.InsertRow(
        "edit",
        "INSERT INTO edit (database_key, number, revision, author, time_us, clips, "
        "objects) VALUES (?, ?, ?, ?, ?, ?, ?)",
        database_key, number, edit.id, edit.author, edit.time_us, clips,
        std::as_bytes(std::span(objects))));
    // Numbers have no gaps, so exactly kEditsKept rows stay.
    return connection_
        .Query("DELETE FROM edit WHERE database_key = ? AND number <= ?", database_key,
               number - kEditsKept)
        .Run();
  }

  Connection& connection_;
  const std::string& database_;
  std::map<std::string, ClipRef> clips_;  // loaded ones
};

// Returns a query for the columns that ToEdit reads.
std::string SelectEditColumns(std::string_view rest) {
  return fmt::format(
      "SELECT name, edit.revision, author, time_us, objects FROM edit JOIN database USING "
      "(database_key) WHERE {}",
      rest);
}

absl::StatusOr<EditRecord> ToEdit(const Statement& row) {
  EditRecord edit;
  edit.database = row.Text(0);
  edit.id = row.Integer(1);
  edit.author = row.Text(2);
  edit.time_us = row.Integer(3);
  auto objects = DecodeObjects(edit.database, row.Blob(4));
  if (!objects.ok()) {
    return In(fmt::format("database '{}', edit {}", edit.database, edit.id), objects.status());
  }
  edit.objects = *std::move(objects);
  return edit;
}

}  // namespace

absl::StatusOr<EditRecord> MakeEdit(Connection& connection, const std::string& database,
                                    std::span<const Change> changes, const std::string& author,
                                    std::int64_t time_us) {
  const auto plan = [&](const LoadClip& load, const ChangeStamp& stamp) {
    return PlanEdit(database, changes, load, stamp);
  };
  return EditWriter(connection, database).Run(plan, author, time_us);
}

absl::StatusOr<EditRecord> UndoStoredEdit(Connection& connection, const std::string& database,
                                          std::int64_t edit, const std::string& author,
                                          std::int64_t time_us) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  EditRecord undone;
  {
    Statement row = connection.Query(SelectEditColumns("database_key = ? AND edit.revision = ?"),
                                     database_key, edit);
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return NoEdit(database, edit);
    MOTIONDB_ASSIGN_OR_RETURN(undone, ToEdit(row));
  }
  const auto plan = [&](const LoadClip& load, const ChangeStamp& stamp) {
    return PlanUndo(undone, load, stamp);
  };
  return EditWriter(connection, database).Run(plan, author, time_us);
}

absl::StatusOr<std::vector<EditRecord>> SelectEdits(Connection& connection,
                                                    const std::string& database,
                                                    const std::string& clip, std::int64_t before,
                                                    int limit) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  if (before == 0) before = std::numeric_limits<std::int64_t>::max();
  Statement row = connection.Query(
      SelectEditColumns("database_key = ? AND edit.revision < ? AND (?3 = '' OR replace(clips, '/' "
                        "|| ?3 || '/', '') <> clips) ORDER BY edit.revision DESC LIMIT ?4"),
      database_key, before, clip, limit);
  std::vector<EditRecord> edits;
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return edits;
    MOTIONDB_ASSIGN_OR_RETURN(edits.emplace_back(), ToEdit(row));
  }
}

absl::Status CheckEdit(Connection& connection, std::int64_t edit_key) {
  Statement row = connection.Query(SelectEditColumns("edit_key = ?"), edit_key);
  MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
  return found ? ToEdit(row).status() : absl::OkStatus();
}

}  // namespace motiondb::storage
