#include "tests/storage/faults/fault_disk.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <new>
#include <thread>

namespace motiondb::tests {
namespace {

constexpr std::size_t kSector = 512;

// A file of the simulated disk. The system's sqlite3_file follows it in memory.
struct FaultFile {
  sqlite3_file base;
  FaultDisk* disk;
  std::string* path;  // null for an unnamed temporary file

  sqlite3_file* real() { return reinterpret_cast<sqlite3_file*>(this + 1); }
};

FaultFile& Of(sqlite3_file* file) { return *reinterpret_cast<FaultFile*>(file); }
sqlite3_vfs* System() { return sqlite3_vfs_find("unix"); }

int Close(sqlite3_file* file) {
  const int code = Of(file).real()->pMethods->xClose(Of(file).real());
  delete Of(file).path;
  return code;
}
int Read(sqlite3_file* file, void* out, int count, sqlite3_int64 offset) {
  const std::string* const path = Of(file).path;
  const int code = Of(file).disk->OnRead(path == nullptr ? "" : *path, offset, count);
  if (code != SQLITE_OK) return code;
  return Of(file).real()->pMethods->xRead(Of(file).real(), out, count, offset);
}
int Write(sqlite3_file* file, const void* bytes, int count, sqlite3_int64 offset) {
  sqlite3_file* const real = Of(file).real();
  int done = count;
  int code = SQLITE_OK;
  if (Of(file).path != nullptr) {
    code = Of(file).disk->OnWrite(*Of(file).path, offset, static_cast<const char*>(bytes), count,
                                  done);
  }
  if (done == 0) return code;
  const int written = real->pMethods->xWrite(real, bytes, done, offset);
  return code == SQLITE_OK ? written : code;
}
int Truncate(sqlite3_file* file, sqlite3_int64 size) {
  if (Of(file).path != nullptr) {
    const int code = Of(file).disk->OnTruncate(*Of(file).path, size);
    if (code != SQLITE_OK) return code;
  }
  return Of(file).real()->pMethods->xTruncate(Of(file).real(), size);
}
int Sync(sqlite3_file* file, int) {
  // No sync of the real disk: only the simulated power is cut.
  return Of(file).path == nullptr ? SQLITE_OK : Of(file).disk->OnSync(*Of(file).path);
}
int FileSize(sqlite3_file* file, sqlite3_int64* size) {
  if (Of(file).disk->dead()) return SQLITE_IOERR_FSTAT;
  return Of(file).real()->pMethods->xFileSize(Of(file).real(), size);
}
int Lock(sqlite3_file* file, int lock) {
  return Of(file).real()->pMethods->xLock(Of(file).real(), lock);
}
int Unlock(sqlite3_file* file, int lock) {
  return Of(file).real()->pMethods->xUnlock(Of(file).real(), lock);
}
int CheckReserved(sqlite3_file* file, int* reserved) {
  return Of(file).real()->pMethods->xCheckReservedLock(Of(file).real(), reserved);
}
int Control(sqlite3_file* file, int op, void* argument) {
  return Of(file).real()->pMethods->xFileControl(Of(file).real(), op, argument);
}
int SectorSize(sqlite3_file* file) {
  return Of(file).real()->pMethods->xSectorSize(Of(file).real());
}
int Characteristics(sqlite3_file* file) {
  return Of(file).real()->pMethods->xDeviceCharacteristics(Of(file).real());
}
int ShmMap(sqlite3_file* file, int region, int size, int extend, void volatile** out) {
  return Of(file).real()->pMethods->xShmMap(Of(file).real(), region, size, extend, out);
}
int ShmLock(sqlite3_file* file, int offset, int count, int flags) {
  return Of(file).real()->pMethods->xShmLock(Of(file).real(), offset, count, flags);
}
void ShmBarrier(sqlite3_file* file) { Of(file).real()->pMethods->xShmBarrier(Of(file).real()); }
int ShmUnmap(sqlite3_file* file, int drop) {
  return Of(file).real()->pMethods->xShmUnmap(Of(file).real(), drop);
}

constexpr sqlite3_io_methods kMethods = {
    2,        Close,         Read,    Write,      Truncate,        Sync,   FileSize, Lock,
    Unlock,   CheckReserved, Control, SectorSize, Characteristics, ShmMap, ShmLock,  ShmBarrier,
    ShmUnmap, nullptr,       nullptr};

int Open(sqlite3_vfs* vfs, sqlite3_filename name, sqlite3_file* file, int flags, int* out_flags) {
  auto& disk = *static_cast<FaultDisk*>(vfs->pAppData);
  file->pMethods = nullptr;
  if (disk.dead()) return SQLITE_CANTOPEN;
  if (name != nullptr) disk.OnOpen(name);
  FaultFile& opened = Of(file);
  std::memset(static_cast<void*>(opened.real()), 0, static_cast<std::size_t>(System()->szOsFile));
  const int code = System()->xOpen(System(), name, opened.real(), flags, out_flags);
  if (code != SQLITE_OK) return code;
  opened.disk = &disk;
  opened.path = name == nullptr ? nullptr : new std::string(name);
  file->pMethods = &kMethods;
  return SQLITE_OK;
}

int Delete(sqlite3_vfs* vfs, const char* name, int sync_folder) {
  auto& disk = *static_cast<FaultDisk*>(vfs->pAppData);
  if (disk.dead()) return SQLITE_IOERR_DELETE;
  disk.OnDelete(name);
  return System()->xDelete(System(), name, sync_folder);
}

}  // namespace

FaultDisk::FaultDisk() : vfs_(*System()) {
  vfs_.zName = kVfs;
  vfs_.szOsFile = static_cast<int>(sizeof(FaultFile)) + System()->szOsFile;
  vfs_.pAppData = this;
  vfs_.xOpen = Open;
  vfs_.xDelete = Delete;
  sqlite3_vfs_register(&vfs_, /*makeDflt=*/0);
}

FaultDisk::~FaultDisk() { sqlite3_vfs_unregister(&vfs_); }

void FaultDisk::Arm(Fault fault, int at) {
  files_.clear();
  bad_sectors_.clear();
  fault_ = fault;
  at_ = at;
  operations_ = 0;
  struck_ = false;
  dead_ = false;
  // With the same salts, equal changes write equal logs. Not so in another process: names of
  // temporary files are random too, and would be those of the other half of the tests.
  sqlite3_test_control(SQLITE_TESTCTRL_PRNG_SEED, static_cast<int>(getpid()), nullptr);
  sqlite3_randomness(0, nullptr);
}

bool FaultDisk::Strikes() {
  ++operations_;
  if (fault_ == Fault::kNone) return false;
  const bool now = fault_ == Fault::kFull ? operations_ >= at_ : operations_ == at_;
  if (now) struck_ = true;
  if (now && fault_ == Fault::kPowerCut) dead_ = true;
  return now;
}

void FaultDisk::OnOpen(const std::string& path) {
  if (files_.contains(path)) return;
  File& file = files_[path];
  std::ifstream stream(path, std::ios::binary);
  if (!stream) return;
  file.durable = true;
  file.synced.resize(std::filesystem::file_size(path));
  stream.read(file.synced.data(), static_cast<std::streamsize>(file.synced.size()));
}

int FaultDisk::OnRead(const std::string& path, std::int64_t offset, int count) {
  ++reads_;
  if (slow_) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  if (dead_) return SQLITE_IOERR_READ;
  const auto sector = bad_sectors_.find(path);
  if (sector == bad_sectors_.end()) return SQLITE_OK;
  const auto [byte, code] = sector->second;
  return offset <= byte && byte < offset + count ? code : SQLITE_OK;
}

int FaultDisk::OnWrite(const std::string& path, std::int64_t offset, const char* bytes, int count,
                       int& done) {
  done = 0;
  if (dead_) return SQLITE_IOERR_WRITE;
  const bool strikes = Strikes();
  if (strikes && fault_ == Fault::kFull) return SQLITE_FULL;
  if (strikes && fault_ == Fault::kError) return SQLITE_IOERR_WRITE;
  const bool half = strikes && fault_ == Fault::kShortWrite;
  const int kept = half ? count / 2 : count;
  files_[path].unsynced.push_back({offset, std::string(bytes, static_cast<std::size_t>(kept))});
  if (dead_) return SQLITE_IOERR_WRITE;  // in progress during the power cut: may or may not be kept
  done = kept;
  return half ? SQLITE_IOERR_WRITE : SQLITE_OK;
}

int FaultDisk::OnTruncate(const std::string& path, std::int64_t size) {
  if (dead_) return SQLITE_IOERR_TRUNCATE;
  const bool strikes = Strikes();
  if (strikes && !dead_ && fault_ != Fault::kFull) return SQLITE_IOERR_TRUNCATE;
  files_[path].unsynced.push_back({size, "", /*truncates=*/true});
  return dead_ ? SQLITE_IOERR_TRUNCATE : SQLITE_OK;
}

int FaultDisk::OnSync(const std::string& path) {
  if (dead_) return SQLITE_IOERR_FSYNC;
  if (Strikes() && fault_ != Fault::kFull) return SQLITE_IOERR_FSYNC;
  File& file = files_[path];
  for (const Change& change : file.unsynced) Apply(change, file.synced);
  file.unsynced.clear();
  file.durable = true;
  return SQLITE_OK;
}

void FaultDisk::Apply(const Change& change, std::string& bytes) {
  const auto offset = static_cast<std::size_t>(change.offset);
  if (change.truncates) {
    bytes.resize(std::min(bytes.size(), offset));
    return;
  }
  bytes.resize(std::max(bytes.size(), offset + change.bytes.size()));
  std::memcpy(bytes.data() + offset, change.bytes.data(), change.bytes.size());
}

void FaultDisk::Tear(const Change& change, std::string& bytes, std::mt19937& random) {
  for (std::size_t begin = 0; begin < change.bytes.size(); begin += kSector) {
    if (random() % 2 == 0) continue;
    const auto offset = change.offset + static_cast<std::int64_t>(begin);
    Apply({offset, change.bytes.substr(begin, kSector)}, bytes);
  }
}

FaultDisk::Contents FaultDisk::AfterPowerCut(unsigned seed) const {
  std::mt19937 random(seed);
  // A quarter of the seeds keeps all unsynced changes, a quarter none, the others a random part.
  const int luck = static_cast<int>(seed % 4);
  Contents kept;
  for (const auto& [path, file] : files_) {
    if (!file.durable && (luck == 1 || (luck > 1 && random() % 4 == 0))) continue;
    std::string& bytes = kept[path] = file.synced;
    std::vector<Change> unsynced = file.unsynced;
    if (luck > 1) std::shuffle(unsynced.begin(), unsynced.end(), random);
    for (const Change& change : unsynced) {
      const auto fate = luck == 0 ? 0 : luck == 1 ? 1 : random() % 3;
      if (fate == 0) Apply(change, bytes);
      if (fate == 2 && !change.truncates) Tear(change, bytes, random);
    }
  }
  return kept;
}

void FaultDisk::Reboot(const Contents& kept) {
  for (const auto& [path, file] : files_) {
    const auto bytes = kept.find(path);
    std::filesystem::remove(path + "-shm");
    if (bytes == kept.end()) {
      std::filesystem::remove(path);
    } else {
      std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes->second;
    }
  }
  Clear();
  dead_ = false;
}

}  // namespace motiondb::tests
