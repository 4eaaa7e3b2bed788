#include "tests/laboratory/load/load_run.h"

#include <grpcpp/grpcpp.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <deque>
#include <fstream>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <sstream>
#include <string>
#include <thread>
#include <utility>

#include "engine_client/cli/daemon/daemon_client.h"
#include "engine_client/cli/io/statistics.h"
#include "engine_client/cli/io/text_table.h"
#include "engine_client/decider/client_reports.h"
#include "engine_client/telemetry/daemon_channel.h"
#include "sweepstake/v1/telemetry.grpc.pb.h"

namespace sweepstake::cli {
namespace {

constexpr int64_t kSecondNs = 1'000'000'000;
constexpr int64_t kPatienceNs = 10 * kSecondNs;
constexpr double kMaxHellosPerSecond = 2000;
constexpr double kLongestSpreadS = 10;

// Returns the CPU time of a process on this machine in seconds, from /proc/PID/stat (proc(5),
// fields 14 and 15). Returns nothing if the process does not exist.
std::optional<double> CpuSeconds(int64_t pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/stat");
  std::string line;
  if (pid == 0 || !std::getline(file, line)) return std::nullopt;
  // The second field, the program's name in parentheses, may contain spaces.
  std::istringstream fields(line.substr(line.rfind(')') + 1));
  std::string skipped;
  for (int i = 0; i < 11; ++i) fields >> skipped;
  double user = 0;
  double system = 0;
  if (!(fields >> user >> system)) return std::nullopt;
  return (user + system) / static_cast<double>(sysconf(_SC_CLK_TCK));
}

// Returns whether the daemon refused the call only because it had refused many tokens before. The
// actual reason is then in an earlier refusal.
bool IsFollowUp(const grpc::Status& status) {
  return ReasonOf(status) == v1::ERROR_REASON_TOO_MANY_FAILURES;
}

v1::FrameBatch MakeBatch(uint32_t frame_count) {
  v1::FrameBatch batch;
  for (uint32_t i = 0; i < frame_count; ++i) {
    batch.add_frame_time_ns(10'000'000 + 10'000 * (i % 7));
    batch.add_detection_time_ns(3'000'000 + 10'000 * (i % 11));
    batch.add_aabb_check_count(20'000);
    batch.add_native_bytes(1 << 20);
    batch.add_object_count(3'000);
    batch.add_arm(0);
    batch.add_switch_epoch(0);
    batch.add_flags(0);
  }
  return batch;
}

int64_t NowNs() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

inline constexpr uint32_t kLoadArms = 7;

class LoadRun;

// One client of the run: a session with made-up frames. It uses gRPC's callback API, so that
// thousands of clients do not need a thread each. The timer thread of LoadRun sends, and gRPC's
// threads receive. Messages that the daemon has not acknowledged are not kept for resending,
// because lost evidence does not affect the measured figures. After a lost connection the client
// resumes its session.
class LoadStream {
 public:
  // Maximum number of messages that wait for the connection; further batches are not sent.
  static constexpr size_t kMaxWaiting = 16;

  LoadStream(const std::shared_ptr<grpc::Channel>& channel, std::string project, std::string scene,
             LoadRun& run);

  // Opens a connection. REQUIRES: the client has no connection.
  void Connect();
  // Sends `frames` with the arm, epoch and indices of this stream, followed by a bail-out if
  // `with_bail_out`. Returns false without sending if the daemon's welcome has not arrived or
  // kMaxWaiting messages wait.
  bool SendBatch(const v1::FrameBatch& frames, bool with_bail_out);
  // Measures messages sent from now until EndMeasuring: their latency and acknowledgement.
  void BeginMeasuring();
  void EndMeasuring();
  // Returns whether measured messages have no acknowledgement yet and the connection can still
  // deliver it.
  bool AwaitsAcknowledgement();
  // Ends the session with a goodbye. The connection ends when the daemon has written everything to
  // disk.
  void SayGoodbye();
  // Ends the connection at once, without a goodbye.
  void Cancel();

 private:
  class Call;

  v1::StreamTelemetryRequest HelloRequest() const;
  // REQUIRES, for all functions from Send to IsMeasured: the caller holds mutex_.
  void Send(v1::StreamTelemetryRequest request);
  void WriteNext();
  void OnResponse(const v1::StreamTelemetryResponse& response);
  void OnWelcome(const v1::Welcome& welcome);
  void OnAcknowledgement(uint64_t sequence);
  void OnSwitch(const v1::SwitchCommand& command);
  void SendBailOut();
  uint64_t NextSequence();
  bool IsMeasured(uint64_t sequence) const;

  const std::unique_ptr<v1::TelemetryService::Stub> stub_;
  const std::string project_;
  const std::string scene_;
  LoadRun& run_;

  std::mutex mutex_;  // guards all members below
  Call* call_ = nullptr;
  std::deque<v1::StreamTelemetryRequest> waiting_;  // the front message is being written
  std::string session_id_;
  std::string resume_token_;
  uint64_t acknowledged_sequence_ = 0;
  uint64_t sequence_ = 0;
  uint64_t frame_index_ = 0;
  uint64_t bail_out_ns_ = 0;  // the daemon's limit for the time of a frame
  uint32_t arm_ = 0;
  uint32_t switch_epoch_ = 0;
  uint32_t reconnect_delay_ms_ = 0;
  bool measuring_ = false;
  uint64_t first_measured_ = 1;   // first measured sequence number
  uint64_t last_measured_ = 0;    // last measured sequence number; 0: none
  int64_t begun_ns_ = 0;          // start of the connection
  int64_t bail_out_sent_ns_ = 0;  // when the unanswered bail-out was sent; 0: none
  uint64_t timed_sequence_ = 0;   // sequence number of the batch whose commit is timed
  int64_t timed_sent_ns_ = 0;     // when that batch was sent; 0: no batch is timed
  bool up_ = false;               // the daemon's welcome was received
  bool leaving_ = false;          // the goodbye was sent; no message may follow
};

// The streams of a run and their timer. Run is called on the owner's thread. mutex_ guards the
// state that gRPC's threads change.
class LoadRun {
 public:
  LoadRun(const LoadPlan& plan, const std::function<bool()>& stop,
          const std::function<void(const std::string&)>& progress)
      : plan_(plan), stop_(stop), progress_(progress), batch_(MakeBatch(plan.batch_frames)) {}
  ~LoadRun();

  Result<LoadResult> Run();

  // The streams call OnWelcome to OnSwitch on any thread. `latency_ns` is the time since the start
  // of the connection.
  void OnWelcome(int64_t latency_ns);
  // The daemon has written `message_count` more of the measured messages to disk. `lag_ns` is the
  // time since one of their batches was sent. It is absent if none of them was timed; at most one
  // batch in flight is timed.
  void OnAcknowledged(uint64_t message_count, std::optional<int64_t> lag_ns);
  // The connection has ended. `delay_ms` is the daemon's minimum time before the next connection.
  // `was_up` is true if the stream had received its welcome.
  void OnEnd(LoadStream& stream, const grpc::Status& status, bool was_up, uint32_t delay_ms);
  // A switch command was received and its outcome sent. `latency_ns` is the time since the bail-out
  // that it answers, if any.
  void OnSwitch(std::optional<int64_t> latency_ns);

 private:
  struct Timer {
    size_t stream = 0;
    uint64_t batch = 0;  // the batch's number in the stream; 0 starts the stream
  };

  Status OpenStreams();
  void ScheduleStarts();
  // Runs timers until `done` returns true or the time is over. Returns whether it became true.
  template <typename Done>
  bool RunUntil(int64_t end_ns, Done done);
  void RunDue(int64_t now_ns);
  void Fire(const Timer& timer, int64_t due_ns);
  void Reconnect(int64_t now_ns);
  void ShowProgress(int64_t now_ns);
  void Measure();
  // Waits for the acknowledgements of the messages that were sent while measuring.
  void AwaitAcknowledgements(int64_t end_ns);
  Status Shortfall();
  void SayGoodbye();
  // Returns whether every stream either has its welcome or was kicked, that is, ended by an
  // operator of the daemon. A kicked stream does not reconnect. REQUIRES: mutex_ is held.
  bool AllThere() const { return up_count_ + kicked_count_ == plan_.stream_count; }
  // Returns whether AllThere() is true, or every stream has failed and no welcome has ever arrived.
  bool AllUpOrRefused();
  // Waits until no connection is open, even if the run was stopped.
  void AwaitEnd(int64_t end_ns);

  const LoadPlan& plan_;
  const std::function<bool()>& stop_;
  const std::function<void(const std::string&)>& progress_;
  const v1::FrameBatch batch_;
  std::vector<std::unique_ptr<LoadStream>> streams_;
  std::multimap<int64_t, Timer> timers_;
  std::minstd_rand random_{1};  // jitter of reconnections
  int64_t progress_due_ns_ = 0;
  std::atomic<bool> measuring_{false};
  // False after the wait for acknowledgements; later acknowledgements do not count.
  std::atomic<bool> counting_{true};

  std::atomic<uint64_t> open_count_{0};  // open connections

  std::mutex mutex_;  // guards all members below
  LoadResult result_;
  std::vector<std::pair<int64_t, LoadStream*>>
      lost_;                   // lost streams, with the time of the next attempt
  uint64_t up_count_ = 0;      // streams with a welcome
  uint64_t kicked_count_ = 0;  // streams that an operator of the daemon has ended
  int64_t lost_since_ns_ = 0;  // since when not all streams are connected; 0: all are
  bool ending_ = false;
  grpc::Status last_error_;
};

// One connection. It deletes itself when gRPC has finished the call. A gRPC hold keeps the call
// open until the last read has ended, so that the timer thread may write until then.
class LoadStream::Call final
    : public grpc::ClientBidiReactor<v1::StreamTelemetryRequest, v1::StreamTelemetryResponse> {
 public:
  explicit Call(LoadStream& stream) : stream_(stream) {
    stream.stub_->async()->StreamTelemetry(&context_, this);
    AddHold();
  }

  void OnReadDone(bool ok) override {
    const std::lock_guard lock(stream_.mutex_);
    if (!ok) {
      stream_.call_ = nullptr;
      return RemoveHold();
    }
    stream_.OnResponse(response_);
    StartRead(&response_);
  }
  void OnWriteDone(bool ok) override {
    const std::lock_guard lock(stream_.mutex_);
    if (!ok || stream_.call_ != this) return;
    stream_.waiting_.pop_front();
    stream_.WriteNext();
  }
  void OnDone(const grpc::Status& status) override {
    LoadStream& stream = stream_;
    delete this;
    bool was_up = false;
    uint32_t delay_ms = 0;
    {
      const std::lock_guard lock(stream.mutex_);
      was_up = std::exchange(stream.up_, false);
      delay_ms = std::exchange(stream.reconnect_delay_ms_, 0);
      stream.waiting_.clear();
      stream.bail_out_sent_ns_ = 0;
      stream.timed_sent_ns_ = 0;
    }
    stream.run_.OnEnd(stream, status, was_up, delay_ms);
  }

  grpc::ClientContext context_;
  v1::StreamTelemetryResponse response_;  // the latest response

 private:
  LoadStream& stream_;
};

LoadStream::LoadStream(const std::shared_ptr<grpc::Channel>& channel, std::string project,
                       std::string scene, LoadRun& run)
    : stub_(v1::TelemetryService::NewStub(channel)),
      project_(std::move(project)),
      scene_(std::move(scene)),
      run_(run) {}

void LoadStream::Connect() {
  const std::lock_guard lock(mutex_);
  begun_ns_ = NowNs();
  call_ = new Call(*this);
  call_->StartRead(&call_->response_);
  Send(HelloRequest());
  call_->StartCall();
}

v1::StreamTelemetryRequest LoadStream::HelloRequest() const {
  v1::StreamTelemetryRequest request;
  v1::Hello& hello = *request.mutable_hello();
  hello.set_protocol_version(protocol::kVersion);
  hello.set_project(project_);
  hello.set_scene(scene_);
  for (uint32_t arm = 0; arm < kLoadArms; ++arm) {
    v1::Arm& added = *hello.add_arms();
    added.set_name("arm " + std::to_string(arm));
    added.set_backend_version(1);
  }
  hello.set_active_arm(arm_);
  hello.set_switch_epoch(switch_epoch_);
  hello.set_mode(v1::MODE_AI);
  hello.set_session_id(session_id_);
  hello.set_resume_token(resume_token_);
  return request;
}

bool LoadStream::SendBatch(const v1::FrameBatch& frames, bool with_bail_out) {
  const std::lock_guard lock(mutex_);
  if (call_ == nullptr || !up_ || waiting_.size() >= kMaxWaiting) return false;
  v1::StreamTelemetryRequest request;
  request.set_sequence(NextSequence());
  v1::FrameBatch& batch = *request.mutable_frame_batch();
  batch = frames;
  for (int i = 0; i < batch.arm_size(); ++i) {
    batch.set_arm(i, arm_);
    batch.set_switch_epoch(i, switch_epoch_);
  }
  frame_index_ += static_cast<uint64_t>(batch.arm_size());
  if (timed_sent_ns_ == 0) {
    timed_sequence_ = sequence_;
    timed_sent_ns_ = NowNs();
  }
  Send(std::move(request));
  if (with_bail_out) SendBailOut();
  return true;
}

void LoadStream::SendBailOut() {
  v1::StreamTelemetryRequest request;
  request.set_sequence(NextSequence());
  v1::BailOut& bail_out = *request.mutable_bail_out();
  bail_out.set_frame_index(frame_index_++);
  bail_out.set_arm(arm_);
  bail_out.set_switch_epoch(switch_epoch_);
  bail_out.set_frame_time_ns(2 * bail_out_ns_);
  bail_out.set_detection_time_ns(2 * bail_out_ns_);
  bail_out.set_flags(v1::FRAME_FLAG_BAIL_OUT);
  bail_out_sent_ns_ = NowNs();
  Send(std::move(request));
}

uint64_t LoadStream::NextSequence() {
  ++sequence_;
  if (measuring_) last_measured_ = sequence_;
  return sequence_;
}

bool LoadStream::IsMeasured(uint64_t sequence) const {
  return first_measured_ <= sequence && sequence <= last_measured_;
}

void LoadStream::BeginMeasuring() {
  const std::lock_guard lock(mutex_);
  measuring_ = true;
  first_measured_ = sequence_ + 1;
}

void LoadStream::EndMeasuring() {
  const std::lock_guard lock(mutex_);
  measuring_ = false;
}

bool LoadStream::AwaitsAcknowledgement() {
  const std::lock_guard lock(mutex_);
  return up_ && acknowledged_sequence_ < last_measured_;
}

void LoadStream::SayGoodbye() {
  const std::lock_guard lock(mutex_);
  if (call_ == nullptr) return;
  v1::StreamTelemetryRequest request;
  request.mutable_goodbye();
  Send(std::move(request));
  leaving_ = true;
}

void LoadStream::Cancel() {
  const std::lock_guard lock(mutex_);
  if (call_ != nullptr) call_->context_.TryCancel();
}

void LoadStream::Send(v1::StreamTelemetryRequest request) {
  waiting_.push_back(std::move(request));
  if (waiting_.size() == 1) WriteNext();
}

void LoadStream::WriteNext() {
  if (!waiting_.empty()) call_->StartWrite(&waiting_.front());
}

void LoadStream::OnResponse(const v1::StreamTelemetryResponse& response) {
  if (response.has_welcome()) OnWelcome(response.welcome());
  if (response.has_acknowledgement()) OnAcknowledgement(response.acknowledgement().sequence());
  if (response.has_switch_command()) OnSwitch(response.switch_command());
  if (response.has_reconnect()) reconnect_delay_ms_ = response.reconnect().delay_ms();
}

void LoadStream::OnWelcome(const v1::Welcome& welcome) {
  session_id_ = welcome.session_id();
  resume_token_ = welcome.resume_token();
  acknowledged_sequence_ = welcome.acknowledged_sequence();
  if (!welcome.resumed()) {
    sequence_ = 0;
    first_measured_ = 1;
    last_measured_ = 0;
  }
  bail_out_ns_ = uint64_t{1'000'000} * welcome.bail_out_ms();
  up_ = true;
  run_.OnWelcome(NowNs() - begun_ns_);
}

void LoadStream::OnAcknowledgement(uint64_t sequence) {
  const uint64_t before = std::exchange(acknowledged_sequence_, sequence);
  const uint64_t first = std::max(before + 1, first_measured_);
  const uint64_t last = std::min(sequence, last_measured_);
  std::optional<int64_t> lag_ns;
  if (timed_sent_ns_ != 0 && sequence >= timed_sequence_) {
    const int64_t sent_ns = std::exchange(timed_sent_ns_, 0);
    if (IsMeasured(timed_sequence_)) lag_ns = NowNs() - sent_ns;
  }
  run_.OnAcknowledged(last >= first ? last - first + 1 : 0, lag_ns);
}

void LoadStream::OnSwitch(const v1::SwitchCommand& command) {
  if (leaving_) return;
  std::optional<int64_t> latency_ns;
  if (command.reason() == v1::SWITCH_REASON_BAIL_OUT && bail_out_sent_ns_ != 0)
    latency_ns = NowNs() - std::exchange(bail_out_sent_ns_, 0);
  run_.OnSwitch(latency_ns);
  arm_ = command.arm();
  ++switch_epoch_;
  v1::StreamTelemetryRequest request;
  request.set_sequence(NextSequence());
  v1::SwitchOutcome& outcome = *request.mutable_switch_outcome();
  outcome.set_command_id(command.command_id());
  outcome.set_arm(arm_);
  outcome.set_switch_epoch(switch_epoch_);
  outcome.set_executed(true);
  outcome.set_reason(command.reason());
  Send(std::move(request));
}

LoadRun::~LoadRun() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  for (const auto& stream : streams_) stream->Cancel();
  AwaitEnd(std::numeric_limits<int64_t>::max());
}

void LoadRun::OnWelcome(int64_t latency_ns) {
  const std::lock_guard lock(mutex_);
  ++result_.welcome_count;
  result_.hello_latency_ms.push_back(static_cast<double>(latency_ns) * 1e-6);
  ++up_count_;
  if (!AllThere() || lost_since_ns_ == 0) return;
  const double seconds = static_cast<double>(NowNs() - std::exchange(lost_since_ns_, 0)) * 1e-9;
  result_.reconnect_s = std::max(result_.reconnect_s.value_or(0), seconds);
}

void LoadRun::OnAcknowledged(uint64_t message_count, std::optional<int64_t> lag_ns) {
  const std::lock_guard lock(mutex_);
  if (!counting_) return;  // acknowledgements that come too late do not count
  result_.acknowledged_count += message_count;
  if (lag_ns) result_.commit_lag_ms.push_back(static_cast<double>(*lag_ns) * 1e-6);
}

void LoadRun::OnEnd(LoadStream& stream, const grpc::Status& status, bool was_up,
                    uint32_t delay_ms) {
  const std::lock_guard lock(mutex_);
  --open_count_;  // the destructor waits until this is 0, then takes mutex_
  if (was_up) --up_count_;
  if (!status.ok() && (last_error_.ok() || !IsFollowUp(status))) last_error_ = status;
  if (ending_) {
    if (status.ok()) ++result_.finished_count;
    return;
  }
  const int64_t now_ns = NowNs();
  if (status.error_code() != grpc::StatusCode::UNAVAILABLE) ++result_.rejected_count;
  if (ReasonOf(status) == v1::ERROR_REASON_SESSION_KICKED) {
    ++kicked_count_;
    return;
  }
  if (was_up && lost_since_ns_ == 0) lost_since_ns_ = now_ns;
  const int64_t min_ns = int64_t{1'000'000} * std::max(delay_ms, 500U);
  std::uniform_int_distribution<int64_t> jitter_ns(0, min_ns);
  lost_.emplace_back(now_ns + min_ns + jitter_ns(random_), &stream);
}

void LoadRun::OnSwitch(std::optional<int64_t> latency_ns) {
  const std::lock_guard lock(mutex_);
  ++result_.switch_count;
  if (latency_ns) result_.decision_latency_ms.push_back(static_cast<double>(*latency_ns) * 1e-6);
}

Status LoadRun::OpenStreams() {
  const uint64_t per_channel = LoadPlan::kMaxStreamsPerChannel;
  const uint64_t channel_count = (plan_.stream_count + per_channel - 1) / per_channel;
  std::vector<std::shared_ptr<grpc::Channel>> channels;
  for (uint64_t i = 0; i < channel_count; ++i) {
    auto channel = OpenChannel(plan_.daemon, /*own_connection=*/true);
    if (!channel.ok()) return channel.status();
    channels.push_back(*std::move(channel));
  }
  for (uint64_t i = 0; i < plan_.stream_count; ++i) {
    streams_.push_back(
        std::make_unique<LoadStream>(channels[i % channel_count], plan_.project,
                                     "scene " + std::to_string(i % plan_.scene_count), *this));
  }
  return {};
}

// Distributes the starts of the streams evenly over one interval of batches, at most
// kLongestSpreadS. If more than kMaxHellosPerSecond streams would start per second, the starts take
// longer.
void LoadRun::ScheduleStarts() {
  const auto count = static_cast<double>(plan_.stream_count);
  const double spread_s = std::max(std::min(1 / plan_.batches_per_second, kLongestSpreadS),
                                   count / kMaxHellosPerSecond);
  const int64_t now_ns = NowNs();
  for (size_t i = 0; i < streams_.size(); ++i) {
    const double share = static_cast<double>(i) / count;
    timers_.emplace(now_ns + static_cast<int64_t>(share * spread_s * 1e9), Timer{i, 0});
  }
}

template <typename Done>
bool LoadRun::RunUntil(int64_t end_ns, Done done) {
  constexpr int64_t kLongestSleepNs = 5'000'000;  // maximum delay before lost streams are checked
  while (true) {
    const int64_t now_ns = NowNs();
    RunDue(now_ns);
    Reconnect(now_ns);
    ShowProgress(now_ns);
    if (done()) return true;
    if (now_ns >= end_ns || stop_()) return false;
    const int64_t next_ns = timers_.empty() ? end_ns : timers_.begin()->first;
    std::this_thread::sleep_for(
        std::chrono::nanoseconds(std::min({next_ns, end_ns, now_ns + kLongestSleepNs}) - NowNs()));
  }
}

void LoadRun::RunDue(int64_t now_ns) {
  while (!timers_.empty() && timers_.begin()->first <= now_ns) {
    const auto [due_ns, timer] = *timers_.begin();
    timers_.erase(timers_.begin());
    Fire(timer, due_ns);
    const auto interval_ns = static_cast<int64_t>(1e9 / plan_.batches_per_second);
    timers_.emplace(due_ns + interval_ns, Timer{timer.stream, timer.batch + 1});
  }
}

void LoadRun::Fire(const Timer& timer, int64_t due_ns) {
  LoadStream& stream = *streams_[timer.stream];
  if (timer.batch == 0) {
    ++open_count_;
    return stream.Connect();
  }
  // Every period-th batch of a stream is followed by a bail-out. Many streams send at the same
  // moment, so they must not all send their bail-out with the same batch. `timer.stream` shifts the
  // count from stream to stream, and `stream / period` also separates streams whose indices differ
  // by a multiple of the period.
  const double share = plan_.bail_out_share;
  const uint64_t period = share > 0 ? std::max<uint64_t>(1, std::llround(1 / share)) : 0;
  const bool with_bail_out =
      period > 0 && (timer.batch + timer.stream + timer.stream / period) % period == 0;
  const bool sent = stream.SendBatch(batch_, with_bail_out);
  const std::lock_guard lock(mutex_);
  if (measuring_) result_.tick_lateness_ms.push_back(static_cast<double>(NowNs() - due_ns) * 1e-6);
  if (!sent) {
    ++result_.unsent_count;
    return;
  }
  ++result_.batch_count;
  if (with_bail_out) ++result_.bail_out_count;
  if (measuring_) ++result_.measured_batch_count;
}

void LoadRun::Reconnect(int64_t now_ns) {
  std::vector<LoadStream*> due;
  {
    const std::lock_guard lock(mutex_);
    std::erase_if(lost_, [&](const auto& lost) {
      if (lost.first > now_ns) return false;
      due.push_back(lost.second);
      return true;
    });
  }
  for (LoadStream* stream : due) {
    ++open_count_;
    stream->Connect();
  }
}

bool LoadRun::AllUpOrRefused() {
  const std::lock_guard lock(mutex_);
  return AllThere() || (result_.welcome_count == 0 && lost_.size() == plan_.stream_count);
}

void LoadRun::AwaitEnd(int64_t end_ns) {
  const auto ended = [this] {
    const std::lock_guard lock(mutex_);
    return open_count_ == 0;
  };
  while (!ended() && NowNs() < end_ns) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

void LoadRun::ShowProgress(int64_t now_ns) {
  if (now_ns < progress_due_ns_) return;
  progress_due_ns_ = now_ns + kSecondNs;
  const std::lock_guard lock(mutex_);
  progress_(std::to_string(up_count_) + " of " + std::to_string(plan_.stream_count) + " streams, " +
            std::to_string(result_.batch_count) + " batches sent");
}

void LoadRun::Measure() {
  const std::optional<double> cpu_before_s = CpuSeconds(plan_.server_pid);
  const std::optional<double> own_before_s = CpuSeconds(getpid());
  const int64_t start_ns = NowNs();
  measuring_ = true;
  for (const auto& stream : streams_) stream->BeginMeasuring();
  RunUntil(start_ns + static_cast<int64_t>(plan_.duration_ns), [] { return false; });
  measuring_ = false;
  for (const auto& stream : streams_) stream->EndMeasuring();
  result_.measured_s = static_cast<double>(NowNs() - start_ns) * 1e-9;
  const std::optional<double> cpu_after_s = CpuSeconds(plan_.server_pid);
  const std::optional<double> own_after_s = CpuSeconds(getpid());
  if (cpu_before_s && cpu_after_s) result_.server_cpu_s = *cpu_after_s - *cpu_before_s;
  if (own_before_s && own_after_s) result_.generator_cpu_s = *own_after_s - *own_before_s;
  AwaitAcknowledgements(NowNs() + static_cast<int64_t>(plan_.commit_patience_ns));
}

void LoadRun::AwaitAcknowledgements(int64_t end_ns) {
  const auto awaited = [](const auto& stream) { return stream->AwaitsAcknowledgement(); };
  while (NowNs() < end_ns && std::any_of(streams_.begin(), streams_.end(), awaited))
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  counting_ = false;
}

Status LoadRun::Shortfall() {
  const std::lock_guard lock(mutex_);
  if (result_.finished_count >= plan_.stream_count ||
      (last_error_.ok() && lost_.empty() && stop_()))
    return {};
  const std::string reason =
      last_error_.ok() ? "the daemon ended the others or did not answer their goodbye in time"
                       : "the last error: " + WithReason(last_error_).error_message();
  return {StatusCode::kUnavailable, std::to_string(result_.finished_count) + " of " +
                                        std::to_string(plan_.stream_count) + " games finished; " +
                                        reason};
}

void LoadRun::SayGoodbye() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  for (const auto& stream : streams_) stream->SayGoodbye();
  AwaitEnd(NowNs() + kPatienceNs);
}

Result<LoadResult> LoadRun::Run() {
  if (plan_.server_pid != 0 && !CpuSeconds(plan_.server_pid)) {
    return Status(StatusCode::kInvalidArgument,
                  "there is no process on this machine with the id " +
                      std::to_string(plan_.server_pid) +
                      "; give --server-pid the id of the daemon, or leave it out");
  }
  if (Status status = OpenStreams(); !status.ok()) return status;
  ScheduleStarts();
  const int64_t last_start_ns = timers_.rbegin()->first;
  RunUntil(last_start_ns + kPatienceNs, [this] { return AllUpOrRefused(); });
  if (const std::lock_guard lock(mutex_); result_.welcome_count == 0) {
    if (last_error_.ok()) last_error_ = {grpc::StatusCode::UNAVAILABLE, "no answer in time"};
    const Status status = ToStatus(last_error_, plan_.daemon);
    if (status.code() == StatusCode::kInvalidArgument) return status;
    return Status(StatusCode::kUnavailable, status.message());
  }
  Measure();
  SayGoodbye();
  result_.shortfall = Shortfall();
  const std::lock_guard lock(mutex_);
  for (auto* figures : {&result_.hello_latency_ms, &result_.decision_latency_ms,
                        &result_.commit_lag_ms, &result_.tick_lateness_ms}) {
    std::sort(figures->begin(), figures->end());
  }
  return result_;
}

}  // namespace

Result<LoadResult> RunLoad(const LoadPlan& plan, const std::function<bool()>& stop,
                           const std::function<void(const std::string&)>& progress) {
  return LoadRun(plan, stop, progress).Run();
}

nlohmann::ordered_json LoadJson(const LoadPlan& plan, const LoadResult& result) {
  const double batches_per_s = static_cast<double>(result.measured_batch_count) / result.measured_s;
  nlohmann::ordered_json json = {
      {"streams", plan.stream_count},
      {"batches_per_s", batches_per_s},
      {"frames_per_s", batches_per_s * plan.batch_frames},
      {"acknowledged_per_s", static_cast<double>(result.acknowledged_count) / result.measured_s},
      {"batches", result.batch_count},
      {"bail_outs", result.bail_out_count},
      {"unsent_batches", result.unsent_count},
      {"rejected", result.rejected_count},
      {"finished", result.finished_count},
      {"measured_s", result.measured_s}};
  const auto add_quantile = [&](const char* name, const std::vector<double>& sorted, double ratio) {
    if (!sorted.empty()) json[name] = Quantile(sorted, ratio);
  };
  add_quantile("hello_latency_ms_p50", result.hello_latency_ms, 0.5);
  add_quantile("hello_latency_ms_p99", result.hello_latency_ms, 0.99);
  add_quantile("decision_latency_ms_p50", result.decision_latency_ms, 0.5);
  add_quantile("decision_latency_ms_p99", result.decision_latency_ms, 0.99);
  add_quantile("commit_lag_ms_p50", result.commit_lag_ms, 0.5);
  add_quantile("commit_lag_ms_p99", result.commit_lag_ms, 0.99);
  add_quantile("tick_lateness_ms_p99", result.tick_lateness_ms, 0.99);
  if (result.reconnect_s) json["reconnect_s"] = *result.reconnect_s;
  if (result.server_cpu_s) json["server_cpu_s"] = *result.server_cpu_s;
  if (result.generator_cpu_s) json["generator_cpu_s"] = *result.generator_cpu_s;
  return json;
}

std::string LoadText(const LoadPlan& plan, const LoadResult& result) {
  TextTable table({"figure", "value"});
  const nlohmann::ordered_json figures = LoadJson(plan, result);
  for (const auto& [name, value] : figures.items()) {
    table.AddRow({name, value.is_number_float() ? Fixed(value.get<double>(), 2) : value.dump()});
  }
  return table.Text();
}

}  // namespace sweepstake::cli
