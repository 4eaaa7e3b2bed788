// A watcher of the scenes of one project, which keeps the latest state of each. It encodes the
// events itself, so that the figures of scenes are not computed.
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/events/event_bus.h"
#include "server/rpc/common/access_control.h"

namespace sweepstake::simulation {

class SimulatedWatcher final : public events::Sink, public events::Encoder {
 public:
  // `complain` is called for each violation.
  SimulatedWatcher(auth::Principal caller, std::function<void(const std::string&)> complain)
      : caller_(std::move(caller)), complain_(std::move(complain)) {
    if (!rpc::Narrow(caller_, filter_).ok()) complain_("a watcher may not watch");
  }

  const priors::SceneFilter& filter() const { return filter_; }
  // The latest evidence of each scene since the last Forget.
  const std::map<priors::SceneKey, priors::SceneEvidence>& latest() const { return latest_; }
  void Forget() { latest_.clear(); }
  void Watch(events::EventBus& bus) { bus.Subscribe({.filter = filter_}, *this); }
  void Leave() { subscriber_.reset(); }
  bool watching() const { return subscriber_ != nullptr; }

  void Begin(std::unique_ptr<events::Subscriber> subscriber) override {
    subscriber_ = std::move(subscriber);
  }
  void Wake() override {
    for (;;) {
      const auto events = subscriber_->Take(1);
      if (events.empty()) return;
      if (events.front()->body->empty()) continue;
      const priors::SceneEvidence& scene = encoded_.at(std::stoul(*events.front()->body));
      Check(scene.key.project);
      latest_.insert_or_assign(scene.key, scene);
    }
  }
  void OnEnd(const absl::Status& /*status*/) override { Leave(); }

  std::string Scene(const priors::SceneEvidence& scene) const override {
    encoded_.push_back(scene);
    return absl::StrCat(encoded_.size() - 1);
  }
  std::string Activity(const sessions::SceneActivity& /*activity*/) const override { return ""; }
  std::string Decision(const sessions::SessionDecision& decision) const override {
    Check(decision.session.scene.project);
    return "";
  }
  std::string Session(const sessions::SessionView& /*session*/) const override { return ""; }
  std::string SessionEnd(const std::string& /*session_id*/,
                         sessions::SessionEnd /*end*/) const override {
    return "";
  }
  std::string Boxes(const std::string& /*view*/) const override { return ""; }
  std::string Stamp(events::Kind /*kind*/, const events::EventStamp& /*stamp*/) const override {
    return "";
  }

 private:
  void Check(const std::string& project) const {
    if (!caller_.MayUse(project)) complain_("a watcher received another project");
  }

  const auth::Principal caller_;
  const std::function<void(const std::string&)> complain_;
  priors::SceneFilter filter_;
  std::unique_ptr<events::Subscriber> subscriber_;
  mutable std::deque<priors::SceneEvidence> encoded_;
  std::map<priors::SceneKey, priors::SceneEvidence> latest_;
};

}  // namespace sweepstake::simulation
