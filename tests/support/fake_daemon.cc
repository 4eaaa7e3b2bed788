#include "tests/support/fake_daemon.h"

#include <algorithm>
#include <chrono>
#include <set>

namespace sweepstake::test_support {

FakeDaemon::FakeDaemon() = default;
FakeDaemon::~FakeDaemon() { Kill(); }

void FakeDaemon::Start(int port) {
  {
    const std::lock_guard lock(mutex_);
    killed_ = false;
  }
  grpc::ServerBuilder builder;
  builder.AddListeningPort("127.0.0.1:" + std::to_string(port), grpc::InsecureServerCredentials(),
                           &port_);
  builder.RegisterService(this);
  server_ = builder.BuildAndStart();
}

void FakeDaemon::Kill() {
  if (!server_) return;
  {
    const std::lock_guard lock(mutex_);
    killed_ = true;
    for (grpc::ServerContext* context : contexts_) context->TryCancel();
    changed_.notify_all();
  }
  server_->Shutdown(std::chrono::system_clock::now());
  server_->Wait();
  server_.reset();
}

void FakeDaemon::SetScript(const std::function<void(Script&)>& change) {
  const std::lock_guard lock(mutex_);
  change(script_);
  changed_.notify_all();
}

void FakeDaemon::ForgetSessions() {
  const std::lock_guard lock(mutex_);
  session_id_.clear();
  acknowledged_sequence_ = 0;
}

bool FakeDaemon::Send(const v1::StreamTelemetryResponse& response) {
  const std::lock_guard lock(mutex_);
  return open_stream_ != nullptr && open_stream_->Write(response);
}

void FakeDaemon::WaitUntil(const std::function<bool(const FakeDaemon&)>& condition) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return condition(*this); });
}

std::vector<v1::StreamTelemetryRequest> FakeDaemon::Evidence() {
  const std::lock_guard lock(mutex_);
  std::set<uint64_t> seen;
  std::vector<v1::StreamTelemetryRequest> once;
  for (const auto& request : evidence) {
    if (seen.insert(request.sequence()).second) once.push_back(request);
  }
  return once;
}

grpc::Status FakeDaemon::StreamTelemetry(grpc::ServerContext* context, Stream* stream) {
  {
    const std::lock_guard lock(mutex_);
    contexts_.push_back(context);
    ++open_stream_count;
    if (killed_) context->TryCancel();
  }
  grpc::Status status = Converse(stream);
  const std::lock_guard lock(mutex_);
  if (open_stream_ == stream) open_stream_ = nullptr;
  std::erase(contexts_, context);
  --open_stream_count;
  changed_.notify_all();
  return status;
}

grpc::Status FakeDaemon::Converse(Stream* stream) {
  v1::StreamTelemetryRequest request;
  if (!stream->Read(&request)) return {};
  if (!request.has_hello()) return {grpc::StatusCode::FAILED_PRECONDITION, "no hello"};
  if (grpc::Status status = Greet(request.hello(), stream); !status.ok()) return status;
  while (stream->Read(&request)) {
    if (auto status = Receive(request, stream)) return *status;
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !script_.never_reads || killed_; });
  }
  return {};
}

grpc::Status FakeDaemon::Greet(const v1::Hello& hello, Stream* stream) {
  std::unique_lock lock(mutex_);
  hellos.push_back(hello);
  changed_.notify_all();
  changed_.wait(lock, [this] { return script_.answers_hello || killed_; });
  if (script_.refusal) return *script_.refusal;
  v1::StreamTelemetryResponse response;
  v1::Welcome& welcome = *response.mutable_welcome();
  welcome = script_.welcome;
  if (hello.session_id().empty()) {
    session_id_ = "session-" + std::to_string(++session_count_);
    acknowledged_sequence_ = 0;
  } else if (hello.session_id() != session_id_) {
    return {grpc::StatusCode::NOT_FOUND, "unknown session"};
  } else {
    welcome.set_resumed(true);
  }
  welcome.set_session_id(session_id_);
  welcome.set_acknowledged_sequence(acknowledged_sequence_);
  open_stream_ = stream;
  stream->Write(response);
  changed_.wait(lock, [this] { return !script_.never_reads || killed_; });
  return {};
}

std::optional<grpc::Status> FakeDaemon::Receive(const v1::StreamTelemetryRequest& request,
                                                Stream* stream) {
  const std::lock_guard lock(mutex_);
  if (request.has_goodbye()) {
    goodbyes.push_back(request.goodbye());
    changed_.notify_all();
    return script_.farewell;
  }
  evidence.push_back(request);
  if (script_.acknowledges) {
    acknowledged_sequence_ = std::max(acknowledged_sequence_, request.sequence());
    v1::StreamTelemetryResponse response;
    response.mutable_acknowledgement()->set_sequence(acknowledged_sequence_);
    stream->Write(response);
  }
  changed_.notify_all();
  return script_.refusal_of_evidence;
}

}  // namespace sweepstake::test_support
