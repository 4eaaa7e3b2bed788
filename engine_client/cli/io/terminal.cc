#include "engine_client/cli/io/terminal.h"

#include <algorithm>
#include <utility>

#include "engine_client/text/names.h"

namespace sweepstake::cli {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using std::chrono::steady_clock;

constexpr uint64_t kProgressWidth = 30;

std::string Bar(uint64_t done, uint64_t total) {
  const uint64_t filled = kProgressWidth * std::min(done, total) / total;
  return "[" + std::string(filled, '#') + std::string(kProgressWidth - filled, '.') + "] " +
         std::to_string(100 * std::min(done, total) / total) + " %";
}

}  // namespace

int Fail(Terminal& terminal, const Status& status) {
  terminal.err << terminal.program << ": " << text::PrintableLines(status.message()) << '\n';
  if (status.code() == StatusCode::kUnavailable) return kUnreachable;
  return status.code() == StatusCode::kInternal ? kCheckFailed : kBadUsage;
}

int FailAnswer(Terminal& terminal, const Status& status) {
  const int exit_code = Fail(terminal, status);
  if (status.code() == StatusCode::kResourceExhausted) return kUnreachable;
  return exit_code == kBadUsage && status.code() != StatusCode::kInvalidArgument ? kCheckFailed
                                                                                 : exit_code;
}

void Say(Terminal& terminal, const std::string& text) {
  terminal.err << terminal.program << ": " << text::PrintableLines(text) << std::endl;
}

void SayConnection(Terminal& terminal, const Status& status) {
  Say(terminal, status.ok() ? "connected again" : status.message() + "; trying again");
}

std::string CutToColumns(const std::string& text, size_t columns) {
  size_t characters = 0;
  for (size_t at = 0; at < text.size(); ++at) {
    const bool starts_character = (static_cast<unsigned char>(text[at]) & 0xC0U) != 0x80U;
    if (starts_character && ++characters > columns) return text.substr(0, at);
  }
  return text;
}

Progress::Progress(Terminal& terminal, std::string label, uint64_t total)
    : terminal_(terminal),
      label_(std::move(label)),
      total_(total),
      drawn_at_(steady_clock::now() - (terminal.err_is_tty ? seconds(1) : seconds(5))) {}

Progress::~Progress() { ClearBar(); }

bool Progress::due() const {
  return steady_clock::now() - drawn_at_ >=
         (terminal_.err_is_tty ? milliseconds(100) : milliseconds(10'000));
}

void Progress::Show(uint64_t done, const std::string& text) {
  if (due()) Draw(done, text);
}

void Progress::Line(const std::string& text) {
  ClearBar();
  terminal_.err << text << std::endl;
}

void Progress::Draw(uint64_t done, const std::string& text) {
  drawn_at_ = steady_clock::now();
  ClearBar();
  std::string line = label_;
  if (total_ > 0) line += ' ' + Bar(done, total_);
  if (!text.empty()) line += ' ' + text;
  // Cut the line, because a line that wraps could not be cleared. One column stays free for the
  // cursor.
  if (terminal_.err_columns > 0) line = CutToColumns(line, terminal_.err_columns - 1);
  terminal_.err << line;
  if (!terminal_.err_is_tty) terminal_.err << '\n';
  terminal_.err << std::flush;
  drawn_ = terminal_.err_is_tty;
}

void Progress::ClearBar() {
  if (!drawn_) return;
  terminal_.err << "\r\x1b[K" << std::flush;
  drawn_ = false;
}

}  // namespace sweepstake::cli
