#include "engine_client/decider/audit/rederive.h"

#include <algorithm>
#include <charconv>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "engine_client/decider/audit/audit_log.h"
#include "engine_client/decider/audit/cell_text.h"
#include "engine_client/decider/audit/cells.h"
#include "engine_client/decider/audit/csv.h"
#include "engine_client/decider/session/decision_session.h"
#include "engine_client/math/hash.h"

namespace sweepstake::decision {
namespace {

using Cells = std::vector<std::string>;

// A problem and its column; without a column the row as a whole is wrong.
struct Problem {
  std::optional<AuditColumn> column;
  std::string message;
};

const std::string& CellOf(const Cells& cells, AuditColumn column) {
  return cells[static_cast<size_t>(column)];
}

Problem Unreadable(const Cells& cells, AuditColumn column) {
  const std::string& text = CellOf(cells, column);
  return {column, text.empty() ? "is empty" : "is not readable: " + text.substr(0, 80)};
}

Problem WrongHash() {
  return {AuditColumn::kLogHash, "does not match: a cell of this row was edited"};
}

bool IsOfKind(const Cells& cells, AuditKind kind) {
  return CellOf(cells, AuditColumn::kKind) == kAuditKindNames[static_cast<size_t>(kind)];
}

bool IsMissingRow(const Cells& cells) { return IsOfKind(cells, AuditKind::kMissing); }

// Returns whether the row belongs to a segment about administrators.
bool IsOfAdmin(const Cells& cells) { return CellOf(cells, AuditColumn::kSession) == kAdminSession; }

// Returns the part of a text around a difference.
std::string Excerpt(std::string_view text, size_t difference) {
  constexpr size_t kBefore = 24;
  constexpr size_t kLength = 72;
  const size_t begin = difference > kBefore ? difference - kBefore : 0;
  std::string excerpt = begin > 0 ? "…" : "";
  excerpt.append(text.substr(begin, kLength));
  if (text.size() > begin + kLength) excerpt += "…";
  return text.empty() ? "nothing" : excerpt;
}

std::string DifferenceText(std::string_view logged, std::string_view derived) {
  const auto [a, b] = std::mismatch(logged.begin(), logged.end(), derived.begin(), derived.end());
  const auto at = static_cast<size_t>(a - logged.begin());
  return "the log has " + Excerpt(logged, at) + ", derived again it is " + Excerpt(derived, at);
}

// Derives the decisions of one segment again and compares their rows with the log.
class Segment final : public AuditSink {
 public:
  explicit Segment(PolicyRegistry policies) : policies_(policies) {}

  // Applies the row's event and compares the row that it leads to with the logged one.
  std::optional<Problem> Take(const Cells& cells);

  void OnAuditRow(std::string_view row) override { derived_ = row; }

 private:
  using Result = std::optional<Problem>;

  Result Apply(const Cells& cells);
  Result Begin(const Cells& cells);
  Result ApplyTick(const Cells& cells);
  Result ApplyBailOut(const Cells& cells);
  Result ApplySwitch(const Cells& cells);
  Result ApplyRefusal(const Cells& cells);
  Result ApplyMode(const Cells& cells);
  Result ApplyOrder(const Cells& cells);
  // Restores the runs, in place of the frames since the previous row.
  Result RestoreRuns(const Cells& cells);
  Result ReadTime(const Cells& cells);
  Result ReadArm(const Cells& cells, uint32_t& arm) const;
  Result ReadShadow(const Cells& cells);
  Result Compare(const Cells& cells);

