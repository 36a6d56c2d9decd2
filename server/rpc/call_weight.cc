#include "server/rpc/call_weight.h"

#include <algorithm>
#include <array>

namespace motiondb::server {
namespace {

constexpr std::array<std::string_view, 6> kHeavy = {
    "ClipService.IngestClip",   "QueryService.Plan",         "QueryService.PredictSeries",
    "StoreService.BackupStore", "StoreService.RestoreStore", "StoreService.VerifyStore"};

}  // namespace

CallWeight WeightOf(std::string_view method) {
  if (method == "ObserveService.Observe") return CallWeight::kStream;
  return std::ranges::find(kHeavy, method) == kHeavy.end() ? CallWeight::kLight
                                                           : CallWeight::kHeavy;
}

}  // namespace motiondb::server
