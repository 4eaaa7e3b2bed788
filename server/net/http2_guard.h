// Checks what a client sends over HTTP/2 before gRPC reads it.
//
// gRPC 1.51 uses memory before it checks. It buffers a message up to its announced length, it
// inflates compressed messages, and it holds calls whose message never arrives. Once its memory
// quota is exceeded, it ends calls of other clients. This guard ends such a call itself, before
// gRPC reads the message, and sends the client a gRPC status.
//
// A connection with too many calls gets a GOAWAY. Its calls go on, and the client makes further
// calls on another connection. Memory that gRPC has used for a refused call is not given back at
// once, so refusing each of them would not help.
//
// The guard reads the frames of one connection (RFC 9113) and the prefix of each gRPC message in
// DATA frames: one byte that is 1 if the message is compressed, and its length in four bytes. It
// forwards every frame unchanged, also those of a call that it has ended: gRPC has received a
// RST_STREAM for that call and ignores them. It does not decode headers. The headers that it sends
// leave the compression state of the connection unchanged (RFC 7541, section 6.2.2).
//
// Plain values; one thread at a time. The memory is bounded by one frame and the open calls.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

namespace sweepstake::net {

// What gRPC holds in memory for messages that are not complete.
struct Http2Use {
  uint64_t calls = 0;  // calls without a complete first message
  uint64_t bytes = 0;  // missing bytes of incomplete messages
};

struct Http2Limits {
  uint32_t max_message_bytes = 0;
  // The first message of a call must be complete after this time.
  int64_t first_message_patience_ns = 10'000'000'000;
  Http2Use of_connection = {.calls = 20, .bytes = 1024 * 1024};
  // The use of all connections together. Beyond it, a connection may have one call and one message.
  Http2Use of_all = {.calls = 500, .bytes = 16 * 1024 * 1024};
  // Calls per second that the client may reset, on average over ten seconds.
  uint32_t max_resets_per_s = 100;
  // Calls of a connection that the guard refuses, before the connection gets a GOAWAY.
  uint32_t max_refusals = 3;
};

// Why the guard has ended a call or a connection.
enum class Http2Refusal : uint8_t {
  kLongMessage,
  kCompressedMessage,
  kWaitingBytes,
  kLateMessage,
  kWaitingCalls,
  kResets,
  kRefusals,
  kNotHttp2,
};

class Http2Guard {
 public:
  // Names in lower case, and values in ASCII.
  using Headers = std::vector<std::pair<std::string, std::string>>;
  // Called for each call or connection that the guard ends. Returns the headers that state the
  // status of the call (grpc-status, grpc-message).
  using OnRefusal = std::function<Headers(Http2Refusal)>;

  // `all` counts the use of all connections together. The guards that share it use one thread.
  Http2Guard(const Http2Limits& limits, std::shared_ptr<Http2Use> all, OnRefusal on_refusal)
      : limits_(limits), all_(std::move(all)), on_refusal_(std::move(on_refusal)) {}
  ~Http2Guard();
  Http2Guard(const Http2Guard&) = delete;
  Http2Guard& operator=(const Http2Guard&) = delete;

  // Takes bytes of the client, and appends what gRPC shall read to `to_server`. Returns false if
  // the connection must be closed, after the client has got what TakeAnswers appends.
  bool FromClient(std::string_view bytes, int64_t now_ns, std::string& to_server);
  // Takes bytes of gRPC, and appends what the client shall read to `to_client`.
  void FromServer(std::string_view bytes, std::string& to_client);
  // Ends the calls whose first message is late. Call it about once per second while
  // waiting_call_count() > 0.
  void EndLateCalls(int64_t now_ns, std::string& to_server);
  // Appends the answers to refused calls to `to_client`, unless a frame of gRPC is incomplete. Call
  // it after FromClient and EndLateCalls; FromServer does the same.
  void TakeAnswers(std::string& to_client);

  uint64_t waiting_call_count() const { return use_.calls; }
  // Returns whether the connection got a GOAWAY and its last call has ended. Close it then.
  bool is_done() const;
  size_t open_call_count() const { return streams_.size(); }

 private:
  struct Frame {
    uint32_t length = 0;  // of the payload
    uint8_t type = 0;
    uint8_t flags = 0;
    uint32_t stream = 0;
  };
  // A call that neither side has ended.
  struct Stream {
    uint32_t prefix_count = 0;  // bytes of the next message's prefix that have arrived
    uint32_t length = 0;        // of the message, as far as its prefix has arrived
    uint32_t missing = 0;       // bytes of the message that have not arrived
    bool has_message = false;   // a message has arrived
    bool has_answer = false;    // gRPC has sent headers
  };

  static Frame HeaderOf(std::string_view bytes);
  // Returns false if the connection must be closed.
  bool TakeFrame(const Frame& frame, std::string_view payload, int64_t now_ns);
  bool TakeData(const Frame& frame, std::string_view payload);
  void Begin(const Frame& frame, int64_t now_ns);
  void CountReset(int64_t now_ns);
  // Accepts no further calls.
  void GoAway(Http2Refusal why);
  // Returns why the call must end; kNotHttp2 if it may go on.
  Http2Refusal Scan(Stream& stream, std::string_view data);
  void EndMessage(Stream& stream);
  void EndRequests(uint32_t id);
  // Returns whether the call waits for its first message.
  bool Waits(uint32_t id) const;
  // Adds to the use of the connection and of all connections.
  void Add(int64_t calls, int64_t bytes);
  void Forget(uint32_t id);
  void Refuse(uint32_t id, Http2Refusal why);
  bool Close(Http2Refusal why);
  void NoteServerFrame(const Frame& frame);

  const Http2Limits limits_;
  const std::shared_ptr<Http2Use> all_;
  const OnRefusal on_refusal_;
  std::unordered_map<uint32_t, Stream> streams_;
  std::deque<std::pair<int64_t, uint32_t>> begun_;  // calls in the order in which they began
  Http2Use use_;
  uint32_t last_stream_ = 0;  // the latest accepted call
  bool is_going_away_ = false;
  uint32_t refusal_count_ = 0;
  double resets_ = 0;  // recent resets; older ones count less (CountReset)
  int64_t reset_ns_ = 0;

  std::string from_client_;  // an incomplete frame
  size_t preface_count_ = 0;
  bool in_client_headers_ = false;  // between HEADERS and the end of its CONTINUATION frames
  std::string resets_to_server_;    // frames that wait for the end of the client's headers

  std::string server_header_;  // an incomplete frame header
  uint32_t server_missing_ = 0;
  bool in_server_headers_ = false;
  bool drops_server_frame_ = false;
  std::string answers_;  // frames that wait for the end of gRPC's frame
};

}  // namespace sweepstake::net