  PolicyRegistry policies_;
  std::unique_ptr<DecisionSession> session_;
  int64_t now_ns_ = 0;
  std::vector<ShadowSample> samples_;
  std::string derived_;
  Cells derived_cells_;
};

template <typename T>
std::optional<Problem> Read(const Cells& cells, AuditColumn column, T&& value) {
  if (ParseText(CellOf(cells, column), value)) return std::nullopt;
  return Unreadable(cells, column);
}

std::optional<Problem> Segment::Take(const Cells& cells) {
  derived_.clear();
  if (Result problem = Apply(cells)) return problem;
  return Compare(cells);
}

std::optional<Problem> Segment::Apply(const Cells& cells) {
  AuditKind kind{};
  const std::string& name = CellOf(cells, AuditColumn::kKind);
  if (!ParseName(name, kAuditKindNames, kind)) return Unreadable(cells, AuditColumn::kKind);
  if (kind != AuditKind::kRefusal) {
    if (Result problem = ReadTime(cells)) return problem;
  }
  if ((kind == AuditKind::kSetup) == (session_ != nullptr)) {
    return Problem{AuditColumn::kKind, session_ ? "is a setup row in the middle of a segment"
                                                : "is " + name +
                                                      ", but a segment begins with its setup row; "
                                                      "rows before this one are missing"};
  }
  switch (kind) {
    case AuditKind::kSetup:
      return Begin(cells);
    case AuditKind::kTick:
      return ApplyTick(cells);
    case AuditKind::kBailOut:
      return ApplyBailOut(cells);
    case AuditKind::kSwitch:
      return ApplySwitch(cells);
    case AuditKind::kRefusal:
      return ApplyRefusal(cells);
    case AuditKind::kMode:
      return ApplyMode(cells);
    case AuditKind::kOrder:
      return ApplyOrder(cells);
    case AuditKind::kMissing:
    case AuditKind::kAdmin:
      break;  // such rows are not derived
  }
  return Unreadable(cells, AuditColumn::kKind);
}

std::optional<Problem> Segment::Begin(const Cells& cells) {
  std::string problem;
  auto parsed = ParseSetup(CellOf(cells, AuditColumn::kSetup), problem);
  if (!parsed) return Problem{AuditColumn::kSetup, "is not readable: " + problem};
  if (const auto invalid = Validate(parsed->setup, policies_))
    return Problem{AuditColumn::kSetup, *invalid};
  parsed->origin.session_id = CellOf(cells, AuditColumn::kSession);
  if (Result unreadable = Read(cells, AuditColumn::kSegment, parsed->origin.segment))
    return unreadable;
  session_ = std::make_unique<DecisionSession>(std::move(parsed->setup), policies_);
  StartAudit(*session_, *this, std::move(parsed->origin));
  return std::nullopt;
}

std::optional<Problem> Segment::ApplyTick(const Cells& cells) {
  if (now_ns_ < session_->next_tick_ns()) {
    return Problem{AuditColumn::kTimeNs, "is earlier than the next tick, which is due at " +
                                             std::to_string(session_->next_tick_ns())};
  }
  if (Result problem = RestoreRuns(cells)) return problem;
  if (Result problem = ReadShadow(cells)) return problem;
  session_->ObserveShadow(samples_);
  if (!CellOf(cells, AuditColumn::kDescriptor).empty()) {
    SceneDescriptor scene;
    if (Result problem = Read(cells, AuditColumn::kDescriptor, FieldsOf(scene))) return problem;
    session_->ObserveDescriptor(scene);
  }
  session_->Tick(now_ns_);
  return std::nullopt;
}

std::optional<Problem> Segment::ApplyBailOut(const Cells& cells) {
  FrameSample frame;
  if (Result problem = RestoreRuns(cells)) return problem;
  if (Result problem = Read(cells, AuditColumn::kFrame, FieldsOf(frame))) return problem;
  session_->ObserveBailOut(frame, now_ns_);
  return std::nullopt;
}

std::optional<Problem> Segment::ApplySwitch(const Cells& cells) {
  uint32_t arm = 0;
  uint32_t epoch = 0;
  SwitchReason reason{};
  SwitchCost cost;
  if (Result problem = RestoreRuns(cells)) return problem;
  if (Result problem = ReadArm(cells, arm)) return problem;
  if (Result problem = Read(cells, AuditColumn::kSwitchEpoch, epoch)) return problem;
  if (!ParseName(CellOf(cells, AuditColumn::kReason), kSwitchReasonNames, reason))
    return Unreadable(cells, AuditColumn::kReason);
  if (Result problem = Read(cells, AuditColumn::kRebuildTimeNs, cost.rebuild_time_ns))
    return problem;
  if (Result problem = Read(cells, AuditColumn::kSettlingCostNs, cost.settling_cost_ns))
    return problem;
  if (!CellOf(cells, AuditColumn::kFrame).empty()) {
    TrialEnd& end = cost.ended_trial.emplace();
    if (Result problem = Read(cells, AuditColumn::kFrame, FieldsOf(end))) return problem;
    if (end.arm >= session_->arms().size()) return Unreadable(cells, AuditColumn::kFrame);
  }
  session_->ObserveSwitch(arm, epoch, reason, now_ns_, cost);
  return std::nullopt;
}

std::optional<Problem> Segment::ApplyRefusal(const Cells& cells) {
  uint64_t command_id = 0;
  if (Result problem = Read(cells, AuditColumn::kCommandId, command_id)) return problem;
  session_->ObserveRefusal(command_id);
  return std::nullopt;
}

std::optional<Problem> Segment::ApplyMode(const Cells& cells) {
  uint32_t arm = 0;
  Mode mode{};
  if (Result problem = RestoreRuns(cells)) return problem;
  if (Result problem = ReadArm(cells, arm)) return problem;
  if (!ParseName(CellOf(cells, AuditColumn::kMode), kModeNames, mode))
    return Unreadable(cells, AuditColumn::kMode);
  session_->SetMode(mode, arm, now_ns_);
  return std::nullopt;
}

std::optional<Problem> Segment::ApplyOrder(const Cells& cells) {
  OrderReport order;
  order.operator_name = CellOf(cells, AuditColumn::kSetup);
  order.now_ns = now_ns_;
  if (!order.operator_name.starts_with(kOperatorKey)) return Unreadable(cells, AuditColumn::kSetup);
  order.operator_name.remove_prefix(kOperatorKey.size());
  if (!CellOf(cells, AuditColumn::kArm).empty()) {
    if (Result problem = ReadArm(cells, order.arm.emplace())) return problem;
  }
  if (!ParseName(CellOf(cells, AuditColumn::kMode), kModeNames, order.mode))
    return Unreadable(cells, AuditColumn::kMode);
  session_->ObserveOrder(order);
  return std::nullopt;
}

std::optional<Problem> Segment::RestoreRuns(const Cells& cells) {
  const auto arm_count = static_cast<uint32_t>(session_->arms().size());
  const auto runs = ParseRuns(CellOf(cells, AuditColumn::kRuns), arm_count);
  if (!runs) return Unreadable(cells, AuditColumn::kRuns);
  if (!session_->RestoreRuns(*runs)) {
    return Problem{AuditColumn::kRuns,
                   "has another active arm or switch epoch than follows from the rows before"};
  }
  return std::nullopt;
}

std::optional<Problem> Segment::ReadTime(const Cells& cells) {
  constexpr int64_t kLatestNs = int64_t{1} << 62;  // 146 years; differences of two do not overflow
  if (Result problem = Read(cells, AuditColumn::kTimeNs, now_ns_)) return problem;
  if (now_ns_ >= -kLatestNs && now_ns_ <= kLatestNs) return std::nullopt;
  return Problem{AuditColumn::kTimeNs, "is out of the range of a clock"};
}

std::optional<Problem> Segment::ReadArm(const Cells& cells, uint32_t& arm) const {
  const auto& arms = session_->arms();
  const auto found = std::find(arms.begin(), arms.end(), CellOf(cells, AuditColumn::kArm));
  if (found == arms.end()) return Problem{AuditColumn::kArm, "is not an arm of the setup"};
  arm = static_cast<uint32_t>(found - arms.begin());
  return std::nullopt;
}

std::optional<Problem> Segment::ReadShadow(const Cells& cells) {
  samples_.clear();
  std::string_view rest = CellOf(cells, AuditColumn::kShadow);
  while (!rest.empty()) {
    ShadowSample sample;
    if (!ParseText(TakeItem(rest, ' '), FieldsOf(sample)))
      return Unreadable(cells, AuditColumn::kShadow);
    samples_.push_back(sample);
  }
  return std::nullopt;
}

std::optional<Problem> Segment::Compare(const Cells& cells) {
  CsvReader(derived_).Next(derived_cells_);
  derived_cells_.resize(kAuditColumnNames.size());
  for (size_t i = 0; i < kAuditColumnNames.size(); ++i) {
    if (cells[i] == derived_cells_[i]) continue;
    const auto column = static_cast<AuditColumn>(i);
    if (column == AuditColumn::kLogHash) return WrongHash();
    return Problem{column, DifferenceText(cells[i], derived_cells_[i])};
  }
  return std::nullopt;
}

// Derives all segments of a log again, and counts rows and decisions.
class Rederivation {
 public:
  Rederivation(std::string_view csv, PolicyRegistry policies) : reader_(csv), policies_(policies) {}

