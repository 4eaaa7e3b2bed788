// The implementation of AdaptiveBroadPhase. sweepstake/adaptive_broad_phase.h documents the public
// functions. Internal to this repository.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine_client/adaptive/adaptive_factory.h"
#include "engine_client/adaptive/descriptor_estimator.h"
#include "engine_client/adaptive/guards/bail_out_guard.h"
#include "engine_client/adaptive/guards/suspension_guard.h"
#include "engine_client/adaptive/guards/trial_guard.h"
#include "engine_client/adaptive/guards/trial_stop.h"
#include "engine_client/adaptive/invalid_box_counter.h"
#include "engine_client/adaptive/order_mailbox.h"
#include "engine_client/adaptive/sequence_slot.h"
#include "engine_client/adaptive/session_attachment.h"
#include "engine_client/adaptive/shadow_lane.h"
#include "engine_client/adaptive/switch_cost_meter.h"
#include "engine_client/adaptive/verdict_slot.h"
#include "engine_client/adaptive/view_tap.h"
#include "engine_client/broad_phase/host/thread_owned.h"
#include "sweepstake/adaptive_broad_phase.h"
#include "sweepstake/pair_sorter.h"
#include "sweepstake/proxy_set.h"

namespace sweepstake {

std::optional<uint32_t> IndexOfArm(std::string_view name, std::span<const std::string> arms);
// Returns kNotFound with a message that lists the arms.
Status UnknownArm(std::string_view name, std::span<const std::string> arms);

class AdaptiveBroadPhase::Impl {
 public:
  Impl(const AdaptiveOptions& options, std::vector<std::string> arms,
       std::vector<ArmBackend> backends, uint32_t first_arm, const LaneParts& lane, FrameSink* sink,
       Clock& clock);

  // Starts the shadow lane's thread if the options enable a lane. Called once, before the first
  // frame. Returns kResourceExhausted if the system cannot create a thread.
  Status StartLane();
  void BeginFrame();
  std::span<const OverlapPair> FindPairs(std::span<const Aabb> boxes);
  std::span<const OverlapPair> FindPairs(ProxySet& proxies);
  bool pairs_exceeded() const { return pairs_exceeded_; }
  uint64_t max_pairs() const { return max_pairs_; }
  void EndFrame(const FrameEnd& frame);
  void Trim();
  uint64_t memory_bytes() const;

  Status SelectArm(std::string_view name);
  void SetMode(Mode chosen);
  void Freeze();
  void SetLaneUse(bool used);
  bool frozen() const { return frozen_.load(std::memory_order_relaxed); }

  uint32_t arm() const {
    return static_cast<uint32_t>(active_.load(std::memory_order_relaxed) >> 32);
  }
  uint32_t epoch() const { return static_cast<uint32_t>(active_.load(std::memory_order_relaxed)); }
  ShadowStats shadow_stats() const;

  const std::vector<std::string> arms;
  const uint32_t initial_arm;
  std::vector<uint32_t> versions;
  SwitchMailbox mailbox;
  OrderMailbox orders;
  std::atomic<Mode> mode;
  BailOutGuard guard;
  VerdictSlot verdict;
  ViewTap view_tap;
  LatestSlot<LastDecision> last_decision;
  LatestSlot<SwitchOutcome> last_outcome;
  SwitchCostMeter switch_cost;
  std::shared_ptr<SessionAttachment> attachment;  // null: no session was started
  FrameSample last_sample{};
  SwitchReason last_switch_reason = SwitchReason::kPolicy;

 private:
  // A command from the mailbox, and the frame time that it has waited for the shadow lane.
  struct PendingSwitch {
    SwitchCommand command;
    uint64_t waited_ns = 0;
  };

  void ExecuteOne(const std::optional<SwitchCommand>& commanded,
                  const std::optional<OperatorOrder>& order);
  void TakeCommand(const SwitchCommand& command);
  void TakeOrder(const OperatorOrder& order);
  void ChangeMode(Mode chosen);
  void ExecutePending();
  bool IsAllowed(const SwitchCommand& command) const;
  bool WaitsForLane();
  void Execute(const SwitchCommand& command);
  void KeepBudget();
  void KeepBudgetOfGrowing();
  void FreeInactiveArms();
  void Drop();
  void Refuse(const SwitchCommand& command);
  bool Detect(std::span<const Aabb> boxes, uint64_t start_ns);
  void LeaveTrial(std::span<const Aabb> boxes);
  uint64_t ComputedNs() const;
  void UpdateStructure(std::span<const Aabb> boxes, uint64_t start_ns);
  void Search();
  void Rebuild(std::span<const Aabb> boxes, uint64_t start_ns);
  uint64_t MeasureDetection(std::span<const Aabb> boxes, uint64_t start_ns);
  void ShowFrame(std::span<const Aabb> boxes);
  void Emit();
  void DropLocalCommand();
  void EndTrial();
  void CancelTrial();
  void ReportTrialEnd();
  void GuardLocally();
  void Report(const std::optional<SwitchOutcome>& outcome);
  void ReportMode(uint64_t order_id);
  uint64_t NowNs() { return frozen() ? 0 : clock_.NowNs(); }

  std::vector<ArmBackend> backends_;
  const ArmBackendFactory make_;  // null: the memory of inactive arms is never freed
  const uint64_t max_pairs_;
  const uint64_t memory_budget_bytes_;
  uint64_t budgeted_bytes_ = 0;  // the active arm's bytes when the budget was last checked
  FrameSink* const sink_;
  const std::shared_ptr<FrameSink> shared_sink_;  // keeps sink_ alive; null: sink_ is borrowed
  Clock& clock_;
  SuspensionGuard suspension_;
  std::atomic<uint64_t> active_;
  std::optional<SwitchCommand> local_command_;  // a command of SelectArm or of a guard
  TrialGuard trial_;
  TrialStop trial_stop_;
  uint64_t waited_ns_ = 0;   // time that this frame's searches of a trial waited for the core
  bool left_trial_ = false;  // a search of this frame was stopped
  std::optional<TrialGuard::End> trial_end_;  // measurements that ended the trial; else absent
  bool keeps_structure_ = false;              // in a trial, the previous arm's structure is kept
  std::optional<PendingSwitch> pending_;
  std::atomic<bool> frozen_ = false;       // written by the frame thread
  std::atomic<bool> lane_is_used_ = true;  // the decider learns from the lane
  bool manual_by_order_ = false;           // kManual is in force because an operator ordered it
  bool searched_ = false;                  // the current frame has searched
  bool built_ = false;                     // the active structure holds the latest frame's boxes
  bool pairs_exceeded_ = false;            // by the latest search
  PairBuffer pairs_;
  std::optional<PairSorter> sorter_;  // absent: pairs stay in the backend's order
  DescriptorEstimator descriptors_;
  InvalidBoxCounter invalid_boxes_;
  FrameSample sample_{};
  std::atomic<uint64_t> warm_switch_count_{0};
  std::atomic<uint64_t> cold_switch_count_{0};
  const ShadowState lane_state_;  // kRunning if there is a lane, otherwise why there is none
  // The last member: the lane's thread uses the members above.
  ThreadOwned<ShadowLane> lane_;
};

}  // namespace sweepstake
