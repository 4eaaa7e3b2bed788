// A disk that fails on request, under every SQLite connection that is opened while this object
// lives.
//
// It is a VFS on top of the real one, and the default of the process. Written data are in the file
// at once, as in a system's cache, but are durable only after a sync, which takes no time here.
// After a power cut each unsynced write is there, missing, or torn between sectors. A failed write
// may be there in part. Data after a failed sync are lost even though the cache has them, unless
// they are written again: Linux behaves like this. A seed determines all random choices.
//
// Removals, and renames after a sync, are durable. Thread-safe. Only one disk may exist at a time.
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
  // Which calls fail. The first three values are the fraction of the calls that fail, from 0 to 1.
  struct Faults {
    double read_error = 0;
    double write_error = 0;
    double sync_error = 0;
    bool full = false;       // files cannot grow
    bool read_only = false;  // all writes fail
  };

  explicit FailingDisk(uint64_t seed = 1);
  ~FailingDisk();
  FailingDisk(const FailingDisk&) = delete;
  FailingDisk& operator=(const FailingDisk&) = delete;

  void Set(const Faults& faults);
  // Simulates the death of the process after `changes` more writes, truncations and syncs. SQLite's
  // connections stay open, but every call of this disk then fails and changes nothing.
  void KillAfter(uint64_t changes);
  void Kill() { KillAfter(0); }
  bool killed() const;
  // Start the next process, with all written data or with the data that survive a power cut. Reset
  // KillAfter and the faults. REQUIRES: all connections are closed.
  void Restart();
  void RestartAfterPowerCut();

  // Counts writes, truncations and syncs, including failed ones.
  uint64_t change_count() const;
  uint64_t read_count() const;
  // Returns whether there are writes that no sync has made durable.
  bool has_unsynced() const;

 private:
  struct File;
  // A write or, if there are no bytes, a truncation to the offset.
  struct Change {
    size_t offset = 0;
    std::string bytes;
  };
  struct Image {
    void Add(Change change);

    std::string cached;            // content as seen by the system
    std::string durable;           // content that survives a power cut
    std::vector<Change> unsynced;  // changes that may survive a power cut
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

  // REQUIRES, for the functions below: the caller holds the lock.
  bool Happens(double ratio);
  // Counts a change and returns its error, or SQLITE_OK.
  int BeginChange(double error_ratio, int error);
  static int WritePart(File& file, std::string_view bytes, size_t offset);
  static void Apply(const Change& change, std::string& content);
  // Applies the change completely, in part, or not at all.
  void ApplyPerhaps(const Change& change, std::string& content);

  sqlite3_vfs* real_;
  sqlite3_vfs vfs_;
  mutable std::mutex mutex_;
  std::mt19937_64 random_;        // guarded by mutex_
  Faults faults_;                 // guarded by mutex_
  std::optional<uint64_t> life_;  // guarded by mutex_; remaining changes until the process dies
  uint64_t change_count_ = 0;     // guarded by mutex_
  uint64_t read_count_ = 0;       // guarded by mutex_
  size_t open_count_ = 0;         // guarded by mutex_
  std::map<std::string, Image> images_;  // guarded by mutex_; by path
};

}  // namespace sweepstake::storage