  AuditReport Run() {
    if (CheckHeader()) {
      while (!report_.difference && reader_.Next(cells_)) TakeRow();
      if (!report_.difference && !reader_.problem().empty()) Differ({{}, reader_.problem()});
    }
    return std::move(report_);
  }

 private:
  bool CheckHeader() {
    if (!reader_.Next(cells_)) {
      Differ({{}, reader_.problem().empty() ? "the file is empty" : reader_.problem()});
    } else if (!std::equal(cells_.begin(), cells_.end(), kAuditColumnNames.begin(),
                           kAuditColumnNames.end())) {
      cells_.clear();
      Differ({{}, "the header is not that of an audit log of this version"});
    }
    return !report_.difference;
  }

  void TakeRow() {
    if (cells_.size() != kAuditColumnNames.size()) {
      const size_t count = cells_.size();
      cells_.resize(kAuditColumnNames.size());
      return Differ({{},
                     "has " + std::to_string(count) + " cells instead of " +
                         std::to_string(kAuditColumnNames.size()) + "; is it cut off?"});
    }
    if (const auto problem = EnterSegment()) return Differ(*problem);
    if (IsMissingRow(cells_)) return SkipMissing();
    if (const auto problem = segment_ ? segment_->Take(cells_) : CheckHash())
      return Differ(*problem);
    after_missing_ = false;
    if (IsOfAdmin(cells_)) return;
    ++report_.row_count;
    if (CellOf(cells_, AuditColumn::kDecisionId).empty()) return;
    ++(segment_ ? report_.decision_count : report_.underived_decision_count);
  }

