// Translates the SQL of the tables to PostgreSQL's: `?` and `?3` become `$1` and `$3`.
#pragma once

#include <string>
#include <string_view>

namespace motiondb::storage {

// As in SQLite, `?` has the number after the largest one so far. Texts in quotes stay.
std::string ToPostgresSql(std::string_view sql);

}  // namespace motiondb::storage
