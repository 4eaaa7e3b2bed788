// An attacker who has a session's id, and perhaps its resume token too, and tries to resume the
// session.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "tests/server/simulation/connection.h"

namespace sweepstake::simulation {

class Thief final : public ConnectionUser {
 public:
  using Network = std::function<std::shared_ptr<Connection>(ConnectionUser&)>;

  // `stolen` names the session. Without its resume token the thief gets a new session. With it the
  // thief is refused, because its access token is not the session's.
  Thief(const v1::Hello& stolen, const Network& network,
        std::function<void(const std::string&)> complain)
      : session_id_(stolen.session_id()),
        knows_secret_(!stolen.resume_token().empty()),
        complain_(std::move(complain)),
        connection_(network(*this)) {
    v1::StreamTelemetryRequest request;
    *request.mutable_hello() = stolen;
    connection_->Send(request);
  }
  ~Thief() override {
    if (connection_) connection_->Leave();
  }
  Thief(const Thief&) = delete;
  Thief& operator=(const Thief&) = delete;

  void OnResponse(const v1::StreamTelemetryResponse& response) override {
    if (!response.has_welcome()) return;
    const v1::Welcome& welcome = response.welcome();
    if (knows_secret_) complain_("a session of another token was resumed or restarted");
    if (welcome.resumed() || welcome.session_id() == session_id_)
      complain_("a session was resumed without its token");
    connection_->Break();
  }
  void OnClosed(const absl::Status& /*status*/) override { connection_.reset(); }

 private:
  const std::string session_id_;
  const bool knows_secret_;
  const std::function<void(const std::string&)> complain_;
  std::shared_ptr<Connection> connection_;  // null if not connected
};

}  // namespace sweepstake::simulation
