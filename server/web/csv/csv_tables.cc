#include "server/web/csv/csv_tables.h"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <utility>

#include "absl/strings/ascii.h"
#include "engine_client/telemetry/conversion/log_histogram.h"
#include "engine_client/telemetry/conversion/proto_conversion.h"
#include "server/web/csv/csv_lines.h"
#include "sweepstake/v1/audit.pb.h"
#include "sweepstake/v1/history.pb.h"
#include "sweepstake/v1/posteriors.pb.h"
#include "sweepstake/v1/priors.pb.h"
#include "sweepstake/v1/sessions.pb.h"

namespace sweepstake::web {
namespace {

using google::protobuf::Message;

constexpr double kNsPerUs = 1e3;
constexpr double kNsPerMs = 1e6;

// Returns the name of an enumeration's value without its prefix, such as "held cooldown".
std::string WordOf(std::string_view name, std::string_view prefix) {
  if (name == std::string(prefix) + "UNSPECIFIED" || name.size() < prefix.size()) return "";
  std::string word = absl::AsciiStrToLower(std::string(name.substr(prefix.size())));
  std::replace(word.begin(), word.end(), '_', ' ');
  return word;
}
std::string KindWord(v1::AuditKind kind) { return WordOf(v1::AuditKind_Name(kind), "AUDIT_KIND_"); }
std::string OutcomeWord(v1::DecisionOutcome outcome) {
  return WordOf(v1::DecisionOutcome_Name(outcome), "DECISION_OUTCOME_");
}
std::string ReasonWord(v1::SwitchReason reason) {
  return WordOf(v1::SwitchReason_Name(reason), "SWITCH_REASON_");
}
std::string ModeWord(v1::Mode mode) { return WordOf(v1::Mode_Name(mode), "MODE_"); }
std::string VerdictWord(v1::Verdict verdict) {
  return WordOf(v1::Verdict_Name(verdict), "VERDICT_");
}

// A table with one column per entry of `columns`.
template <size_t kCount>
std::string HeaderOf(const std::array<std::string_view, kCount>& columns) {
  CsvLines lines;
  for (const std::string_view column : columns) lines.Text(column);
  lines.End();
  return lines.Take();
}

// A table whose lines depend on single rows of the audit log, and on the setups of their segments.
class RowTable : public CsvTable {
 public:
  std::string Lines(const Message& response) final {
    const auto& part = static_cast<const v1::ExportDecisionsResponse&>(response);
    for (const v1::SegmentSetup& setup : part.setups())
      setups_[{setup.session_id(), setup.segment()}] = setup.setup();
    CsvLines lines;
    for (const v1::AuditRow& row : part.rows()) {
      const auto setup = setups_.find({row.session(), row.segment()});
      Add(row, setup == setups_.end() ? nullptr : &setup->second, lines);
    }
    // The next response can continue only the last segment.
    if (part.rows_size() > 0) {
      const v1::AuditRow& last = part.rows(part.rows_size() - 1);
      std::erase_if(setups_, [&](const auto& entry) {
        return entry.first != std::pair(last.session(), last.segment());
      });
    }
    return lines.Take();
  }

 protected:
  // Adds the lines of a row. `setup` is null if the segment's first row was removed.
  virtual void Add(const v1::AuditRow& row, const v1::AuditSetup* setup, CsvLines& lines) const = 0;

  // Writes the row's time by the wall clock, as UnixMsOf in server/rpc/services/decision_rows.h
  // computes it.
  static void AddTime(const v1::AuditRow& row, const v1::AuditSetup* setup, CsvLines& lines) {
    if (row.has_unix_ms()) return lines.Time(row.unix_ms());
    if (setup == nullptr || !row.has_time_ns()) return lines.Nothing();
    lines.Time(setup->unix_start_ms() + (row.time_ns() - setup->start_ns()) / 1'000'000);
  }

