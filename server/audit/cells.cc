#include "server/audit/cells.h"

#include <cmath>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "server/audit/cell_text.h"

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

void AppendValue(std::string& out, const std::string& text) { AppendEscaped(out, text); }
void AppendValue(std::string& out, Mode mode) { AppendName(out, kModeNames, mode); }
void AppendValue(std::string& out, const BetaPosterior& prior) {
  AppendText(out, std::tie(prior.alpha, prior.beta));
}
template <typename T>
requires AuditNumber<T> || std::same_as<T, bool>
void AppendValue(std::string& out, T value) { AppendText(out, value); }
template <typename T>
void AppendValue(std::string& out, const std::vector<T>& list) {
  for (size_t i = 0; i < list.size(); ++i) {
    if (i > 0) out += ',';
    AppendValue(out, list[i]);
  }
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

// Calls visit(key, member) for every member. A new member does not compile until it is here.
template <EitherConst<DecisionOptions> Options, typename Visit>
void VisitOptions(Options& options, Visit& visit) {
  auto& [policy, weights, decision_interval_ns, cooldown_ns, settling_ns, bail_out_ns,
         exploration_warm_up_ns, exploration_measure_ns, explore, bail_out_penalty, fps_floor] =
      options;
  auto& [weight_fps, weight_detection, weight_memory, weight_checks] = weights;
  visit("policy", policy);
  visit("weight_fps", weight_fps);
  visit("weight_detection", weight_detection);
  visit("weight_memory", weight_memory);
  visit("weight_checks", weight_checks);
  visit("decision_interval_ns", decision_interval_ns);
  visit("cooldown_ns", cooldown_ns);
  visit("settling_ns", settling_ns);
  visit("bail_out_ns", bail_out_ns);
  visit("exploration_warm_up_ns", exploration_warm_up_ns);
  visit("exploration_measure_ns", exploration_measure_ns);
  visit("explore", explore);
  visit("bail_out_penalty", bail_out_penalty);
  visit("fps_floor", fps_floor);
}

template <EitherConst<SessionSetup> Setup, typename Visit>
void VisitSetup(Setup& setup, Visit& visit) {
  auto& [options, arms, priors, seed, mode, active_arm, switch_epoch, start_ns, explored_arm_count,
         decision_count] = setup;
  visit("arms", arms);
  VisitOptions(options, visit);
  visit("priors", priors);
  visit("seed", seed);
  visit("mode", mode);
  visit("active_arm", active_arm);
  visit("switch_epoch", switch_epoch);
  visit("start_ns", start_ns);
  visit("explored_arm_count", explored_arm_count);
  visit("decision_count", decision_count);
}

template <EitherConst<AuditOrigin> Origin, typename Visit>
void VisitOrigin(Origin& origin, Visit& visit) {
  visit("project", origin.project);
  visit("scene", origin.scene);
  visit("machine_class", origin.machine_class);
  visit("program_version", origin.program_version);
  visit("backend_versions", origin.backend_versions);
  visit("unix_start_ms", origin.unix_start_ms);
}

class Appender {
 public:
  explicit Appender(std::string& out) : out_(out) {}

  template <typename T>
  void operator()(std::string_view key, const T& value) {
    if (!std::exchange(first_, false)) out_ += ';';
    out_.append(key).append("=");
    AppendValue(out_, value);
  }

 private:
  std::string& out_;
  bool first_ = true;
};

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

  std::string_view rest() const { return text_; }

 private:
  std::string_view text_;
  std::string& problem_;
};

}  // namespace

void AppendRuns(std::string& out, const ArmRuns& runs) {
  const auto& [active, later, active_frames_seen] = ArmRuns::Fields(runs);
  AppendText(out, active_frames_seen);
  AppendText(out += ' ', ArmRun::Fields(active));
  if (later) AppendText(out += ' ', ArmRun::Fields(*later));
}

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

void AppendEscaped(std::string& out, std::string_view text) {
  for (const char c : text) {
    if (c == '\\' || c == ';' || c == ',') out += '\\';
    out += c;
  }
}

void AppendSetup(std::string& out, const SessionSetup& setup, const AuditOrigin& origin) {
  Appender appender(out);
  VisitOrigin(origin, appender);
  VisitSetup(setup, appender);
}

std::optional<AuditSetup> ParseSetup(std::string_view text, std::string& problem) {
  problem.clear();
  AuditSetup parsed;
  Parser parser(text, problem);
  VisitOrigin(parsed.origin, parser);
  VisitSetup(parsed.setup, parser);
  if (problem.empty() && !parser.rest().empty()) problem = "it goes on after its end";
  return problem.empty() ? std::optional(std::move(parsed)) : std::nullopt;
}

}  // namespace sweepstake::decision
