#include "tests/engine_client/decider/audit/audited_game.h"

#include <utility>

#include "tests/engine_client/decider/scripted_client.h"
#include "tests/laboratory/policies/study_policies.h"

namespace sweepstake::decision {

SessionSetup AuditedSetup(uint64_t seed, std::string_view policy) {
  SessionSetup setup;
  setup.arms = {"BruteForce", "Grid, uniform", "\"SAP\"", "Axis\nSweep",
                "DBVT;\\",    "Träcy",         "KD:Tree"};
  setup.seed = seed;
  setup.options.policy = policy;
  setup.start_ns = 123'456'789'000;
  return setup;
}

AuditedGame::AuditedGame(const SessionSetup& setup, AuditFile* file, uint32_t segment)
    : random_(setup.seed, RandomPurpose::kChoice, 0, 0),
      session_(setup, StudyPolicies()),
      arm_count_(static_cast<uint32_t>(setup.arms.size())),
      now_ns_(setup.start_ns),
      arm_(setup.active_arm),
      epoch_(setup.switch_epoch) {
  if (file == nullptr) return;
  AuditOrigin origin;
  origin.session_id = "session of " + std::to_string(setup.seed);
  origin.segment = segment;
  origin.project = "a; project = \\ of, sorts";
  origin.scene = "scène \"1\"";
  origin.machine_class = "x86-64";
  origin.program_version = "1.2.3";
  origin.backend_versions = {1, 2, 3, 4, 5, 6, 7};
  origin.unix_start_ms = 1'800'000'000'000;
  StartAudit(session_, *file, std::move(origin));
}

void AuditedGame::Run(int steps) {
  for (int i = 0; i < steps; ++i) Step();
}

FrameSample AuditedGame::NextFrame() {
  FrameSample frame{.frame_time_ns = 8'000'000 + random_.NextBelow(9'000'000),
                    .detection_time_ns = 20'000 + arm_ * 7'000 + random_.NextBelow(9'000),
                    .aabb_check_count = 40'000 + random_.NextBelow(9'000),
                    .native_bytes = (uint64_t{arm_} + 1) << 20,
                    .object_count = 1'000};
  frame.arm = arm_;
  frame.switch_epoch = OneIn(200) ? epoch_ + random_.NextBelow(4) - 2 : epoch_;
  if (OneIn(50)) frame.flags = random_.NextBelow(8);
  if (OneIn(400)) frame.detection_time_ns = frame.frame_time_ns = 6'000'000'000;
  return frame;
}

void AuditedGame::Step() {
  Observe(1 + random_.NextBelow(30));
  if (OneIn(2)) Answer();
  if (OneIn(60)) {
    FrameSample frame = NextFrame();
    frame.frame_time_ns = 5'500'000'000;
    frame.detection_time_ns = OneIn(3) ? 1'000'000 : 5'400'000'000;
    Take(session_.ObserveBailOut(frame, now_ns_));
  }
  if (OneIn(100)) {
    if (OneIn(2)) arm_ = AnyArm();
    session_.ObserveOrder({.operator_name = "José; \"the\", op=erator",
                           .mode = arm_ % 2 == 0 ? Mode::kManual : Mode::kAi,
                           .arm = arm_ == 0 ? std::nullopt : std::optional(arm_),
                           .now_ns = now_ns_});
    session_.SetMode(session_.mode() == Mode::kAi && OneIn(4) ? Mode::kManual : Mode::kAi, arm_,
                     now_ns_);
  }
  SeeScene();
  if (now_ns_ >= session_.next_tick_ns()) Take(session_.Tick(now_ns_));
}

void AuditedGame::Observe(uint32_t frame_count) {
  for (uint32_t i = 0; i < frame_count; ++i) {
    const FrameSample frame = NextFrame();
    now_ns_ += static_cast<int64_t>(frame.frame_time_ns % 20'000'000);
    session_.ObserveFrames({&frame, 1});
  }
}

// Some switches are reported shortly after the first frame of the new epoch, others long after it.
void AuditedGame::Answer() {
  SwitchCost cost{.rebuild_time_ns = random_.NextBelow(100'000),
                  .settling_cost_ns = random_.NextBelow(1'000'000)};
  if (OneIn(3)) cost.ended_trial = {.arm = AnyArm(), .detection_time_ns = 50'000'000};
  if (!reported_) {
    session_.ObserveSwitch(arm_, epoch_, SwitchReason::kPolicy, now_ns_, cost);
    reported_ = true;
  } else if (command_ && OneIn(5)) {
    session_.ObserveRefusal(command_->command_id);
    command_.reset();
  } else if (command_ || OneIn(80)) {
    arm_ = command_ ? command_->arm : AnyArm();
    ++epoch_;
    reported_ = false;
    command_.reset();
  }
}

void AuditedGame::SeeScene() {
  if (OneIn(8)) {
    SceneDescriptor scene;
    scene.object_count = 1'000;
    scene.density_ratio = OneIn(2) ? 0.25F : 1.0F / 3;
    scene.static_ratio = static_cast<float>(random_.NextUniform());
    session_.ObserveDescriptor(scene);
  }
  if (!OneIn(4)) return;
  for (uint32_t arm = 0; arm < arm_count_; ++arm) {
    const ShadowSample sample{.first_frame_index = static_cast<uint64_t>(now_ns_),
                              .detection_time_ns = 20'000 + arm * 7'000 + random_.NextBelow(3'000),
                              .build_time_ns = 90'000,
                              .aabb_check_count = 40'000,
                              .native_bytes = 1 << 20,
                              .arm = arm,
                              .object_count = 1'000,
                              .frame_count = 5,
                              .flags = arm == arm_ ? kShadowActive : 0u};
    session_.ObserveShadow({&sample, 1});
  }
}

void AuditedGame::Take(Decision decision) {
  if (decision.command) command_ = decision.command;
  decisions_.push_back(std::move(decision));
}

}  // namespace sweepstake::decision