 private:
  std::map<std::pair<std::string, uint32_t>, v1::AuditSetup> setups_;
};

// All rows of the audit log that match a filter.
class Decisions final : public RowTable {
 public:
  std::string Header() const override {
    return HeaderOf<25>({"time",
                         "project",
                         "scene",
                         "session",
                         "part",
                         "row",
                         "kind",
                         "decision",
                         "active algorithm",
                         "candidate",
                         "outcome",
                         "commanded or new algorithm",
                         "reason",
                         "reward",
                         "leader",
                         "P(best) of the leader",
                         "expected loss (ratio)",
                         "verdict",
                         "expected gain (log ratio)",
                         "expected loss of a switch (ratio)",
                         "switch cost (s)",
                         "horizon (s)",
                         "mode",
                         "by",
                         "action"});
  }

 private:
  void Add(const v1::AuditRow& row, const v1::AuditSetup* setup, CsvLines& lines) const override {
    AddTime(row, setup, lines);
    lines.Text(setup == nullptr ? "" : setup->project());
    lines.Text(setup == nullptr ? "" : setup->scene());
    lines.Text(row.session());
    lines.Number(row.segment());
    lines.Number(row.row());
    lines.Text(KindWord(row.kind()));
    const v1::AuditDecision& decision = row.decision();
    lines.Number(row.has_decision() ? std::optional(decision.id()) : std::nullopt);
    lines.Text(decision.active_arm());
    lines.Text(decision.candidate());
    lines.Text(OutcomeWord(decision.outcome()));
    lines.Text(row.arm());
    lines.Text(ReasonWord(row.reason()));
    lines.Number(decision.has_reward() ? std::optional(decision.reward()) : std::nullopt);
    lines.Text(decision.leader());
    if (const auto& best = decision.best_probability(); best.empty()) {
      lines.Nothing();
    } else {
      lines.Number(*std::max_element(best.begin(), best.end()));
    }
    lines.Number(decision.leader().empty() ? std::nullopt
                                           : std::optional(decision.expected_loss_ratio()));
    lines.Text(VerdictWord(decision.verdict()));
    if (decision.has_gate()) {
      lines.Number(decision.gate().gain());
      lines.Number(decision.gate().loss());
      lines.Number(decision.gate().cost_s());
      lines.Number(decision.gate().horizon_s());
    } else {
      lines.Nothing(4);
    }
    lines.Text(ModeWord(row.mode()));
    lines.Text(row.operator_name());
    lines.Text(row.action());
    lines.End();
  }
};

// The costs of every decision window. Windows without frames are left out.
class Windows final : public RowTable {
 public:
  std::string Header() const override {
    return HeaderOf<9>({"time", "session", "decision", "algorithm", "frames",
                        "mean frame time (ms)", "mean detection time (µs)", "AABB checks per frame",
                        "peak memory (bytes)"});
  }

 private:
  void Add(const v1::AuditRow& row, const v1::AuditSetup* setup, CsvLines& lines) const override {
    if (!row.has_decision()) return;
    // Without frames of a known regime, the new frames count, as in windowOf of the dashboard's
    // src/live/audit/steps.ts.
    const v1::AuditRun& run = row.runs().active();
    const v1::AuditWindow& window =
        run.window().frame_count() > 0 ? run.window() : run.new_frames();
    if (window.frame_count() == 0) return;
    const auto frames = static_cast<double>(window.frame_count());
    AddTime(row, setup, lines);
    lines.Text(row.session());
    lines.Number(row.decision().id());
    lines.Text(row.decision().active_arm());
    lines.Number(window.frame_count());
    lines.Number(window.time_ns() / frames / kNsPerMs);
    if (window.ordinary_frame_count() > 0) {
      lines.Number(window.ordinary_detection_ns() /
                   static_cast<double>(window.ordinary_frame_count()) / kNsPerUs);
    } else {
      lines.Nothing();
    }
    lines.Number(window.check_count() / frames);
    lines.Number(window.peak_bytes());
    lines.End();
  }
};

// The posterior of each algorithm after every decision.
class Posteriors final : public RowTable {
 public:
  std::string Header() const override {
    return HeaderOf<7>({"time", "session", "decision", "algorithm", "alpha", "beta", "P(best)"});
  }

