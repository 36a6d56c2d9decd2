#include "server/rpc/query_subject.h"

#include "core/motion/error.h"
#include "server/translate/resource_name.h"

namespace motiondb::server {

absl::StatusOr<QuerySubject> FindSubject(Engine& engine, std::string_view field,
                                         const std::string& name) {
  QuerySubject subject;
  MOTIONDB_ASSIGN_OR_RETURN(const std::string id, ParseDatabaseName(field, name));
  MOTIONDB_ASSIGN_OR_RETURN(subject.database, engine.FindDatabase(id));
  MOTIONDB_ASSIGN_OR_RETURN(subject.snapshot, engine.CurrentModel(*subject.database));
  return subject;
}

}  // namespace motiondb::server
