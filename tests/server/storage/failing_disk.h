// A disk that fails as the test says, under every SQLite connection that is opened while it lives.
//
// It is a VFS over the real one and the default of the process. What is written is in the file at
// once, as in a system's cache, and is durable only once it was synced, which costs no time here.
// After a power cut each write that was not synced is there, missing or torn between sectors. A
// write that fails may be there in part, and what a failed sync leaves behind is lost though the
// cache has it, unless it is written again: that is how Linux behaves. What may happen is drawn
// from a seed.
//
// Files that are removed, or renamed after a sync, stay so. Thread-safe; one disk at a time.
#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <vector>

namespace sweepstake::storage {

class FailingDisk {
 public:
  // How many of the calls fail, from 0 to 1.
  struct Faults {
    double read_error = 0;
    double write_error = 0;
    double sync_error = 0;
    bool full = false;       // a file cannot grow
    bool read_only = false;  // nothing can be written
  };

  explicit FailingDisk(uint64_t seed = 1);
  ~FailingDisk();
  FailingDisk(const FailingDisk&) = delete;
  FailingDisk& operator=(const FailingDisk&) = delete;

  void Set(const Faults& faults);
  // The process ends after so many more writes, truncations and syncs: its connections live on, but
  // every call fails and changes nothing.
  void KillAfter(uint64_t changes);
  void Kill() { KillAfter(0); }
  bool killed() const;
  // What the next process finds: all that was written, or what a power cut leaves of it. The limits
  // of KillAfter and the faults end. REQUIRES: all connections are closed.
  void Restart();
  void RestartAfterPowerCut();

  // Counts writes, truncations and syncs, failed ones included.
  uint64_t change_count() const;
  uint64_t read_count() const;
  // Whether something was written that no sync has made durable.
  bool has_unsynced() const;

 private:
  struct File;
  // A write, or where there are no bytes, a truncation to the offset.
  struct Change {
    size_t offset = 0;
    std::string bytes;
  };
  struct Image {
    void Add(Change change);

    std::string cached;            // what the file has
    std::string durable;           // what it has after a power cut at least, and
    std::vector<Change> unsynced;  // what it may have besides
  };

  static int Open(sqlite3_vfs* vfs, const char* path, sqlite3_file* file, int flags,
                  int* out_flags);
  static int Delete(sqlite3_vfs* vfs, const char* path, int sync_directory);
  static int Close(sqlite3_file* file);
  static int Read(sqlite3_file* file, void* bytes, int count, sqlite3_int64 offset);
  static int Write(sqlite3_file* file, const void* bytes, int count, sqlite3_int64 offset);
  static int Truncate(sqlite3_file* file, sqlite3_int64 size);
  static int Sync(sqlite3_file* file, int flags);
  static const sqlite3_io_methods kMethods;

  // These take the lock's holder for granted.
  bool Happens(double ratio);
  // Returns the error of the next change, or SQLITE_OK.
  int BeginChange(double error_ratio, int error);
  static int WritePart(File& file, std::string_view bytes, size_t offset);
  static void Apply(const Change& change, std::string& content);
  // Applies the change, or a part of it, or nothing.
  void ApplyPerhaps(const Change& change, std::string& content);

  sqlite3_vfs* real_;
  sqlite3_vfs vfs_;
  mutable std::mutex mutex_;
  std::mt19937_64 random_;               // guarded by mutex_
  Faults faults_;                        // guarded by mutex_
  std::optional<uint64_t> life_;         // guarded by mutex_; changes until the process ends
  uint64_t change_count_ = 0;            // guarded by mutex_
  uint64_t read_count_ = 0;              // guarded by mutex_
  size_t open_count_ = 0;                // guarded by mutex_
  std::map<std::string, Image> images_;  // guarded by mutex_; by path
};

}  // namespace sweepstake::storage
