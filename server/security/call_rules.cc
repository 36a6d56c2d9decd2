#include "server/security/call_rules.h"

#include <algorithm>
#include <iterator>

namespace motiondb::server {
namespace {

using enum storage::Role;
using enum RequestClass;
using enum Scope;

constexpr bool kReads = false;
constexpr bool kChanges = true;
constexpr bool kCopiesAll = true;
constexpr bool kUrgent = true;
constexpr std::string_view kFullName;

constexpr CallRule kRules[] = {
    {"DatabaseService.CreateDatabase", kAdmin, kChanges, kLight, kServer, "database_id",
     "databases/", Pool::kChanges},
    {"DatabaseService.GetDatabase", kReader, kReads, kLight, kDatabase, "name"},
    {"DatabaseService.ListDatabases", kReader, kReads, kLight, kList, ""},
    {"DatabaseService.DeleteDatabase", kAdmin, kChanges, kLight, kDatabase, "name", kFullName,
     Pool::kChanges},
    {"DatabaseService.WatchDatabase", kReader, kReads, kStream, kDatabase, "name"},
    {"DatabaseService.ReprocessDatabase", kIngester, kChanges, kLight, kDatabase, "name", kFullName,
     Pool::kChanges},

    {"MarkerSetService.GetMarkerSet", kReader, kReads, kLight, kList, "database"},
    {"MarkerSetService.AddMappings", kIngester, kChanges, kLight, kDatabase, "database", kFullName,
     Pool::kChanges},
    {"MarkerSetService.DeleteMapping", kIngester, kChanges, kLight, kDatabase, "database",
     kFullName, Pool::kChanges},

    {"ClipService.IngestClip", kIngester, kChanges, kHeavy, kDatabase, "header.parent"},
    {"ClipService.UploadClip", kIngester, kChanges, kHeavy, kDatabase, "header.parent"},
    {"ClipService.GetClip", kReader, kReads, kLight, kDatabase, "name"},
    {"ClipService.ListClips", kReader, kReads, kLight, kDatabase, "parent"},
    {"ClipService.DeleteClip", kIngester, kChanges, kLight, kDatabase, "name", kFullName,
     Pool::kChanges},
    {"ClipService.UpdateClip", kIngester, kChanges, kLight, kDatabase, "clip.name", kFullName,
     Pool::kChanges},
    {"ClipService.SearchClips", kReader, kReads, kLight, kDatabase, "parent"},
    {"ClipService.ExportClip", kReader, kReads, kHeavy, kDatabase, "name"},
    {"ClipService.GetSkeleton", kReader, kReads, kLight, kDatabase, "name"},
    {"ClipService.ListSkeletons", kReader, kReads, kLight, kDatabase, "parent"},

    {"SegmentService.CreateSegment", kIngester, kChanges, kLight, kDatabase, "parent", kFullName,
     Pool::kChanges},
    {"SegmentService.UpdateSegment", kIngester, kChanges, kLight, kDatabase, "segment.name",
     kFullName, Pool::kChanges},
    {"SegmentService.DeleteSegment", kIngester, kChanges, kLight, kDatabase, "name", kFullName,
     Pool::kChanges},
    {"SegmentService.ListSegments", kReader, kReads, kLight, kDatabase, "parent"},

    {"EditService.BatchEdit", kIngester, kChanges, kLight, kDatabase, "parent", kFullName,
     Pool::kChanges},
    {"EditService.ListEdits", kReader, kReads, kLight, kDatabase, "parent"},
    {"EditService.UndoEdit", kIngester, kChanges, kLight, kDatabase, "name", kFullName,
     Pool::kChanges},

    {"ModelService.GetModel", kReader, kReads, kLight, kDatabase, "name"},
    {"ModelService.ListModels", kReader, kReads, kLight, kDatabase, "parent"},
    {"ModelService.ListNodes", kReader, kReads, kLight, kDatabase, "parent"},
    {"ModelService.ListTransitions", kReader, kReads, kLight, kDatabase, "parent"},
    {"ModelService.ReadStates", kReader, kReads, kLight, kDatabase, "name"},

    {"QueryService.Recognize", kReader, kReads, kLight, kDatabase, "database"},
    {"QueryService.Estimate", kReader, kReads, kLight, kDatabase, "database"},
    {"QueryService.Predict", kReader, kReads, kLight, kDatabase, "database"},
    {"QueryService.PredictSeries", kReader, kReads, kHeavy, kDatabase, "prediction.database"},
    {"QueryService.Find", kReader, kReads, kLight, kDatabase, "database"},
    {"QueryService.Plan", kReader, kReads, kHeavy, kDatabase, "database"},

    {"ObserveService.Observe", kReader, kReads, kStream, kDatabase, "start.database"},
    {"ObserveService.Represent", kReader, kReads, kLight, kDatabase, "database"},
    {"ObserveService.ListStreams", kReader, kReads, kLight, kDatabase, "parent"},
    {"ObserveService.WatchStream", kReader, kReads, kStream, kDatabase, "name"},

    {"ViewService.GetFigure", kReader, kReads, kLight, kDatabase, "name"},
    {"ViewService.ReadClipMotion", kReader, kReads, kLight, kDatabase, "name"},
    {"ViewService.ReadStateMap", kReader, kReads, kHeavy, kDatabase, "parent"},
    {"ViewService.GetNodePoses", kReader, kReads, kLight, kDatabase, "parent"},

    {"OperationService.GetOperation", kReader, kReads, kLight, kOperation, "name"},
    {"OperationService.ListOperations", kReader, kReads, kLight, kList, "parent"},
    {"OperationService.WaitOperation", kReader, kReads, kLight, kOperation, "name"},
    {"OperationService.CancelOperation", kIngester, kChanges, kLight, kOperation, "name", kFullName,
     Pool::kChanges, kUrgent},

    {"AccessService.CreateToken", kAdmin, kChanges, kLight, kServer, "token.database", kFullName,
     Pool::kChanges},
    {"AccessService.ListTokens", kAdmin, kReads, kLight, kServer, ""},
    {"AccessService.RevokeToken", kAdmin, kChanges, kLight, kServer, "name", kFullName,
     Pool::kChanges, kUrgent},
    {"AccessService.ListAuditEntries", kAdmin, kReads, kLight, kServer, ""},

    {"ServerService.GetServerStatus", kReader, kReads, kLight, kServer, ""},
    {"StoreService.VerifyStore", kAdmin, kReads, kHeavy, kServer, "", kFullName,
     Pool::kMaintenance},
    {"StoreService.BackupStore", kAdmin, kCopiesAll, kHeavy, kServer, "", kFullName,
     Pool::kMaintenance},
    {"StoreService.RestoreStore", kAdmin, kChanges, kHeavy, kServer, "", kFullName,
     Pool::kMaintenance},
    {"StoreService.ExportDatabase", kReader, kCopiesAll, kHeavy, kDatabase, "name", kFullName,
     Pool::kMaintenance},
    {"StoreService.ImportDatabase", kAdmin, kChanges, kHeavy, kServer, "", kFullName,
     Pool::kMaintenance},
};

}  // namespace

std::span<const CallRule> CallRules() { return kRules; }

const CallRule* FindCallRule(std::string_view method) {
  const auto found = std::ranges::find(kRules, method, &CallRule::method);
  return found == std::end(kRules) ? nullptr : found;
}

}  // namespace motiondb::server
