// The streams of a command, its exit codes, and its progress display.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <ostream>
#include <string>

#include "sweepstake/status.h"

namespace sweepstake::cli {

// The exit codes that the README documents.
enum ExitCode : int { kDone = 0, kCheckFailed = 1, kBadUsage = 2, kUnreachable = 3 };

// The size of a terminal in characters.
struct ScreenSize {
  size_t columns = 80;
  size_t rows = 24;
};

// The streams of a command: `out` for results, `err` for everything else. Both are borrowed.
struct Terminal {
  std::ostream& out;
  std::ostream& err;
  bool out_is_tty = false;
  bool err_is_tty = false;
  size_t err_columns = 0;                     // 0: `err` is not a terminal
  std::function<ScreenSize()> out_size = {};  // returns the present size, if `out` is a terminal
  std::string program = "sweepstake";         // begins each message
};

// Prints "PROGRAM: MESSAGE". Returns the exit code: kUnreachable for kUnavailable, kCheckFailed for
// kInternal, kBadUsage for all other errors.
int Fail(Terminal& terminal, const Status& status);
// Does the same as Fail, for the status of a call to a daemon. Returns
// - kUnreachable for kUnavailable, and for kResourceExhausted, because a full daemon may serve the
//   call later
// - kBadUsage for kInvalidArgument
// - kCheckFailed for all other errors: the daemon understood and refused the call
int FailAnswer(Terminal& terminal, const Status& status);

// Prints "PROGRAM: TEXT" to `err`.
void Say(Terminal& terminal, const std::string& text);
// Prints "PROGRAM: MESSAGE; trying again". If the status is OK, prints "PROGRAM: connected again".
void SayConnection(Terminal& terminal, const Status& status);

// Returns the beginning of `text` (UTF-8) that fits into `columns`. Each character counts as one
// column.
std::string CutToColumns(const std::string& text, size_t columns);

// Shows the progress of long work on `err`. On a terminal it is a bar, redrawn at most ten times
// per second and cut to the terminal's width. Elsewhere it is one line every ten seconds. Not
// thread-safe.
class Progress {
 public:
  // With `total` 0, shows the text without a bar.
  Progress(Terminal& terminal, std::string label, uint64_t total = 1'000'000);
  // Clears the bar.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // Draws if an update is due. Otherwise it only reads the clock.
  void Show(uint64_t done, const std::string& text = {});
  // Returns a callback that shows the progress as a fraction, 0 to 1. The callback is for code that
  // must not depend on Terminal. REQUIRES: this object outlives the callback.
  std::function<void(double share, const std::string& text)> OnShare() {
    return [this](double share, const std::string& text) {
      Show(static_cast<uint64_t>(share * static_cast<double>(total_)), text);
    };
  }
  // Returns whether Show would draw now. If not, the caller can skip composing the text.
  bool due() const;
  // Writes a line above the bar.
  void Line(const std::string& text);
  // Clears the bar, so that another stream can write to the same terminal.
  void ClearBar();

 private:
  using Time = std::chrono::steady_clock::time_point;

  void Draw(uint64_t done, const std::string& text);

  Terminal& terminal_;
  std::string label_;
  uint64_t total_;
  Time drawn_at_;
  bool drawn_ = false;
};

}  // namespace sweepstake::cli
