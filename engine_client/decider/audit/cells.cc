#include "engine_client/decider/audit/cells.h"

#include <tuple>
#include <utility>
#include <vector>

#include "engine_client/decider/audit/cell_text.h"
#include "engine_client/decider/audit/setup_members.h"

namespace sweepstake::decision {
namespace {

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

class Appender {
 public:
  explicit Appender(std::string& out) : out_(out) {}

  template <typename T>
  void operator()(std::string_view key, const T& value) {
    if (!std::exchange(first_, false)) out_ += ';';
    out_.append(key).append("=");
    AppendValue(out_, value);
  }

  template <typename T>
  void IfAny(std::string_view key, const std::vector<T>& list) {
    if (!list.empty()) (*this)(key, list);
  }

 private:
  std::string& out_;
  bool first_ = true;
};

}  // namespace

void AppendRuns(std::string& out, const ArmRuns& runs) {
  const auto& [active, later, active_frames_seen] = ArmRuns::Fields(runs);
  AppendText(out, active_frames_seen);
  AppendText(out += ' ', ArmRun::Fields(active));
  if (later) AppendText(out += ' ', ArmRun::Fields(*later));
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

}  // namespace sweepstake::decision
