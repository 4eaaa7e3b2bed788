#include "engine_client/decider/audit/rederive.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "engine_client/decider/audit/audit_csv.h"
#include "engine_client/decider/audit/audit_log.h"
#include "engine_client/decider/session/decision_session.h"
#include "engine_client/math/hash.h"

namespace sweepstake::decision {
namespace {

// An error in a row. `column` is empty if no single column is wrong.
struct Problem {
  std::string column;
  std::string message;
};
using Result = std::optional<Problem>;

const std::string kHashColumn = "log_hash";

// Compares the cells of two rows and describes the first difference.
Result Compare(const AuditRow& logged, const AuditRow& derived) {
  constexpr uint64_t kStart = math::kFnv1aStart;
  if (logged.log_hash == derived.log_hash &&
      AuditHash(kStart, logged) == AuditHash(kStart, derived))
    return std::nullopt;
  const auto a = AuditCells(logged);
  const auto b = AuditCells(derived);
  static const std::vector<std::string> no_cells(AuditColumns().size());
  for (size_t item = 0; item < std::max(a.size(), b.size()); ++item) {
    const auto& cells = item < a.size() ? a[item] : no_cells;
    const auto& expected = item < b.size() ? b[item] : no_cells;
    for (size_t i = 1; i < cells.size(); ++i) {
      if (cells[i] == expected[i]) continue;
      if (AuditColumns()[i] == kHashColumn) break;
      const auto text = [](const std::string& cell) { return cell.empty() ? "nothing" : cell; };
      return Problem{AuditColumns()[i], "the log has " + text(cells[i]) +
                                            ", but deriving the row again gives " +
                                            text(expected[i])};
    }
  }
  return Problem{kHashColumn, "does not match: a field of this row was edited"};
}

// Checks that every sum in the arms' runs is finite and not negative.
struct SumCheck {
  bool ok = true;

  template <typename T>
  void operator()(std::string_view name, const T& value) {
    if constexpr (AuditStruct<const T>) {
      VisitFields(value, *this);
    } else if constexpr (kIsOptional<T>) {
      if (value) (*this)(name, *value);
    } else if constexpr (std::same_as<T, double>) {
      ok = ok && value >= 0 && std::isfinite(value);
    }
  }
};

// Derives the decisions of one segment again and compares their rows with the log.
class Segment final : public AuditSink {
 public:
  explicit Segment(PolicyRegistry policies) : policies_(policies) {}

  // Applies the row's event to the session, and compares the row that the session makes with the
  // logged one.
  Result Take(const AuditRow& row) {
    if (Result problem = Apply(row)) return problem;
    return Compare(row, derived_);
  }

  void OnAuditRow(const AuditRow& row) override { derived_ = row; }

 private:
  Result Apply(const AuditRow& row);
  Result Begin(const AuditRow& row);
  Result ApplyTick(const AuditRow& row);
  Result ApplySwitch(const AuditRow& row);
  Result ApplyOrder(const AuditRow& row);
  Result ReadTime(const AuditRow& row);
  // Restores the arms' runs from the row. The log contains the runs instead of the frames since the
  // previous row.
  Result RestoreRuns(const AuditRow& row);
  Result ReadArm(const AuditRow& row, uint32_t& arm) const;

