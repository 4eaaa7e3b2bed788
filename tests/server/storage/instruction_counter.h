// How much work SQLite's statements are, other than by the clock.
#pragma once

#include <sqlite3.h>

#include <cstdint>

namespace sweepstake::storage {

// Counts the instructions of SQLite's machine on every connection that is opened while it lives; a
// row that is visited takes several.
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