 private:
  void Add(const v1::AuditRow& row, const v1::AuditSetup* setup, CsvLines& lines) const override {
    const v1::AuditDecision& decision = row.decision();
    for (int i = 0; i < decision.posteriors_size(); ++i) {
      AddTime(row, setup, lines);
      lines.Text(row.session());
      lines.Number(decision.id());
      lines.Text(setup != nullptr && i < setup->arms_size() ? setup->arms(i) : "");
      lines.Number(decision.posteriors(i).alpha());
      lines.Number(decision.posteriors(i).beta());
      lines.Number(i < decision.best_probability_size()
                       ? std::optional(decision.best_probability(i))
                       : std::nullopt);
      lines.End();
    }
  }
};

// The posterior of each algorithm in each scene.
class Scenes final : public CsvTable {
 public:
  std::string Header() const override {
    return HeaderOf<25>({"project",
                         "scene",
                         "machines",
                         "reward version",
                         "verdict",
                         "leader",
                         "expected loss (ratio)",
                         "sessions",
                         "sources",
                         "algorithm",
                         "backend version",
                         "is outdated",
                         "alpha",
                         "beta",
                         "reward low 95 %",
                         "reward high 95 %",
                         "P(best)",
                         "cost ratio to the leader",
                         "cost ratio low 95 %",
                         "cost ratio high 95 %",
                         "equivalent windows",
                         "windows",
                         "bail-outs",
                         "lane visits",
                         "last seen"});
  }
  std::string Lines(const Message& response) override {
    CsvLines lines;
    for (const v1::ScenePosterior& scene :
         static_cast<const v1::ListPosteriorsResponse&>(response).scenes()) {
      for (const v1::ArmPosterior& arm : scene.arms()) Add(scene, arm, lines);
    }
    return lines.Take();
  }