  PolicyRegistry policies_;
  std::unique_ptr<DecisionSession> session_;
  int64_t now_ns_ = 0;
  AuditRow derived_;
};

Result Segment::Apply(const AuditRow& row) {
  if ((row.kind == AuditKind::kSetup) == (session_ != nullptr)) {
    return Problem{"kind", session_
                               ? "is setup, but only the first row of a segment may be a setup row"
                               : "is not setup, but a segment begins with its setup row; "
                                 "rows before this one are missing"};
  }
  if (row.kind == AuditKind::kRefusal) {
    session_->ObserveRefusal(row.command_id.value_or(0));
    return std::nullopt;
  }
  if (Result problem = ReadTime(row)) return problem;
  if (row.kind == AuditKind::kSetup) return Begin(row);
  if (row.kind == AuditKind::kOrder) return ApplyOrder(row);
  // The row's runs are those after its descriptor.
  if (row.kind == AuditKind::kTick && row.scene) session_->ObserveDescriptor(*row.scene);
  if (Result problem = RestoreRuns(row)) return problem;
  switch (row.kind) {
    case AuditKind::kTick:
      return ApplyTick(row);
    case AuditKind::kBailOut:
      session_->ObserveBailOut(row.frame.value_or(FrameSample{}), now_ns_);
      return std::nullopt;
    case AuditKind::kSwitch:
      return ApplySwitch(row);
    case AuditKind::kMode: {
      uint32_t arm = 0;
      if (Result problem = ReadArm(row, arm)) return problem;
      session_->SetMode(row.mode, arm, now_ns_);
      return std::nullopt;
    }
    default:
      return Problem{"kind", "does not occur in the segment of a session"};
  }
}

Result Segment::Begin(const AuditRow& row) {
  if (!row.setup) return Problem{"kind", "is setup, but the setup columns of the row are empty"};
  if (const auto invalid = Validate(row.setup->setup, policies_)) return Problem{"setup", *invalid};
  AuditOrigin origin = row.setup->origin;
  origin.session_id = row.session;
  origin.segment = row.segment;
  session_ = std::make_unique<DecisionSession>(row.setup->setup, policies_);
  StartAudit(*session_, *this, std::move(origin));
  return std::nullopt;
}

Result Segment::ApplyTick(const AuditRow& row) {
  if (now_ns_ < session_->next_tick_ns()) {
    return Problem{"time_ns", "is too early: the next tick is due at " +
                                  std::to_string(session_->next_tick_ns())};
  }
  session_->ObserveShadow(row.shadow);
  session_->Tick(now_ns_);
  return std::nullopt;
}

Result Segment::ApplySwitch(const AuditRow& row) {
  uint32_t arm = 0;
  if (Result problem = ReadArm(row, arm)) return problem;
  const SwitchCost cost = row.switch_cost.value_or(SwitchCost{});
  if (cost.ended_trial && cost.ended_trial->arm >= session_->arms().size())
    return Problem{"switch_cost_ended_trial_arm", "is not an arm of the setup row"};
  session_->ObserveSwitch(arm, row.switch_epoch.value_or(0), row.reason, now_ns_, cost);
  return std::nullopt;
}

Result Segment::ApplyOrder(const AuditRow& row) {
  OrderReport order{row.operator_name, row.mode, std::nullopt, now_ns_};
  if (!row.arm.empty()) {
    if (Result problem = ReadArm(row, order.arm.emplace())) return problem;
  }
  session_->ObserveOrder(order);
  return std::nullopt;
}

Result Segment::ReadTime(const AuditRow& row) {
  constexpr int64_t kLatestNs = int64_t{1} << 62;  // 146 years; differences cannot overflow
  now_ns_ = row.time_ns.value_or(kLatestNs + 1);
  if (now_ns_ >= -kLatestNs && now_ns_ <= kLatestNs) return std::nullopt;
  return Problem{"time_ns", "is empty or not from -2^62 to 2^62"};
}

Result Segment::RestoreRuns(const AuditRow& row) {
  SumCheck sums;
  sums("runs", row.runs);
  if (!row.runs || !sums.ok)
    return Problem{"runs", "is empty, or has a sum that is negative or not finite"};
  if (session_->RestoreRuns(*row.runs)) return std::nullopt;
  return Problem{"runs", "has an arm or switch epoch that does not follow from the rows before"};
}

Result Segment::ReadArm(const AuditRow& row, uint32_t& arm) const {
  const auto& arms = session_->arms();
  const auto found = std::find(arms.begin(), arms.end(), row.arm);
  if (found == arms.end()) return Problem{"arm", "is not an arm of the setup row"};
  arm = static_cast<uint32_t>(found - arms.begin());
  return std::nullopt;
}

// Derives a whole log again, segment by segment.
class Rederivation {
 public:
  explicit Rederivation(PolicyRegistry policies) : policies_(policies) {}

  // Processes the next row. `line` is its line in the file, or 0. Returns false after a difference.
  bool Take(const AuditRow& row, uint64_t line = 0) {
    if (Result problem = Check(row)) {
      report_.difference = {line,    row.session,     row.segment,
                            row.row, problem->column, problem->message};
    }
    return !report_.difference;
  }

  AuditReport& report() { return report_; }

