// Speaks HTTP over a plain socket on loopback, so that tests can also send what no client would.
#pragma once

#include <string>
#include <string_view>

namespace sweepstake::test_support {

// A connection that ends with the object. A server that says nothing for a minute ends the test
// program.
class HttpSocket {
 public:
  // With `receive_bytes` the system takes little that is not read.
  explicit HttpSocket(int port, int receive_bytes = 0);
  ~HttpSocket();
  HttpSocket(const HttpSocket&) = delete;
  HttpSocket& operator=(const HttpSocket&) = delete;

  void Send(std::string_view bytes);
  // Returns what comes until the server ends the connection.
  std::string ReadAll();
  // Returns one answer with a Content-Length.
  std::string ReadAnswer();
  // Returns what comes up to the text, or all of it if the server ends the connection before.
  std::string ReadUntil(std::string_view text);

 private:
  // Returns false at the end of the connection.
  bool ReadMore();

  int socket_;
  std::string unread_;
};

struct HttpAnswer {
  int status = 0;
  std::string head;
  std::string body;
};

// Sends `request` and reads until the server ends the connection.
HttpAnswer Exchange(int port, std::string_view request);

// Gets a page.
HttpAnswer Get(int port, const std::string& target);

}  // namespace sweepstake::test_support