  std::optional<Problem> EnterSegment() {
    auto key =
        std::pair(CellOf(cells_, AuditColumn::kSession), CellOf(cells_, AuditColumn::kSegment));
    if (current_ != nullptr && key == *current_) return CheckNumber();
    if (CellOf(cells_, AuditColumn::kRow) != "1")
      return Problem{AuditColumn::kRow, "begins a segment whose first rows are missing"};
    current_ = &*segments_.insert(std::move(key)).first;
    row_in_segment_ = 1;
    after_missing_ = false;
    if (IsOfAdmin(cells_)) {
      segment_.reset();
      hash_ = math::kFnv1aStart;
      return std::nullopt;
    }
    if (sessions_.insert(current_->first).second) ++report_.session_count;
    segment_ = std::make_unique<Segment>(policies_);
    if (!IsMissingRow(cells_)) ++report_.segment_count;
    return std::nullopt;
  }

  // Checks that rows are numbered consecutively. After a `missing` row, any later number may
  // follow.
  std::optional<Problem> CheckNumber() {
    const uint64_t expected = row_in_segment_ + 1;
    if (const auto problem = Read(cells_, AuditColumn::kRow, row_in_segment_)) return problem;
    if (row_in_segment_ == expected || (after_missing_ && row_in_segment_ > expected))
      return std::nullopt;
    return Problem{AuditColumn::kRow, "comes where row " + std::to_string(expected) +
                                          " should; rows are missing or out of order"};
  }

  void SkipMissing() {
    constexpr auto kFirstEmpty = static_cast<std::ptrdiff_t>(AuditColumn::kTimeNs);
    if (std::any_of(cells_.begin() + kFirstEmpty, cells_.end(),
                    [](const std::string& cell) { return !cell.empty(); }))
      return Differ({{}, "replaces missing rows, but has values in its other cells"});
    if (segment_) ++report_.incomplete_segment_count;
    segment_.reset();
    hash_.reset();
    after_missing_ = true;
  }

  // Checks that the hash of a row that cannot be derived continues the hash of the row before it.
  std::optional<Problem> CheckHash() {
    std::string text;
    for (size_t i = 0; i + 1 < cells_.size(); ++i) {
      AppendCsv(text, cells_[i]);
      text += ',';
    }
    uint64_t logged = 0;
    const std::string& cell = cells_.back();
    const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), logged, 16);
    if (error != std::errc() || end != cell.data() + cell.size())
      return Unreadable(cells_, AuditColumn::kLogHash);
    if (hash_ && math::Fnv1a(*hash_, text) != logged) return WrongHash();
    hash_ = logged;
    return std::nullopt;
  }

  void Differ(Problem problem) {
    AuditDifference difference;
    difference.line = reader_.line();
    difference.message = std::move(problem.message);
    if (cells_.size() == kAuditColumnNames.size()) {
      difference.session = CellOf(cells_, AuditColumn::kSession);
      difference.segment = CellOf(cells_, AuditColumn::kSegment);
      difference.row = CellOf(cells_, AuditColumn::kRow);
    }
    if (problem.column) difference.column = kAuditColumnNames[static_cast<size_t>(*problem.column)];
    report_.difference = std::move(difference);
  }

  using SegmentKeys = std::set<std::pair<std::string, std::string>>;

  CsvReader reader_;
  PolicyRegistry policies_;
  AuditReport report_;
  Cells cells_;
  std::set<std::string> sessions_;
  SegmentKeys segments_;
  const SegmentKeys::value_type* current_ = nullptr;
  std::unique_ptr<Segment> segment_;  // null after missing rows
  uint64_t row_in_segment_ = 0;       // the latest row's number
  bool after_missing_ = false;        // whether the latest row was a `missing` row
  std::optional<uint64_t> hash_;      // hash of the previous row, if that cannot be derived
};

}  // namespace

std::string AuditDifference::Text() const {
  std::string text = "line " + std::to_string(line);
  if (!session.empty()) text += ": session " + session + ", segment " + segment + ", row " + row;
  text += column.empty() ? ": " : ", " + column + " ";
  return text + message;
}

AuditReport Rederive(std::string_view csv, PolicyRegistry policies) {
  return Rederivation(csv, policies).Run();
}

}  // namespace sweepstake::decision
