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

// Results go to `out`, everything else to `err`. The streams are borrowed.
struct Terminal {
  std::ostream& out;
  std::ostream& err;
  bool out_is_tty = false;
  bool err_is_tty = false;
  size_t err_columns = 0;              // 0: `err` is not a terminal
  std::string program = "sweepstake";  // the name before each message
};

// Prints "PROGRAM: MESSAGE" and returns the exit code of the status: kUnreachable for
// kUnavailable, kCheckFailed for kInternal, kBadUsage for all others.
int Fail(Terminal& terminal, const Status& status);
// Does the same for the status of a call to a daemon. It returns kUnreachable also for
// kResourceExhausted, because a full daemon may serve the call later. It returns kBadUsage for
// kInvalidArgument. It returns kCheckFailed for all other errors, because the daemon understood and
// refused the call.
int FailAnswer(Terminal& terminal, const Status& status);

// Prints "PROGRAM: TEXT" to `err`.
void Say(Terminal& terminal, const std::string& text);
// Prints "PROGRAM: MESSAGE; trying again" or, if the status is OK, "PROGRAM: connected again".
void SayConnection(Terminal& terminal, const Status& status);

// Returns the beginning of `text` (UTF-8) that fits into `columns`, where each character takes one
// column.
std::string CutToColumns(const std::string& text, size_t columns);

// Shows the progress of long work on `err`. On a terminal it is a bar, redrawn at most ten times a
// second and cut to the terminal's width; elsewhere it is a line every ten seconds. Not
// thread-safe.
class Progress {
 public:
  // A `total` of 0 shows the text without a bar.
  Progress(Terminal& terminal, std::string label, uint64_t total = 1'000'000);
  // Clears the bar.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // Draws if an update is due, and only reads the clock otherwise.
  void Show(uint64_t done, const std::string& text = {});
  // Returns a callback for work that must not depend on Terminal. The callback shows the share of
  // the total, 0 to 1. REQUIRES: this object outlives the callback.
  std::function<void(double share, const std::string& text)> OnShare() {
    return [this](double share, const std::string& text) {
      Show(static_cast<uint64_t>(share * static_cast<double>(total_)), text);
    };
  }
  // Returns whether Show would draw now. If not, a caller need not compose a text.
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
