#include "server/security/role_table.h"

#include <algorithm>

namespace motiondb::server {
namespace {

using enum storage::Role;
using enum Scope;

constexpr bool kReads = false;
constexpr bool kChanges = true;
constexpr bool kCopiesAll = true;

constexpr CallRule kRules[] = {
    {"DatabaseService.CreateDatabase", kAdmin, kChanges, kServer, "database_id", "databases/"},
    {"DatabaseService.GetDatabase", kReader, kReads, kDatabase, "name"},
    {"DatabaseService.ListDatabases", kReader, kReads, kList, ""},
    {"DatabaseService.DeleteDatabase", kAdmin, kChanges, kDatabase, "name"},
    {"DatabaseService.DescribeDatabase", kReader, kReads, kDatabase, "name"},

    {"ClipService.IngestClip", kIngester, kChanges, kDatabase, "header.parent"},
    {"ClipService.GetClip", kReader, kReads, kDatabase, "name"},
    {"ClipService.ListClips", kReader, kReads, kDatabase, "parent"},
    {"ClipService.DeleteClip", kIngester, kChanges, kDatabase, "name"},
    {"ClipService.ExportClip", kReader, kReads, kDatabase, "name"},
    {"ClipService.GetSkeleton", kReader, kReads, kDatabase, "name"},
    {"ClipService.ListSkeletons", kReader, kReads, kDatabase, "parent"},

    {"ModelService.GetModel", kReader, kReads, kDatabase, "name"},
    {"ModelService.ListModels", kReader, kReads, kDatabase, "parent"},
    {"ModelService.ListNodes", kReader, kReads, kDatabase, "parent"},
    {"ModelService.ListTransitions", kReader, kReads, kDatabase, "parent"},
    {"ModelService.ReadStates", kReader, kReads, kDatabase, "name"},

    {"QueryService.Recognize", kReader, kReads, kDatabase, "database"},
    {"QueryService.Estimate", kReader, kReads, kDatabase, "database"},
    {"QueryService.Predict", kReader, kReads, kDatabase, "database"},
    {"QueryService.PredictSeries", kReader, kReads, kDatabase, "prediction.database"},
    {"QueryService.Plan", kReader, kReads, kDatabase, "database"},

    {"ObserveService.Observe", kReader, kReads, kDatabase, "start.database"},
    {"ObserveService.Represent", kReader, kReads, kDatabase, "database"},

    {"OperationService.GetOperation", kReader, kReads, kOperation, "name"},
    {"OperationService.ListOperations", kReader, kReads, kList, "database"},
    {"OperationService.WaitOperation", kReader, kReads, kOperation, "name"},
    {"OperationService.CancelOperation", kIngester, kChanges, kOperation, "name"},

    {"AccessService.CreateToken", kAdmin, kChanges, kServer, "database"},
    {"AccessService.ListTokens", kAdmin, kReads, kServer, ""},
    {"AccessService.RevokeToken", kAdmin, kChanges, kServer, "name"},
    {"AccessService.ListAuditEntries", kAdmin, kReads, kServer, ""},

    {"StoreService.GetServerStatus", kReader, kReads, kServer, ""},
    {"StoreService.VerifyStore", kAdmin, kReads, kServer, ""},
    {"StoreService.BackupStore", kAdmin, kCopiesAll, kServer, ""},
    {"StoreService.RestoreStore", kAdmin, kChanges, kServer, ""},
};

}  // namespace

std::span<const CallRule> CallRules() { return kRules; }

const CallRule* FindCallRule(std::string_view method) {
  const auto found = std::ranges::find(kRules, method, &CallRule::method);
  return found == std::end(kRules) ? nullptr : found;
}

}  // namespace motiondb::server
