#include "storage/migration/migrate_store.h"

#include "core/motion/error.h"
#include "storage/migration/migration_end.h"
#include "storage/migration/store_comparison.h"
#include "storage/sql/connection/transaction.h"
#include "storage/sql/tables/row_copy.h"

namespace motiondb::storage {
namespace {

using Phase = MigrationProgress::Phase;

class Migration {
 public:
  Migration(MigrationEnd& source, MigrationEnd& target,
            const std::function<void(const MigrationProgress&)>& on_progress,
            const core::Cancelled& cancelled)
      : source_(source), target_(target), on_progress_(on_progress), cancelled_(cancelled) {
    progress_.is_continued = target.is_continued();
  }

  absl::Status Run() {
    {
      // One snapshot for the copy and the comparison.
      MOTIONDB_ASSIGN_OR_RETURN(const Transaction snapshot,
                                Transaction::Begin(source_.connection(), Transaction::Kind::kRead));
      MOTIONDB_RETURN_IF_ERROR(Copy());
      MOTIONDB_RETURN_IF_ERROR(Compare());
    }
    MOTIONDB_RETURN_IF_ERROR(Report(Phase::kPublish, progress_.bytes));
    return target_.Publish();
  }

 private:
  // CANCELLED, or OK.
  absl::Status Report(Phase phase, std::int64_t bytes) {
    progress_.phase = phase;
    progress_.bytes = bytes;
    if (on_progress_) on_progress_(progress_);
    if (cancelled_ && cancelled_()) {
      return absl::CancelledError("cancelled; the same migration continues");
    }
    return absl::OkStatus();
  }

  // Not InTransaction, which may run it twice: the copy cannot go back.
  template <typename Work>
  absl::Status InOneTransaction(const Work& work) {
    Connection& connection = target_.connection();
    MOTIONDB_ASSIGN_OR_RETURN(Transaction transaction,
                              Transaction::Begin(connection, Transaction::Kind::kWrite));
    MOTIONDB_RETURN_IF_ERROR(work(connection));
    return transaction.Commit();
  }

  absl::Status Copy() {
    RowCopy rows(source_.connection(), std::nullopt, RowCopy::Mode::kMove);
    MOTIONDB_RETURN_IF_ERROR(
        InOneTransaction([&](Connection& target) { return rows.Continue(target); }));
    for (bool more = true; more;) {
      MOTIONDB_RETURN_IF_ERROR(Report(Phase::kCopy, rows.copied_bytes()));
      MOTIONDB_RETURN_IF_ERROR(InOneTransaction([&](Connection& target) -> absl::Status {
        MOTIONDB_ASSIGN_OR_RETURN(more, rows.Step(target));
        return absl::OkStatus();
      }));
    }
    MOTIONDB_RETURN_IF_ERROR(Report(Phase::kIndex, rows.copied_bytes()));
    return InOneTransaction([&](Connection& target) -> absl::Status {
      // An interrupted migration may have filled the index.
      MOTIONDB_RETURN_IF_ERROR(target.Query("DELETE FROM clip_text").Run());
      return rows.Finish(target);
    });
  }

  absl::Status Compare() {
    MOTIONDB_ASSIGN_OR_RETURN(const Transaction snapshot,
                              Transaction::Begin(target_.connection(), Transaction::Kind::kRead));
    const absl::Status same = CompareStores(
        source_.connection(), target_.connection(),
        [&](std::int64_t bytes) { Report(Phase::kCompare, bytes).IgnoreError(); }, cancelled_);
    if (!absl::IsDataLoss(same)) return same;
    return core::DataLoss(
        "{} and its copy {} are not equal: {}; either the source was changed after the migration "
        "began, or one of them is corrupt: delete the copy and migrate again",
        source_.name(), target_.name(), std::string(same.message()));
  }

  MigrationEnd& source_;
  MigrationEnd& target_;
  const std::function<void(const MigrationProgress&)>& on_progress_;
  const core::Cancelled& cancelled_;
  MigrationProgress progress_;
};

}  // namespace

absl::Status MigrateStore(const std::string& from, const std::string& to,
                          const std::function<void(const MigrationProgress&)>& on_progress,
                          const core::Cancelled& cancelled) {
  MOTIONDB_ASSIGN_OR_RETURN(MigrationEnd source, MigrationEnd::OpenSource(from));
  MOTIONDB_ASSIGN_OR_RETURN(MigrationEnd target, MigrationEnd::OpenTarget(to, source));
  return Migration(source, target, on_progress, cancelled).Run();
}

}  // namespace motiondb::storage