 private:
  static void Add(const v1::ScenePosterior& scene, const v1::ArmPosterior& arm, CsvLines& lines) {
    lines.Text(scene.project());
    lines.Text(scene.scene());
    lines.Text(scene.machine_class());
    lines.Number(scene.reward_version());
    if (IsChanging(scene)) {
      lines.Text("changing");
      lines.Nothing(2);
    } else {
      lines.Text(VerdictWord(scene.verdict()));
      lines.Text(scene.leader_arm());
      lines.Number(scene.expected_loss_ratio());
    }
    lines.Number(scene.active_session_count());
    lines.Number(scene.source_count());
    lines.Text(arm.arm());
    lines.Number(arm.backend_version());
    lines.Text(arm.is_outdated() ? "yes" : "no");
    lines.Number(arm.posterior().alpha());
    lines.Number(arm.posterior().beta());
    lines.Number(arm.posterior().low_95());
    lines.Number(arm.posterior().high_95());
    lines.Number(arm.has_best_probability() ? std::optional(arm.best_probability()) : std::nullopt);
    AddRatio(arm, lines);
    lines.Number(arm.effective_window_count());
    lines.Number(arm.window_count());
    lines.Number(arm.bail_out_count());
    lines.Number(arm.visit_count());
    lines.Time(arm.unix_last_seen_s() * 1'000);
    lines.End();
  }
  static void AddRatio(const v1::ArmPosterior& arm, CsvLines& lines) {
    if (!arm.has_cost_ratio()) return lines.Nothing(3);
    lines.Number(arm.cost_ratio().median());
    lines.Number(arm.cost_ratio().low());
    lines.Number(arm.cost_ratio().high());
  }
};

// The sessions in the daemon's memory.
class Sessions final : public CsvTable {
 public:
  std::string Header() const override {
    return HeaderOf<11>({"session", "project", "scene", "build", "address", "state", "mode",
                         "active algorithm", "began", "last message", "dropped frames"});
  }
  std::string Lines(const Message& response) override {
    CsvLines lines;
    for (const v1::SessionInfo& session :
         static_cast<const v1::ListSessionsResponse&>(response).sessions()) {
      lines.Text(session.session_id());
      lines.Text(session.project());
      lines.Text(session.scene());
      lines.Text(session.build());
      lines.Text(session.client_address());
      lines.Text(WordOf(v1::SessionState_Name(session.state()), "SESSION_STATE_"));
      lines.Text(ModeWord(session.mode()));
      lines.Text(session.active_arm());
      lines.Time(session.unix_start_ms());
      lines.Time(session.unix_last_message_ms());
      lines.Number(session.dropped_frame_count());
      lines.End();
    }
    return lines.Take();
  }
};

// The stored evidence of each source.
class Evidence final : public CsvTable {
 public:
  std::string Header() const override {
    return HeaderOf<18>({"project", "scene", "machines", "reward version", "regime", "algorithm",
                         "backend version", "measured", "source", "build", "alpha", "beta",
                         "windows", "bail-outs", "last seen", "is imported", "is in quarantine",
                         "weight"});
  }
  std::string Lines(const Message& response) override {
    CsvLines lines;
    for (const v1::PriorRecord& record :
         static_cast<const v1::ExportPriorsResponse&>(response).records()) {
      lines.Text(record.project());
      lines.Text(record.scene());
      lines.Text(record.machine_class());
      lines.Number(record.reward_version());
      lines.Text(record.regime());
      lines.Text(record.arm());
      lines.Number(record.backend_version());
      lines.Text(record.measured_by().empty() ? "live" : "shadow lane");
      lines.Text(record.source_id());
      lines.Text(record.build());
      lines.Number(record.alpha_increment());
      lines.Number(record.beta_increment());
      lines.Number(record.window_count());
      lines.Number(record.bail_out_count());
      lines.Time(record.unix_last_seen_s() * 1'000);
      lines.Text(record.is_imported() ? "yes" : "no");
      lines.Text(record.is_quarantined() ? "yes" : "no");
      lines.Number(record.weight());
      lines.End();
    }
    return lines.Take();
  }
};

// The parts of the audit log.
class Logs final : public CsvTable {
 public:
  std::string Header() const override {
    return HeaderOf<8>(
        {"began", "session", "part", "project", "scene", "rows", "first row", "lost rows"});
  }
  std::string Lines(const Message& response) override {
    CsvLines lines;
    for (const v1::AuditSegment& segment :
         static_cast<const v1::ListAuditSegmentsResponse&>(response).segments()) {
      lines.Time(segment.unix_start_ms());
      lines.Text(segment.session_id());
      lines.Number(segment.segment());
      lines.Text(segment.project());
      lines.Text(segment.scene());
      lines.Number(segment.row_count());
      lines.Number(segment.first_row());
      lines.Number(segment.lost_row_count());
      lines.End();
    }
    return lines.Take();
  }
};

std::optional<double> Divided(std::optional<double> value, double by) {
  if (!value || by == 0) return std::nullopt;
  return *value / by;
}

// The history of scenes, builds or sessions: a line per point and algorithm.
class History final : public CsvTable {
 public:
  std::string Header() const override {
    return HeaderOf<25>({"start",
                         "end",
                         "project",
                         "scene",
                         "machines",
                         "reward version",
                         "build",
                         "session",
                         "algorithm",
                         "frames in which it ran",
                         "cost per frame (µs)",
                         "P(best)",
                         "estimated cost (µs)",
                         "measured frames",
                         "cost of what ran per frame (µs)",
                         "cost of the first algorithm per frame (µs)",
                         "switches",
                         "sessions",
                         "frame p50 (ms)",
                         "frame p95 (ms)",
                         "frame p99 (ms)",
                         "detection p50 (µs)",
                         "detection p95 (µs)",
                         "detection p99 (µs)",
                         "memory p95 (bytes)"});
  }
  std::string Lines(const Message& response) override {
    CsvLines lines;
    for (const v1::HistorySeries& series :
         static_cast<const v1::GetHistoryResponse&>(response).series()) {
      for (const v1::HistoryPoint& point : series.points()) {
        for (const v1::ArmHistory& arm : point.arms()) Add(series, point, arm, lines);
      }
    }
    return lines.Take();
  }

