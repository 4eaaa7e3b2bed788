#include "tests/server/storage/failing_disk.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <new>
#include <utility>

namespace sweepstake::storage {
namespace {

constexpr size_t kSectorBytes = 512;

std::string ContentOf(sqlite3_file* file) {
  sqlite3_int64 size = 0;
  file->pMethods->xFileSize(file, &size);
  std::string content(static_cast<size_t>(size), '\0');
  if (size > 0) file->pMethods->xRead(file, content.data(), static_cast<int>(size), 0);
  return content;
}

}  // namespace

// An open file. In the memory that SQLite allocates, the real file follows this struct.
struct FailingDisk::File {
  sqlite3_file base{&kMethods};
  FailingDisk* disk = nullptr;
  const std::string* path = nullptr;  // null for a temporary file, which cannot be reopened

  static File& Of(sqlite3_file* file) { return *reinterpret_cast<File*>(file); }
  sqlite3_file* real() { return reinterpret_cast<sqlite3_file*>(this + 1); }
  Image& image() const { return disk->images_.at(*path); }
};

namespace {

template <typename File, typename... Args>
int Forward(int (*sqlite3_io_methods::*method)(sqlite3_file*, Args...), sqlite3_file* file,
            Args... args) {
  sqlite3_file* real = File::Of(file).real();
  return (real->pMethods->*method)(real, args...);
}

}  // namespace

const sqlite3_io_methods FailingDisk::kMethods = {
    .iVersion = 2,  // with shared memory, without memory-mapped files
    .xClose = &Close,
    .xRead = &Read,
    .xWrite = &Write,
    .xTruncate = &Truncate,
    .xSync = &Sync,
    .xFileSize =
        [](sqlite3_file* file, sqlite3_int64* size) {
          return Forward<File>(&sqlite3_io_methods::xFileSize, file, size);
        },
    .xLock = [](sqlite3_file* file,
                int lock) { return Forward<File>(&sqlite3_io_methods::xLock, file, lock); },
    .xUnlock = [](sqlite3_file* file,
                  int lock) { return Forward<File>(&sqlite3_io_methods::xUnlock, file, lock); },
    .xCheckReservedLock =
        [](sqlite3_file* file, int* result) {
          return Forward<File>(&sqlite3_io_methods::xCheckReservedLock, file, result);
        },
    .xFileControl =
        [](sqlite3_file* file, int operation, void* argument) {
          return Forward<File>(&sqlite3_io_methods::xFileControl, file, operation, argument);
        },
    .xSectorSize =
        [](sqlite3_file* file) { return Forward<File>(&sqlite3_io_methods::xSectorSize, file); },
    .xDeviceCharacteristics =
        [](sqlite3_file* file) {
          return Forward<File>(&sqlite3_io_methods::xDeviceCharacteristics, file);
        },
    .xShmMap =
        [](sqlite3_file* file, int page, int size, int extend, void volatile** memory) {
          return Forward<File>(&sqlite3_io_methods::xShmMap, file, page, size, extend, memory);
        },
    .xShmLock =
        [](sqlite3_file* file, int offset, int count, int flags) {
          return Forward<File>(&sqlite3_io_methods::xShmLock, file, offset, count, flags);
        },
    .xShmBarrier =
        [](sqlite3_file* file) {
          sqlite3_file* real = File::Of(file).real();
          real->pMethods->xShmBarrier(real);
        },
    .xShmUnmap =
        [](sqlite3_file* file, int remove) {
          return Forward<File>(&sqlite3_io_methods::xShmUnmap, file, remove);
        },
    .xFetch = nullptr,
    .xUnfetch = nullptr,
};

FailingDisk::FailingDisk(uint64_t seed)
    : real_(sqlite3_vfs_find(nullptr)), vfs_(*real_), random_(seed) {
  vfs_.zName = "failing-disk";
  vfs_.szOsFile = static_cast<int>(sizeof(File)) + real_->szOsFile;
  vfs_.pAppData = this;
  vfs_.xOpen = &Open;
  vfs_.xDelete = &Delete;
  sqlite3_vfs_register(&vfs_, /*makeDflt=*/1);
}

FailingDisk::~FailingDisk() {
  sqlite3_vfs_register(real_, /*makeDflt=*/1);
  sqlite3_vfs_unregister(&vfs_);
}

void FailingDisk::Set(const Faults& faults) {
  const std::lock_guard lock(mutex_);
  faults_ = faults;
}

void FailingDisk::KillAfter(uint64_t changes) {
  const std::lock_guard lock(mutex_);
  life_ = changes;
}

bool FailingDisk::killed() const {
  const std::lock_guard lock(mutex_);
  return life_ == 0;
}

uint64_t FailingDisk::change_count() const {
  const std::lock_guard lock(mutex_);
  return change_count_;
}

uint64_t FailingDisk::read_count() const {
  const std::lock_guard lock(mutex_);
  return read_count_;
}

bool FailingDisk::has_unsynced() const {
  const std::lock_guard lock(mutex_);
  return std::any_of(images_.begin(), images_.end(),
                     [](const auto& image) { return !image.second.unsynced.empty(); });
}

void FailingDisk::Restart() {
  const std::lock_guard lock(mutex_);
  if (open_count_ != 0) std::abort();
  faults_ = {};
  life_.reset();
}

void FailingDisk::RestartAfterPowerCut() {
  Restart();
  const std::lock_guard lock(mutex_);
  for (auto& [path, image] : images_) {
    for (const Change& change : std::exchange(image.unsynced, {}))
      ApplyPerhaps(change, image.durable);
    image.cached = image.durable;
    if (std::filesystem::exists(path))
      std::ofstream(path, std::ios::binary)
          .write(image.durable.data(), static_cast<std::streamsize>(image.durable.size()));
    std::filesystem::remove(path + "-shm");
  }
}

bool FailingDisk::Happens(double ratio) {
  return ratio > 0 && static_cast<double>(random_() >> 11) * 0x1p-53 < ratio;
}

void FailingDisk::Apply(const Change& change, std::string& content) {
  if (change.bytes.empty()) return content.resize(change.offset);
  content.resize(std::max(content.size(), change.offset + change.bytes.size()));
  content.replace(change.offset, change.bytes.size(), change.bytes);
}

void FailingDisk::Image::Add(Change change) {
  Apply(change, cached);
  unsynced.push_back(std::move(change));
}

void FailingDisk::ApplyPerhaps(const Change& change, std::string& content) {
  if (change.bytes.empty()) {
    if (Happens(0.5)) Apply(change, content);
    return;
  }
  // The sectors of a write reach the disk in any order, so all, none or any part may be there.
  const double ratio = Happens(0.25) ? 0.5 : (Happens(0.5) ? 1 : 0);
  for (size_t begin = 0; begin < change.bytes.size();) {
    const size_t in_sector = kSectorBytes - (change.offset + begin) % kSectorBytes;
    std::string sector = change.bytes.substr(begin, in_sector);
    if (Happens(ratio)) Apply({change.offset + begin, std::move(sector)}, content);
    begin += in_sector;
  }
}

int FailingDisk::Open(sqlite3_vfs* vfs, const char* path, sqlite3_file* file, int flags,
                      int* out_flags) {
  auto* disk = static_cast<FailingDisk*>(vfs->pAppData);
  const std::lock_guard lock(disk->mutex_);
  auto* opened = new (file) File{};
  opened->disk = disk;
  file->pMethods = nullptr;  // a file without methods need not be closed
  if (disk->life_ == 0) return SQLITE_CANTOPEN;
  const int code = disk->real_->xOpen(disk->real_, path, opened->real(), flags, out_flags);
  if (code != SQLITE_OK) return code;
  file->pMethods = &kMethods;
  ++disk->open_count_;
  if (path == nullptr) return SQLITE_OK;
  const auto [image, is_new] = disk->images_.try_emplace(path);
  opened->path = &image->first;
  // A file that differs from the recorded one was written outside this disk, and counts as synced.
  if (const std::string content = ContentOf(opened->real());
      is_new || content != image->second.cached)
    image->second = {.cached = content, .durable = content, .unsynced = {}};
  return SQLITE_OK;
}

int FailingDisk::Delete(sqlite3_vfs* vfs, const char* path, int sync_directory) {
  auto* disk = static_cast<FailingDisk*>(vfs->pAppData);
  const std::lock_guard lock(disk->mutex_);
  if (disk->life_ == 0 || disk->faults_.read_only) return SQLITE_IOERR_DELETE;
  return disk->real_->xDelete(disk->real_, path, sync_directory);
}

int FailingDisk::Close(sqlite3_file* file) {
  const std::lock_guard lock(File::Of(file).disk->mutex_);
  --File::Of(file).disk->open_count_;
  return Forward<File>(&sqlite3_io_methods::xClose, file);
}

int FailingDisk::Read(sqlite3_file* file, void* bytes, int count, sqlite3_int64 offset) {
  FailingDisk& disk = *File::Of(file).disk;
  const std::lock_guard lock(disk.mutex_);
  ++disk.read_count_;
  if (disk.life_ == 0 || disk.Happens(disk.faults_.read_error)) return SQLITE_IOERR_READ;
  return Forward<File>(&sqlite3_io_methods::xRead, file, bytes, count, offset);
}

int FailingDisk::BeginChange(double error_ratio, int error) {
  ++change_count_;
  if (life_ == 0) return error;
  if (life_) --*life_;
  return Happens(error_ratio) ? error : SQLITE_OK;
}

int FailingDisk::WritePart(File& file, std::string_view bytes, size_t offset) {
  if (file.path != nullptr && !bytes.empty()) file.image().Add({offset, std::string(bytes)});
  return Forward<File>(&sqlite3_io_methods::xWrite, &file.base,
                       static_cast<const void*>(bytes.data()), static_cast<int>(bytes.size()),
                       static_cast<sqlite3_int64>(offset));
}

int FailingDisk::Write(sqlite3_file* file, const void* bytes, int count, sqlite3_int64 offset) {
  File& written = File::Of(file);
  FailingDisk& disk = *written.disk;
  const std::lock_guard lock(disk.mutex_);
  const std::string_view all(static_cast<const char*>(bytes), static_cast<size_t>(count));
  const bool alive = disk.life_ != 0;
  if (alive && disk.faults_.read_only) return SQLITE_IOERR_WRITE;
  const int code = disk.BeginChange(disk.faults_.write_error, SQLITE_IOERR_WRITE);
  if (code != SQLITE_OK) {
    if (alive) {
      disk.WritePart(written, all.substr(0, disk.random_() % all.size()),
                     static_cast<size_t>(offset));
    }
    return code;
  }
  sqlite3_int64 size = 0;
  Forward<File>(&sqlite3_io_methods::xFileSize, file, &size);
  if (disk.faults_.full && offset + count > size) return SQLITE_FULL;
  return disk.WritePart(written, all, static_cast<size_t>(offset));
}

int FailingDisk::Truncate(sqlite3_file* file, sqlite3_int64 size) {
  File& truncated = File::Of(file);
  const std::lock_guard lock(truncated.disk->mutex_);
  if (truncated.disk->faults_.read_only) return SQLITE_IOERR_TRUNCATE;
  const int code =
      truncated.disk->BeginChange(truncated.disk->faults_.write_error, SQLITE_IOERR_TRUNCATE);
  if (code != SQLITE_OK) return code;
  if (truncated.path != nullptr) truncated.image().Add({static_cast<size_t>(size), {}});
  return Forward<File>(&sqlite3_io_methods::xTruncate, file, size);
}

int FailingDisk::Sync(sqlite3_file* file, int /*flags*/) {
  File& synced = File::Of(file);
  FailingDisk& disk = *synced.disk;
  const std::lock_guard lock(disk.mutex_);
  const bool alive = disk.life_ != 0;
  const int code = disk.BeginChange(disk.faults_.sync_error, SQLITE_IOERR_FSYNC);
  if (!alive || synced.path == nullptr) return code;
  Image& image = synced.image();
  for (const Change& change : std::exchange(image.unsynced, {})) {
    if (code == SQLITE_OK) {
      Apply(change, image.durable);
    } else {
      disk.ApplyPerhaps(change, image.durable);
    }
  }
  return code;
}

}  // namespace sweepstake::storage
