// Measures the work of SQLite statements independently of time.
#pragma once

#include <sqlite3.h>

#include <cstdint>

namespace sweepstake::storage {

// Counts the virtual-machine instructions of every SQLite connection that is opened while this
// object lives. Visiting a row takes several.
class InstructionCounter {
 public:
  InstructionCounter() {
    count_ = 0;
    sqlite3_auto_extension(reinterpret_cast<void (*)()>(&Attach));
  }
  ~InstructionCounter() { sqlite3_reset_auto_extension(); }

  template <typename Body>
  uint64_t During(Body body) {
    const uint64_t before = count_;
    body();
    return count_ - before;
  }

 private:
  static int Attach(sqlite3* database, char** /*error*/, const sqlite3_api_routines* /*api*/) {
    const auto count = [](void*) {
      ++count_;
      return 0;
    };
    sqlite3_progress_handler(database, 1, count, nullptr);
    return SQLITE_OK;
  }
  static inline uint64_t count_ = 0;
};

}  // namespace sweepstake::storage