 private:
  static void Add(const v1::HistorySeries& series, const v1::HistoryPoint& point,
                  const v1::ArmHistory& arm, CsvLines& lines) {
    lines.Time(point.unix_ms());
    lines.Time(point.end_unix_ms());
    lines.Text(series.project());
    lines.Text(series.scene());
    lines.Text(series.machine_class());
    lines.Number(series.reward_version());
    lines.Text(series.build());
    lines.Text(series.session_id());
    lines.Text(arm.arm());
    lines.Number(arm.active_frame_count());
    lines.Number(Divided(arm.would_take_us(), static_cast<double>(arm.frame_count())));
    AddBelief(point.activity(), arm.arm(), lines);
    const auto frames = static_cast<double>(point.frame_count());
    lines.Number(point.frame_count());
    lines.Number(Divided(point.ran_us(), frames));
    lines.Number(Divided(point.initial_us(), frames));
    lines.Number(point.switch_count());
    lines.Number(point.session_count());
    for (const double share : {0.5, 0.95, 0.99})
      lines.Number(Divided(QuantileOf(point.frame_time_ns(), share), kNsPerMs));
    for (const double share : {0.5, 0.95, 0.99})
      lines.Number(Divided(QuantileOf(point.detection_time_ns(), share), kNsPerUs));
    lines.Number(QuantileOf(point.native_bytes(), 0.95));
    lines.End();
  }
  // Writes the belief over all regimes.
  static void AddBelief(const v1::SceneActivity& activity, const std::string& arm,
                        CsvLines& lines) {
    const auto& arms = activity.arms();
    const auto place = static_cast<int>(std::find(arms.begin(), arms.end(), arm) - arms.begin());
    if (place >= activity.total().arms_size()) return lines.Nothing(2);
    const v1::RegimeArm& belief = activity.total().arms(place);
    lines.Number(belief.best_probability());
    lines.Number(belief.cost_us() > 0 ? std::optional(belief.cost_us()) : std::nullopt);
  }
};

template <typename Table>
constexpr CsvKind Kind(std::string_view name, std::string_view method) {
  return {name, method, []() -> std::unique_ptr<CsvTable> { return std::make_unique<Table>(); }};
}

constexpr std::array kKinds = {
    Kind<Decisions>("decisions", "sweepstake.v1.AuditService/ExportDecisions"),
    Kind<Windows>("windows", "sweepstake.v1.AuditService/ExportDecisions"),
    Kind<Posteriors>("posteriors", "sweepstake.v1.AuditService/ExportDecisions"),
    Kind<Logs>("logs", "sweepstake.v1.AuditService/ListAuditSegments"),
    Kind<Scenes>("scenes", "sweepstake.v1.PosteriorsService/ListPosteriors"),
    Kind<Sessions>("sessions", "sweepstake.v1.SessionsService/ListSessions"),
    Kind<History>("history", "sweepstake.v1.HistoryService/GetHistory"),
    Kind<Evidence>("evidence", "sweepstake.v1.PriorsService/ExportPriors")};

}  // namespace

const CsvKind* FindCsv(std::string_view name) {
  const auto* const found = std::find_if(kKinds.begin(), kKinds.end(),
                                         [&](const CsvKind& kind) { return kind.name == name; });
  return found == kKinds.end() ? nullptr : found;
}

}  // namespace sweepstake::web
