#include "server/net/http2_guard.h"

#include <algorithm>
#include <cmath>

namespace sweepstake::net {
namespace {

constexpr std::string_view kPreface = "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";
// For browsers. A client that begins with TLS recognises plain text.
constexpr std::string_view kNoHttp2 =
    "HTTP/1.1 400 Bad Request\r\nConnection: close\r\nContent-Type: text/plain\r\n\r\n"
    "This port serves gRPC, over HTTP/2.\n";
constexpr size_t kHeaderBytes = 9;
constexpr size_t kPrefixBytes = 5;
constexpr uint32_t kMaxFrameBytes = 16'384;  // gRPC announces no larger SETTINGS_MAX_FRAME_SIZE
constexpr double kResetSeconds = 10;         // over which resets are averaged

// Types and flags of frames, RFC 9113.
constexpr uint8_t kData = 0, kHeaders = 1, kReset = 3, kGoAway = 7, kWindowUpdate = 8,
                  kContinuation = 9;
constexpr uint8_t kEndStream = 1, kEndHeaders = 4, kPadded = 8;
// Error codes.
constexpr uint32_t kNoError = 0, kCancel = 8;
constexpr char kStatus200 = '\x88';  // the header `:status: 200` (RFC 7541, appendix A)

void AppendNumber(std::string& bytes, uint32_t value, int byte_count) {
  for (int shift = 8 * (byte_count - 1); shift >= 0; shift -= 8)
    bytes.push_back(static_cast<char>(value >> shift));
}

uint32_t NumberOf(std::string_view bytes) {
  uint32_t value = 0;
  for (const char byte : bytes) value = value << 8 | static_cast<uint8_t>(byte);
  return value;
}

void AppendFrameHeader(std::string& bytes, size_t length, uint8_t type, uint8_t flags,
                       uint32_t stream) {
  AppendNumber(bytes, static_cast<uint32_t>(length), 3);
  AppendNumber(bytes, type, 1);
  AppendNumber(bytes, flags, 1);
  AppendNumber(bytes, stream, 4);
}

// Appends a frame RST_STREAM.
void AppendReset(std::string& bytes, uint32_t stream, uint32_t code) {
  AppendFrameHeader(bytes, 4, kReset, 0, stream);
  AppendNumber(bytes, code, 4);
}

// Appends a string literal without Huffman coding (RFC 7541, section 5.2).
void AppendLiteral(std::string& bytes, std::string_view text) {
  constexpr size_t kMaxInPrefix = 127;
  size_t length = text.size();
  AppendNumber(bytes, static_cast<uint32_t>(std::min(length, kMaxInPrefix)), 1);
  if (length >= kMaxInPrefix) {
    length -= kMaxInPrefix;
    for (; length >= 128; length /= 128)
      AppendNumber(bytes, static_cast<uint32_t>(length % 128 + 128), 1);
    AppendNumber(bytes, static_cast<uint32_t>(length), 1);
  }
  bytes += text;
}

// Appends a frame HEADERS that ends the call. `is_first`: gRPC has sent no headers for it.
void AppendStatus(std::string& bytes, uint32_t stream, const Http2Guard::Headers& status,
                  bool is_first) {
  std::string block;
  const auto append = [&](std::string_view name, std::string_view value) {
    block.push_back(0);  // a literal that is not added to the dynamic table
    AppendLiteral(block, name);
    AppendLiteral(block, value);
  };
  if (is_first) {
    block.push_back(kStatus200);
    append("content-type", "application/grpc");
  }
  for (const auto& [name, value] : status) append(name, value);
  AppendFrameHeader(bytes, block.size(), kHeaders, kEndHeaders | kEndStream, stream);
  bytes += block;
}

}  // namespace

Http2Guard::Frame Http2Guard::HeaderOf(std::string_view bytes) {
  return {.length = NumberOf(bytes.substr(0, 3)),
          .type = static_cast<uint8_t>(bytes[3]),
          .flags = static_cast<uint8_t>(bytes[4]),
          .stream = NumberOf(bytes.substr(5, 4)) & 0x7FFFFFFF};
}

bool Http2Guard::FromClient(std::string_view bytes, int64_t now_ns, std::string& to_server) {
  while (preface_count_ < kPreface.size() && !bytes.empty()) {
    if (bytes.front() != kPreface[preface_count_]) {
      answers_ = kNoHttp2;
      return Close(Http2Refusal::kNotHttp2);
    }
    to_server.push_back(bytes.front());
    bytes.remove_prefix(1);
    ++preface_count_;
  }
  // Parse the given bytes in place, unless an incomplete frame waits for them.
  std::string joined;
  if (!from_client_.empty()) {
    joined = std::move(from_client_);
    joined += bytes;
    bytes = joined;
  }
  from_client_.clear();
  while (bytes.size() >= kHeaderBytes) {
    const Frame frame = HeaderOf(bytes);
    if (frame.length > kMaxFrameBytes) return Close(Http2Refusal::kNotHttp2);
    if (bytes.size() < kHeaderBytes + frame.length) break;
    if (!TakeFrame(frame, bytes.substr(kHeaderBytes, frame.length), now_ns)) return false;
    // After a GOAWAY nothing of a further call is forwarded. gRPC then no longer has the state of
    // the headers' compression, but it gets no further headers either.
    const bool is_forwarded =
        !is_going_away_ || (frame.stream <= last_stream_ && frame.type != kHeaders);
    if (is_forwarded) to_server += bytes.substr(0, kHeaderBytes + frame.length);
    if (!is_forwarded && frame.type == kData && frame.length > 0) {
      // gRPC does not get these bytes, so it does not enlarge the connection's window again.
      AppendFrameHeader(answers_, 4, kWindowUpdate, 0, 0);
      AppendNumber(answers_, frame.length, 4);
    }
    bytes.remove_prefix(kHeaderBytes + frame.length);
    if (in_client_headers_) continue;
    to_server += resets_to_server_;
    resets_to_server_.clear();
  }
  from_client_ = bytes;
  return true;
}

bool Http2Guard::TakeFrame(const Frame& frame, std::string_view payload, int64_t now_ns) {
  if (in_client_headers_ != (frame.type == kContinuation)) return Close(Http2Refusal::kNotHttp2);
  if (frame.type == kHeaders || frame.type == kContinuation)
    in_client_headers_ = (frame.flags & kEndHeaders) == 0;
  // gRPC ignores calls with an even number, which clients must not use.
  if (frame.type == kHeaders && frame.stream % 2 == 0) return Close(Http2Refusal::kNotHttp2);
  if (frame.type == kHeaders && frame.stream > last_stream_) {
    if (!is_going_away_) Begin(frame, now_ns);
  } else if (frame.type == kHeaders && (frame.flags & kEndStream) != 0) {
    EndRequests(frame.stream);
  } else if (frame.type == kData) {
    return TakeData(frame, payload);
  } else if (frame.type == kReset && streams_.contains(frame.stream)) {
    Forget(frame.stream);
    CountReset(now_ns);
  }
  return true;
}

void Http2Guard::Begin(const Frame& frame, int64_t now_ns) {
  const bool is_shared_out = all_->calls >= limits_.of_all.calls && use_.calls > 0;
  if (is_shared_out || use_.calls >= limits_.of_connection.calls)
    return GoAway(Http2Refusal::kWaitingCalls);
  last_stream_ = frame.stream;
  // gRPC answers a call whose client ends it without a message.
  const bool has_ended = (frame.flags & kEndStream) != 0;
  streams_.emplace(frame.stream, Stream{.has_message = has_ended});
  if (has_ended) return;
  Add(1, 0);
  while (!begun_.empty() && !Waits(begun_.front().second)) begun_.pop_front();
  begun_.emplace_back(now_ns, frame.stream);
}

void Http2Guard::GoAway(Http2Refusal why) {
  if (std::exchange(is_going_away_, true)) return;
  on_refusal_(why);
  AppendFrameHeader(answers_, 8, kGoAway, 0, 0);
  AppendNumber(answers_, last_stream_, 4);
  AppendNumber(answers_, kNoError, 4);
}

// The average decreases by the factor e in kResetSeconds.
void Http2Guard::CountReset(int64_t now_ns) {
  const double passed_s = static_cast<double>(now_ns - reset_ns_) * 1e-9;
  resets_ = 1 + resets_ * std::exp(-std::max(passed_s, 0.0) / kResetSeconds);
  reset_ns_ = now_ns;
  if (resets_ > kResetSeconds * limits_.max_resets_per_s) GoAway(Http2Refusal::kResets);
}

bool Http2Guard::TakeData(const Frame& frame, std::string_view payload) {
  const auto found = streams_.find(frame.stream);
  if (found == streams_.end()) return true;  // gRPC ignores the data of a call that has ended
  if ((frame.flags & kPadded) != 0) {
    if (payload.empty() || payload.size() <= static_cast<uint8_t>(payload.front()))
      return Close(Http2Refusal::kNotHttp2);
    payload = payload.substr(1, payload.size() - 1 - static_cast<uint8_t>(payload.front()));
  }
  const Http2Refusal why = Scan(found->second, payload);
  if (why != Http2Refusal::kNotHttp2) {
    Refuse(frame.stream, why);
  } else if ((frame.flags & kEndStream) != 0) {
    EndRequests(frame.stream);
  }
  return true;
}

// The client has sent everything. gRPC answers a message that is not complete.
void Http2Guard::EndRequests(uint32_t id) {
  const auto found = streams_.find(id);
  if (found == streams_.end()) return;
  Stream& stream = found->second;
  Add(0, -int64_t{stream.missing});
  stream.missing = 0;
  EndMessage(stream);
}

Http2Refusal Http2Guard::Scan(Stream& stream, std::string_view data) {
  while (!data.empty()) {
    if (stream.missing > 0) {
      const size_t taken = std::min<size_t>(stream.missing, data.size());
      data.remove_prefix(taken);
      stream.missing -= static_cast<uint32_t>(taken);
      Add(0, -static_cast<int64_t>(taken));
      if (stream.missing == 0) EndMessage(stream);
      continue;
    }
    const auto byte = static_cast<uint8_t>(data.front());
    data.remove_prefix(1);
    if (stream.prefix_count == 0 && byte != 0) return Http2Refusal::kCompressedMessage;
    stream.length = stream.length << 8 | byte;
    if (++stream.prefix_count < kPrefixBytes) continue;
    if (stream.length > limits_.max_message_bytes) return Http2Refusal::kLongMessage;
    stream.missing = std::exchange(stream.length, 0);
    stream.prefix_count = 0;
    Add(0, stream.missing);
    if (stream.missing == 0) EndMessage(stream);
    const bool is_shared_out = all_->bytes > limits_.of_all.bytes && use_.bytes > stream.missing;
    if (is_shared_out || use_.bytes > limits_.of_connection.bytes)
      return Http2Refusal::kWaitingBytes;
  }
  return Http2Refusal::kNotHttp2;
}

void Http2Guard::EndMessage(Stream& stream) {
  if (stream.has_message) return;
  stream.has_message = true;
  Add(-1, 0);
}

void Http2Guard::Add(int64_t calls, int64_t bytes) {
  for (Http2Use* use : {&use_, all_.get()}) {
    use->calls += static_cast<uint64_t>(calls);
    use->bytes += static_cast<uint64_t>(bytes);
  }
}

Http2Guard::~Http2Guard() {
  all_->calls -= use_.calls;
  all_->bytes -= use_.bytes;
}

void Http2Guard::Forget(uint32_t id) {
  const auto found = streams_.find(id);
  if (found == streams_.end()) return;
  Add(found->second.has_message ? 0 : -1, -int64_t{found->second.missing});
  streams_.erase(found);
}

void Http2Guard::EndLateCalls(int64_t now_ns, std::string& to_server) {
  while (!begun_.empty()) {
    const auto& [begin_ns, id] = begun_.front();
    const bool waits = Waits(id);
    if (waits && now_ns - begin_ns < limits_.first_message_patience_ns) break;
    if (waits) Refuse(id, Http2Refusal::kLateMessage);
    begun_.pop_front();
  }
  if (in_client_headers_) return;
  to_server += resets_to_server_;
  resets_to_server_.clear();
}

bool Http2Guard::Waits(uint32_t id) const {
  const auto found = streams_.find(id);
  return found != streams_.end() && !found->second.has_message;
}

void Http2Guard::Refuse(uint32_t id, Http2Refusal why) {
  AppendStatus(answers_, id, on_refusal_(why), !streams_.at(id).has_answer);
  AppendReset(answers_, id, kNoError);  // the client shall send nothing more
  AppendReset(resets_to_server_, id, kCancel);
  Forget(id);
  if (++refusal_count_ > limits_.max_refusals) GoAway(Http2Refusal::kRefusals);
}

bool Http2Guard::Close(Http2Refusal why) {
  on_refusal_(why);
  return false;
}

void Http2Guard::FromServer(std::string_view bytes, std::string& to_client) {
  while (!bytes.empty()) {
    if (server_missing_ > 0) {
      const size_t taken = std::min<size_t>(server_missing_, bytes.size());
      if (!drops_server_frame_) to_client += bytes.substr(0, taken);
      bytes.remove_prefix(taken);
      server_missing_ -= static_cast<uint32_t>(taken);
      continue;
    }
    TakeAnswers(to_client);
    const size_t taken = std::min(kHeaderBytes - server_header_.size(), bytes.size());
    server_header_ += bytes.substr(0, taken);
    bytes.remove_prefix(taken);
    if (server_header_.size() < kHeaderBytes) return;
    const Frame frame = HeaderOf(server_header_);
    // After the guard's GOAWAY, one of gRPC could allow further calls.
    drops_server_frame_ = is_going_away_ && frame.type == kGoAway;
    if (!drops_server_frame_) to_client += server_header_;
    server_header_.clear();
    server_missing_ = frame.length;
    NoteServerFrame(frame);
  }
  TakeAnswers(to_client);
}

void Http2Guard::NoteServerFrame(const Frame& frame) {
  if (frame.type == kHeaders || frame.type == kContinuation)
    in_server_headers_ = (frame.flags & kEndHeaders) == 0;
  const bool can_end = frame.type == kHeaders || frame.type == kData;
  if (frame.type == kReset || (can_end && (frame.flags & kEndStream) != 0)) {
    Forget(frame.stream);
  } else if (const auto found = streams_.find(frame.stream); can_end && found != streams_.end()) {
    found->second.has_answer = true;
  }
}

bool Http2Guard::is_done() const {
  return is_going_away_ && streams_.empty() && answers_.empty() && server_missing_ == 0 &&
         server_header_.empty() && !in_server_headers_;
}

void Http2Guard::TakeAnswers(std::string& to_client) {
  if (server_missing_ > 0 || in_server_headers_) return;
  to_client += answers_;
  answers_.clear();
}

}  // namespace sweepstake::net
