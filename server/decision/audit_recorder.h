// Makes the rows of one session's audit log (audit_log.h) and hands them to a sink.
//
// Each event is recorded as the session is before it; a decision's row is begun with its inputs and
// ended with what came of them. Not thread-safe; the sink must outlive the recorder. Reuses its
// memory: nothing is allocated once a row of each length has been made.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/decision/arm_runs.h"
#include "server/decision/audit_log.h"
#include "server/decision/audit_names.h"
#include "server/decision/decision_session.h"
#include "server/decision/types.h"

namespace sweepstake::decision {

class AuditRecorder {
 public:
  // Records the setup.
  AuditRecorder(AuditSink& sink, AuditOrigin origin, const SessionSetup& setup);

  void RecordSwitch(uint32_t arm, uint32_t switch_epoch, SwitchReason reason, int64_t now_ns,
                    const SwitchCost& cost, const ArmRuns& runs);
  void RecordRefusal(uint64_t command_id);
  void RecordMode(Mode mode, uint32_t active_arm, int64_t now_ns, const ArmRuns& runs);

  // Then EndDecision. The samples and the descriptor are those that are learnt.
  void BeginTick(int64_t now_ns, const ArmRuns& runs, std::span<const ShadowSample> samples,
                 const std::optional<SceneDescriptor>& descriptor);
  void BeginBailOut(const Frame& frame, int64_t now_ns, const ArmRuns& runs);
  void EndDecision(const Decision& decision);

 private:
  void Begin(AuditKind kind, std::optional<int64_t> now_ns);
  void End();
  // The row up to this column, to append its cell to.
  std::string& Cell(AuditColumn column);
  template <typename T>
  void Put(AuditColumn column, const T& value);
  void PutText(AuditColumn column, std::string_view text);
  void PutArm(AuditColumn column, uint32_t arm) { PutText(column, arms_[arm]); }
  void PutRuns(const ArmRuns& runs);
  template <typename Item, typename ValueOf>
  void PutList(AuditColumn column, std::span<const Item> items, ValueOf value_of);
  void PutCommand(const SwitchCommand& command);
  void PutVersions();
  void PutRecord(const DecisionRecord& record);
  void PutIncrement(const Increment& increment);
  void PutDiagnosis(const Diagnosis& diagnosis);
  void PutGate(const GateTerms& gate);

  AuditSink& sink_;
  const AuditOrigin origin_;
  const std::vector<std::string> arms_;
  const std::string policy_;
  const uint32_t reward_version_;
  const uint64_t seed_;

  uint64_t row_count_ = 0;
  uint64_t hash_;
  std::string row_;
  std::string text_;   // of a cell that may need quotes
  size_t column_ = 0;  // of the row's end
};

}  // namespace sweepstake::decision
