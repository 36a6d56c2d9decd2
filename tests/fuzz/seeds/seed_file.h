// Writes a seed input to MOTIONDB_FUZZ_SEEDS/TARGET/NAME.
#pragma once

#include <string>
#include <string_view>

namespace motiondb::tests {

void WriteSeed(const std::string& target, const std::string& name, std::string_view bytes);

}  // namespace motiondb::tests
