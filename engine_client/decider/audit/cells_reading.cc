// The reading half of cells.h. A game does not link it: it reads floating-point numbers with
// std::from_chars, which not every standard library has.
#include <cmath>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "engine_client/decider/audit/cell_text.h"
#include "engine_client/decider/audit/cells.h"
#include "engine_client/decider/audit/setup_members.h"

namespace sweepstake::decision {
namespace {

template <typename T>
bool IsSum(const T& value) {
  if constexpr (std::is_same_v<T, double>) {
    return value >= 0 && std::isfinite(value);
  } else {
    return true;
  }
}

std::optional<ArmRun> ParseRun(std::string_view text, uint32_t arm_count) {
  ArmRun run(0, 0, 0);
  const auto fields = ArmRun::Fields(run);
  const bool is_run = ParseText(text, fields) && run.arm() < arm_count &&
                      std::apply([](const auto&... each) { return (IsSum(each) && ...); }, fields);
  return is_run ? std::optional(run) : std::nullopt;
}

// Removes and returns the text before the first separator that has no backslash before it.
std::string_view TakeEscaped(std::string_view& text, char separator) {
  size_t length = 0;
  while (length < text.size() && text[length] != separator) length += text[length] == '\\' ? 2 : 1;
  const std::string_view item = text.substr(0, length);
  text = length < text.size() ? text.substr(length + 1) : std::string_view();
  return item;
}

bool ParseValue(std::string_view text, std::string& value) {
  value.clear();
  for (size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\\' && ++i == text.size()) return false;
    value += text[i];
  }
  return true;
}
bool ParseValue(std::string_view text, Mode& mode) { return ParseName(text, kModeNames, mode); }
bool ParseValue(std::string_view text, BetaPosterior& prior) {
  return ParseText(text, std::tie(prior.alpha, prior.beta));
}
template <typename T>
requires AuditNumber<T> || std::same_as<T, bool>
bool ParseValue(std::string_view text, T& value) { return ParseText(text, value); }
template <typename T>
bool ParseValue(std::string_view text, std::vector<T>& list) {
  list.clear();
  while (!text.empty()) {
    if (!ParseValue(TakeEscaped(text, ','), list.emplace_back())) return false;
  }
  return true;
}

class Parser {
 public:
  Parser(std::string_view text, std::string& problem) : text_(text), problem_(problem) {}

  template <typename T>
  void operator()(std::string_view key, T& value) {
    if (!problem_.empty()) return;
    std::string_view pair = TakeEscaped(text_, ';');
    if (TakeItem(pair, '=') != key) {
      problem_ = "it has no " + std::string(key) + " where it should";
    } else if (!ParseValue(pair, value)) {
      problem_ = std::string(key) + " is not readable";
    }
  }

  template <typename T>
  void IfAny(std::string_view key, std::vector<T>& list) {
    std::string_view rest = text_;
    std::string_view pair = TakeEscaped(rest, ';');
    if (TakeItem(pair, '=') == key) (*this)(key, list);
  }

  std::string_view rest() const { return text_; }

 private:
  std::string_view text_;
  std::string& problem_;
};

}  // namespace

std::optional<ArmRuns> ParseRuns(std::string_view text, uint32_t arm_count) {
  bool seen = false;
  if (!ParseText(TakeItem(text, ' '), seen)) return std::nullopt;
  const auto parsed = ParseRun(TakeItem(text, ' '), arm_count);
  if (!parsed) return std::nullopt;
  ArmRuns runs(arm_count, *parsed);
  auto&& [active, later, active_frames_seen] = ArmRuns::Fields(runs);
  active_frames_seen = seen;
  if (text.empty()) return runs;
  later = ParseRun(text, arm_count);
  return later ? std::optional(runs) : std::nullopt;
}

std::optional<AuditSetup> ParseSetup(std::string_view text, std::string& problem) {
  problem.clear();
  AuditSetup parsed;
  Parser parser(text, problem);
  VisitOrigin(parsed.origin, parser);
  VisitSetup(parsed.setup, parser);
  if (problem.empty() && !parser.rest().empty()) problem = "it has text after its last member";
  return problem.empty() ? std::optional(std::move(parsed)) : std::nullopt;
}

}  // namespace sweepstake::decision