 private:
  using SegmentKey = std::pair<std::string, uint32_t>;

  Result Check(const AuditRow& row) {
    if (Result problem = EnterSegment(row)) return problem;
    if (row.kind == AuditKind::kMissing) return SkipMissing(row);
    if (Result problem = segment_ ? segment_->Take(row) : CheckHash(row)) return problem;
    after_missing_ = false;
    if (row.session == kAdminSession) return std::nullopt;
    ++report_.row_count;
    if (row.decision) ++(segment_ ? report_.decision_count : report_.underived_decision_count);
    return std::nullopt;
  }

  Result EnterSegment(const AuditRow& row) {
    SegmentKey key(row.session, row.segment);
    if (current_ != nullptr && key == *current_) return CheckNumber(row.row);
    if (row.row != 1) return Problem{"row", "begins a segment whose first rows are missing"};
    current_ = &*segments_.insert(std::move(key)).first;
    row_in_segment_ = 1;
    after_missing_ = false;
    hash_ = math::kFnv1aStart;
    segment_.reset();
    if (row.session == kAdminSession) return std::nullopt;
    segment_ = std::make_unique<Segment>(policies_);
    if (sessions_.insert(row.session).second) ++report_.session_count;
    if (row.kind != AuditKind::kMissing) ++report_.segment_count;
    return std::nullopt;
  }

  // Checks that rows are numbered consecutively. After a `missing` row, any later number may
  // follow.
  Result CheckNumber(uint64_t number) {
    const uint64_t expected = row_in_segment_ + 1;
    row_in_segment_ = number;
    if (number == expected || (after_missing_ && number > expected)) return std::nullopt;
    return Problem{"row",
                   "should be " + std::to_string(expected) + "; rows are missing or out of order"};
  }

  Result SkipMissing(const AuditRow& row) {
    if (Compare(row, MissingRow(row.session, row.segment, row.row)))
      return Problem{"", "this row stands for missing rows, but its other columns are not empty"};
    if (segment_) ++report_.incomplete_segment_count;
    segment_.reset();
    hash_.reset();
    after_missing_ = true;
    return std::nullopt;
  }

  // For a row that cannot be derived: checks that its hash continues the hash of the row before it.
  Result CheckHash(const AuditRow& row) {
    if (hash_ && AuditHash(*hash_, row) != row.log_hash)
      return Problem{kHashColumn, "does not match: a field of this row was edited"};
    hash_ = row.log_hash;
    return std::nullopt;
  }

  PolicyRegistry policies_;
  AuditReport report_;
  std::set<std::string> sessions_;
  std::set<SegmentKey> segments_;
  const SegmentKey* current_ = nullptr;
  std::unique_ptr<Segment> segment_;  // null after missing rows, and for rows of administrators
  uint64_t row_in_segment_ = 0;       // number of the latest row
  bool after_missing_ = false;        // the latest row was a `missing` row
  std::optional<uint64_t> hash_;      // log_hash of the previous row if it cannot be derived
};

}  // namespace

std::string AuditDifference::Text() const {
  std::string text = line > 0 ? "line " + std::to_string(line) + ": " : "";
  if (!session.empty()) {
    text += "session " + session + ", segment " + std::to_string(segment) + ", row " +
            std::to_string(row) + (column.empty() ? ": " : ", ");
  }
  return text + column + (column.empty() ? "" : " ") + message;
}

AuditReport Rederive(std::span<const AuditRow> rows, PolicyRegistry policies) {
  Rederivation derivation(policies);
  for (const AuditRow& row : rows) {
    if (!derivation.Take(row)) break;
  }
  return std::move(derivation.report());
}

AuditReport RederiveCsv(std::string_view csv, PolicyRegistry policies) {
  Rederivation derivation(policies);
  AuditReport& report = derivation.report();
  AuditCsvReader reader(csv);
  AuditRow row;
  while (!report.difference && reader.Next(row)) derivation.Take(row, reader.line());
  if (!report.difference && !reader.problem().empty()) {
    report.difference = {.line = reader.line(),
                         .session = reader.column().empty() ? "" : row.session,
                         .segment = row.segment,
                         .row = row.row,
                         .column = reader.column(),
                         .message = reader.problem()};
  }
  return std::move(report);
}

}  // namespace sweepstake::decision
